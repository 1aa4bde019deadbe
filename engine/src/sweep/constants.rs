//! Every constant that decides something about a sweep, its unit and where it comes from.

use crate::geometry::NoiseLaw;

/// Range up to which "nothing came back" proves free space, metres: the guaranteed range of the URG-04LX
/// (scip2 section 1: 20-4095 mm).
pub const FREE_RANGE_M: f64 = 4.0;

/// Share of beams that must have hit something for a sweep to be worth judging; a covered or blinded laser has
/// almost none. Open places have up to 56 % codes (scip2 section 7, large room).
pub const LEAST_HIT_SHARE: f64 = 0.05;

/// Widest sector, radians, of which a line may tell nothing at all: things that swallow the light are seen by codes too, but a
/// black cupboard 1 m wide at 2 m is 28 deg.
pub const FEWEST_BLIND_RAD: f64 = std::f64::consts::FRAC_PI_6;

/// Share of a sector's beams that must be codes of a sensor that cannot tell: with the lens covered it is all of them, in
/// sight of things one in twenty (scip2 section 7).
pub const BLIND_SECTOR_SHARE: f64 = 0.9;

/// Lines with a blind sector from which a sweep is not judged: the height of the same cupboard is 40 lines, but it is not as wide.
pub const MOST_BLIND_LINES: usize = 10;

/// So many scans in a row with the very same ranges are frozen data: with 2 mm of noise on 1 mm steps two equal
/// scans do not occur (scip2 section 11).
pub const FROZEN_SCANS: usize = 3;

/// Positions by which polls may leave the fitted motion, over and above what their own timing explains
/// (sweep-geometry section 3: more than 2 positions for 3 polls is a stall).
pub const STALL_POSITIONS: f64 = 2.0;

/// See [`STALL_POSITIONS`].
pub const STALL_POLLS: usize = 3;

/// Fewest polls of a moving axis that a fit may stand on: at 60 polls a second these are a few tenths of a second.
pub const LEAST_POLLS: usize = 5;

/// Stamp distance, in scan periods, above which scans between were lost: half a period more than one.
pub const GAP_PERIODS: f64 = 1.5;

/// Clock rates further from 1 than this are no clock's: ten times the URG's 0.13 % (scip2 section 8).
pub const MOST_RATE_ERROR: f64 = 0.013;

/// Shortest time between two clock exchanges from which a rate is taken, seconds: 1 ms of either end is then
/// below 0.05 %.
pub const LEAST_RATE_SPAN_S: f64 = 2.0;

/// Range noise of the URG-04LX: 2.1 mm at 0.5 m, 2.9 at 1.25, 3.5 at 2.5 m with the robot standing still in a
/// static scene, 7-14 mm at 2-4 m in a large room (both scip2 section 11); the law lies between the two.
pub const URG_NOISE: NoiseLaw = NoiseLaw {
    at_zero_m: 0.002,
    per_m: 0.0015,
};

/// Widest angle between two neighbouring lines of a leg, radians: the side of the smallest thing that passes the gates
/// of a novelty, some 1e-3 sr (novelty settings, `u_th_m`). At 0.5 deg two lines in a row may be missing. Sweeps with
/// lines further apart than that promise less: see [`MOST_GAP_PITCHES`].
pub const MOST_GAP_RAD: f64 = 0.0316;

/// Widest gap of a sweep whose own pitch exceeds [`MOST_GAP_RAD`], in pitches: half a pitch more than one.
pub const MOST_GAP_PITCHES: f64 = 1.5;

/// Most that the clock's or the head's uncertainty may displace a beam, in line pitches: beyond one the lines could
/// stand in another order.
pub const MOST_DISPLACEMENT_PITCHES: f64 = 1.0;

/// Lines of a leg nearer together than this, in pitches, count once: a repeated line makes up for no missing one.
pub const SAME_LINE_PITCHES: f64 = 0.5;

/// Most lines that a leg may ask for: at 0.001 deg a whole turn has 360 000. More is no plan but a damaged record.
pub const MOST_LINES: f64 = 1e6;

/// Furthest that the laser may be from the one origin of a sweep, metres. A ray is taken to start at the origin, so a
/// shadow's edge is misplaced by up to that much, and points within 0.15 m of a thing belong to it (novelty settings,
/// `grow_within_m`): further off, edges would be things of their own.
pub const MOST_OFF_ORIGIN_M: f64 = 0.15;
