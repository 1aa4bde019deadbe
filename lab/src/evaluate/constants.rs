//! Constants of the pairs and their truth. "Chosen": plausible, and only how hard the pairs are depends on it. Sizes of
//! furniture are in `furniture.rs` and `places`.

/// Scenes drawn before a pair is given up. Chosen: the worst pair of 2000 needs some dozens.
pub(crate) const MAX_SCENES: usize = 400;
/// Share of the quiet visits to a place that lie below its U_th.
pub(crate) const QUIET_SHARE: f64 = 0.95;
/// Points of a standard sweep by which a large change must be visible at least.
pub(crate) const MIN_VISIBLE_POINTS: usize = 60;
/// Least visible share of a ball's outline: balls are to be in full view, less the rounding at the rim.
pub(crate) const MIN_SHARE_IN_VIEW: f64 = 0.95;
/// Greatest distance of a new object from the robot, metres. Chosen: a little over the sensor's guaranteed range.
pub(crate) const MAX_DISTANCE_M: f64 = 4.5;
/// Free space around a new object, metres. Chosen.
pub(crate) const GAP_M: f64 = 0.05;
/// Least angle that a door turns by, degrees. Chosen: less moves its edge by less than 0.3 m.
pub(crate) const MIN_SWING_DEG: f64 = 20.0;
/// Least distance that an object moves, in units of its size in plan.
pub(crate) const MIN_MOVE_SIZES: f64 = 1.05;
/// Greatest roll and pitch between visits, degrees, and height, metres, where the floor is uneven. Chosen.
pub(crate) const UNEVEN_FLOOR: (f64, f64) = (0.3, 0.005);
/// Attempts to put a piece of furniture into a place.
pub(crate) const FURNITURE_TRIES: usize = 30;
/// Attempts to put the robot into a place.
pub(crate) const ROBOT_TRIES: usize = 10 * FURNITURE_TRIES;
/// Attempts to find a free position for a new object.
pub(crate) const POSITION_TRIES: usize = 60;
/// Attempts to find a position for a ball.
pub(crate) const BALL_TRIES: usize = 40;
/// Half the free square that the robot needs in a place, metres.
pub(crate) const ROBOT_CLEARANCE_M: f64 = 0.45;
/// Half the square that the robot occupies, metres.
pub(crate) const ROBOT_HALF_M: f64 = 0.3;
/// Height of the laser over the pan-tilt's base, the head level, metres.
pub(crate) const LASER_OVER_BASE_M: f64 = 0.1796;

/// Surfaces nearer together than this along the ray of the other visit are one unchanged surface, metres: a door leaf and
/// its noise.
pub(crate) const ON_SURFACE_M: f64 = 0.05;
/// The other visit saw through a point if it hit something this far behind it, metres. Chosen: twice the above.
pub(crate) const SEEN_THROUGH_M: f64 = 0.10;

/// Reach of the URG-04LX, metres (PP `DMAX`).
pub(crate) const URG_REACH_M: f64 = 5.6;
/// First and last measuring step of the URG-04LX (PP `AMIN`, `AMAX`).
pub(crate) const URG_STEPS: (u32, u32) = (44, 725);
/// Smallest range of the URG-04LX, mm (PP `DMIN`); smaller values are codes.
pub(crate) const MIN_RANGE_MM: u32 = 20;
/// Time between lines of a sweep, milliseconds.
pub(crate) const SCAN_PERIOD_MS: u64 = 100;
/// Lines of a sweep: 0.5 deg apart over 60 deg.
pub(crate) const LINES: usize = 120;
/// Lines of a coarse revisit, from and to.
pub(crate) const COARSE_LINES: (usize, usize) = (40, 60);
/// Tilt of the first row of a sweep, degrees, from and to: the pan-tilt's limit, and what 60 deg need.
pub(crate) const FIRST_TILT_DEG: (f64, f64) = (-47.0, -35.0);
/// Tilt of its last row.
pub(crate) const LAST_TILT_DEG: (f64, f64) = (25.0, 31.0);
/// Accuracy bound quoted for the URG-04LX, metres below 1 m and per metre above (scip2 section 1).
pub(crate) const QUOTED_BOUND: f64 = 0.01;
/// Noise of the mild sensor, metres. Chosen: the recorded one at short range.
pub(crate) const MILD_SIGMA_M: f64 = 0.003;
/// Drift of ranges between visits, millimetres: warm-up.
pub(crate) const DRIFT_MM: f64 = 15.0;
/// Share of beams without return, from and to (recordings: 2-20 % flicker, scip2 section 11).
pub(crate) const FLICKER: (f64, f64) = (0.02, 0.2);

/// Reach of the ring scanner, metres. This and the following: chosen, unlike the URG-04LX.
pub(crate) const RINGS_REACH_M: f64 = 15.0;
/// Range up to which no return proves free space, metres.
pub(crate) const RINGS_FREE_M: f64 = 10.0;
/// One sigma as a share of the range.
pub(crate) const RINGS_SIGMA: f64 = 0.01;
/// Greatest scale error of a sweep, as a share of the range.
pub(crate) const RINGS_SCALE: f64 = 0.002;
/// Jump between neighbours at an edge, metres, and the share of edges with a mixed range.
pub(crate) const RINGS_EDGE: (f64, f64) = (0.2, 0.3);
/// Elevation of the lowest and the highest ring, and half the width of a ring, degrees.
pub(crate) const RINGS_FIELD_DEG: (f64, f64, f64) = (-40.0, 30.0, 135.0);
/// Angle between beams and between rings, degrees.
pub(crate) const RINGS_STEP_DEG: f64 = 0.5;
/// Height of the scanner over the base, metres.
pub(crate) const RINGS_HEAD_M: f64 = 0.18;

/// Points of a reference's view stand for samples of its mixture within this distance, metres: samples on a component of
/// 1.5 m with 200 beams are about as far apart.
pub(crate) const SAMPLE_REACH_M: f64 = 0.15;

/// The .95 quantile of chi-square with six degrees of freedom: a pose beyond it is not within the covariance stated for it.
pub(crate) const POSE_CHI2_95: f64 = 12.592;
