//! Every figure that decides about pairs and their truth, with its unit and origin. "Chosen": plausible, and nothing
//! but how hard the pairs are depends on it. Sizes of furniture stand with their pieces.

/// Scenes drawn before a pair is given up. Chosen: the worst pair of 2000 needs some dozens.
pub const ATTEMPTS: usize = 400;
/// Fewest points of a standard sweep by which a large change must show: what fewer beams meet is no large change.
pub const LEAST_POINTS: usize = 60;
/// Least share of a ball's outline in view: balls are promised for full view, and rims are lost to rounding.
pub const LEAST_IN_VIEW: f64 = 0.95;
/// Furthest from the robot that a thing is put, metres. Chosen: the sensor's guaranteed range and a bit.
pub const FURTHEST_M: f64 = 4.5;
/// Air around what is put somewhere, metres. Chosen.
pub const GAP_M: f64 = 0.05;
/// Least angle that a door turns by, degrees. Chosen: less moves its edge by less than 0.3 m.
pub const LEAST_SWING_DEG: f64 = 20.0;
/// A thing that moved did so by more than this many times its size in plan.
pub const LEAST_MOVE: f64 = 1.05;
/// Most roll and pitch between visits, degrees, and height, metres, where the floor is uneven. Chosen.
pub const UNEVEN: (f64, f64) = (0.3, 0.005);

/// Surfaces nearer together than this, as seen from the other visit, are one place that did not change, metres: the
/// thickness of a door's leaf and its noise.
pub const SAME_M: f64 = 0.05;
/// The other visit looked through a place if what it met lies this far behind, metres. Chosen: twice the above.
pub const THROUGH_M: f64 = 0.10;

/// Reach of the URG-04LX, metres (PP `DMAX`).
pub const URG_REACH_M: f64 = 5.6;
/// First and last measuring step of the URG-04LX (PP `AMIN`, `AMAX`).
pub const URG_STEPS: (u32, u32) = (44, 725);
/// Lines of a sweep: 0.5 deg apart over 60 deg.
pub const LINES: usize = 120;
/// Lines of a coarse revisit, least and most.
pub const COARSE_LINES: (usize, usize) = (40, 60);
/// Tilt of a sweep's first row, degrees, least and most: the pan-tilt's limit and what 60 deg ask for.
pub const FROM_DEG: (f64, f64) = (-47.0, -35.0);
/// Tilt of its last row.
pub const TO_DEG: (f64, f64) = (25.0, 31.0);
/// Makers' bound of a range's error, metres below 1 m and per metre above (URG-04LX data sheet).
pub const BOUND: f64 = 0.01;
/// Noise of the mild sensor, metres. Chosen: the recorded one near by.
pub const MILD_SIGMA_M: f64 = 0.003;
/// Drift of ranges between visits, millimetres: warming up.
pub const DRIFT_MM: f64 = 15.0;
/// Share of beams that lose their target, least and most (recordings: 2-20 % flicker).
pub const FLICKER: (f64, f64) = (0.02, 0.2);

/// Reach of the held-out sensor, metres. It and what follows: chosen, unlike the URG's.
pub const RINGS_REACH_M: f64 = 15.0;
/// Range up to which nothing coming back proves free space, metres.
pub const RINGS_FREE_M: f64 = 10.0;
/// One sigma as a share of the range.
pub const RINGS_SIGMA: f64 = 0.01;
/// Most that one sweep's ranges are all too long or short, as a share of the range.
pub const RINGS_SCALE: f64 = 0.002;
/// Jump between neighbours that is an edge, metres, and the share of edges with a range in between.
pub const RINGS_EDGE: (f64, f64) = (0.2, 0.3);
/// Elevation of the lowest and highest ring, and half the width of a ring, degrees.
pub const RINGS_FIELD_DEG: (f64, f64, f64) = (-40.0, 30.0, 135.0);
/// Angle between beams and between rings, degrees.
pub const RINGS_APART_DEG: f64 = 0.5;
/// Height of the head over the base, metres.
pub const RINGS_HEAD_M: f64 = 0.18;
