//! Every constant that decides something about a sweep, with its unit and origin.

use crate::geometry::NoiseLaw;

/// Range up to which a beam without a return proves free space, metres: the guaranteed range of the URG-04LX (scip2
/// section 1: 20-4095 mm).
pub const FREE_RANGE_M: f64 = 4.0;

/// Smallest share of beams with a return: a covered or blinded laser has almost none, a large room up to 56 % codes (scip2
/// section 7).
pub(super) const MIN_HIT_SHARE: f64 = 0.05;

/// Widest sector of a line without a measurement, radians. Objects that absorb the light give codes too, but a black
/// cupboard 1 m wide at 2 m fills 28 deg.
pub(super) const MAX_UNKNOWN_SECTOR_RAD: f64 = std::f64::consts::FRAC_PI_6;

/// Parts into which [`MAX_UNKNOWN_SECTOR_RAD`] is divided; so many blind parts in a row are a blind sector. Chosen: one part
/// would miss half of the sectors, sixteen would be sensitive to single beams.
pub(super) const BLIND_PARTS: usize = 4;

/// Smallest share of beams without a measurement in a blind part: with a covered lens it is all of them, otherwise one in
/// twenty (scip2 section 7).
pub(super) const BLIND_SECTOR_SHARE: f64 = 0.9;

/// Lines with a blind sector from which on a sweep is not used. Chosen: the cupboard of [`MAX_UNKNOWN_SECTOR_RAD`] is 40
/// lines high, but not as wide.
pub(super) const MAX_BLIND_LINES: usize = 10;

/// So many scans in a row with equal ranges are frozen data: with 2 mm of noise on 1 mm steps two equal scans do not occur
/// (scip2 section 11).
pub(super) const FROZEN_SCANS: usize = 3;

/// Distance of polls from the fitted motion, counts, beyond what their own timing explains, above which the head has
/// stalled (sweep-geometry section 3: more than 2 positions for 3 polls).
pub(super) const STALL_COUNTS: f64 = 2.0;

/// So many polls in a row at [`STALL_COUNTS`] are a stall.
pub(super) const STALL_POLLS: usize = 3;

/// Fewest polls of a moving head for a fit. Chosen: a tenth of a second at 60 polls a second.
pub(super) const MIN_POLLS: usize = 5;

/// Distance of two stamps, in scan periods, above which a scan between them was lost: half a period more than one.
pub(super) const GAP_PERIODS: f64 = 1.5;

/// Largest deviation of a clock's rate from 1: ten times the 0.13 % of the URG (scip2 section 8).
pub(super) const MAX_RATE_ERROR: f64 = 0.013;

/// Shortest time between two time exchanges that give a rate, seconds: the stamp's millisecond is then below 0.05 %.
pub(super) const MIN_RATE_SPAN_S: f64 = 2.0;

/// Resolution of the sensor's stamps, seconds (scip2 section 8).
pub(super) const STAMP_ROUNDING_S: f64 = 1e-3;

/// Range noise of the URG-04LX: 2.1 mm at 0.5 m, 2.9 at 1.25, 3.5 at 2.5 m with a stationary robot in a static
/// scene, 7-14 mm at 2-4 m in a large room (both scip2 section 11); the law lies between the two.
pub const URG_NOISE: NoiseLaw = NoiseLaw {
    at_zero_m: 0.002,
    per_m: 0.0015,
};

/// Widest angle between neighbouring lines of a pan segment, radians: the side of the smallest object that passes the gates
/// of a novelty, some 1e-3 sr (docs/novelty.md section 6). At 0.5 deg two lines in a row may be missing. For sweeps with a
/// wider pitch see [`MAX_GAP_PITCHES`].
pub(super) const MAX_GAP_RAD: f64 = 0.0316;

/// Widest gap of a sweep whose pitch exceeds [`MAX_GAP_RAD`], in pitches: half a pitch more than one.
pub(super) const MAX_GAP_PITCHES: f64 = 1.5;

/// Largest displacement of a beam by the uncertainty of clock or head, in pitches: beyond one the lines could be in another
/// order.
pub(super) const MAX_DISPLACEMENT_PITCHES: f64 = 1.0;

/// Lines of a pan segment nearer together than this, in pitches, count once: a repeated line replaces no missing one.
pub(super) const SAME_LINE_PITCHES: f64 = 0.5;

/// Most lines of a pan segment: at 0.001 deg a full turn has 360 000. More are a damaged record.
pub(super) const MAX_LINES: f64 = 1e6;

/// Largest distance of the laser from the origin of a sweep, metres. A ray is taken to start at the origin, so the edge of a
/// shadow is displaced by up to that distance. Points within 0.15 m of a novelty belong to it (docs/novelty.md section 6);
/// edges displaced further would be novelties of their own.
pub(super) const MAX_ORIGIN_DISTANCE_M: f64 = 0.15;
