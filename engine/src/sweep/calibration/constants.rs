//! Every constant that decides something about a calibration, with its unit and origin.

/// Edge of the cells that planes are found in, metres. Chosen: walls of rooms are many cells wide.
pub(super) const CELL_M: f64 = 0.1;

/// Tolerances of the rounds of finding planes: distance of a cell from its plane in metres, and angle between them in radians.
/// The first admits a laser mounted 2 deg off at 3 m, the last the noise of cells (20 mm are three sigmas of one range at
/// 3 m).
pub(super) const ROUNDS: [(f64, f64); 4] = [(0.12, 0.26), (0.06, 0.17), (0.03, 0.14), (0.02, 0.14)];

/// Cells that are tried as seeds of a plane. Chosen.
pub(super) const PLANE_TRIALS: usize = 200;

/// Fewest cells of a plane, over all pan segments: at 10 cm, half a square metre seen once.
pub(super) const MIN_PLANE_CELLS: usize = 50;

/// Fewest beams of a plane: at the usual density of a sweep, a tenth of a square metre at 3 m.
pub(super) const MIN_PLANE_BEAMS: usize = 300;

/// Most planes: a room has six and its furniture some more; each adds three unknowns.
pub(super) const MAX_PLANES: usize = 16;

/// Pans that differ by less are one, radians: 0.6 deg, more than the counts that a head settles beside its target, and far
/// less than pans that are worth a sweep of their own.
pub(super) const SAME_PAN_RAD: f64 = 0.01;

/// Fewest planes of a calibration (sweep-geometry section 5: three of different orientation).
pub(super) const MIN_PLANES: usize = 3;

/// Smallest cosine of a floor's tilt: 18 deg, more than any mount is off.
pub(super) const MIN_FLOOR_COS: f64 = 0.95;

/// Smallest cosine of the angle of incidence: at 80 deg a spot of centimetres becomes decimetres long.
pub(super) const MIN_INCIDENCE_COS: f64 = 0.17;

/// Beams further from the plane of their own cell than this many standard deviations of a range hit something else.
pub(super) const MAX_CELL_DISTANCE_SIGMAS: f64 = 4.0;

/// Smallest standard deviation of a point across its plane, metres: the sensor's resolution of a millimetre and the roughness
/// of walls, at any incidence.
pub(super) const MIN_SIGMA_M: f64 = 0.001;

/// Residuals, in standard deviations, beyond which the weight falls as one over the residual (Huber).
pub(super) const HUBER_SIGMAS: f64 = 2.0;

/// Largest distance of beams, in beams, whose noise may be correlated: the recorded correlation (.48, .28, .13) is gone at
/// the fourth.
pub(super) const MAX_LAG: usize = 6;

/// Median of the absolute value of a normal variable, in standard deviations.
pub(super) const MEDIAN_OF_SIGMA: f64 = 0.6745;

/// Prior of the angles of the mount, standard deviation in radians: wide, 6 deg. Chosen.
pub(super) const PRIOR_ANGLE_RAD: f64 = 0.1;
/// Prior of the laser's position on the plate, standard deviation in metres: measured with a ruler.
pub(super) const PRIOR_POSITION_M: f64 = 0.02;
/// Prior of the time offset, standard deviation in seconds: poll latency with the 16 ms of a USB adapter, and the angle of
/// step 0 (sweep-geometry sections 1 and 3).
pub(super) const PRIOR_TIME_S: f64 = 0.03;
/// Prior of the backlash, standard deviation in radians: 1 deg. Chosen.
pub(super) const PRIOR_BACKLASH_RAD: f64 = 0.017;
/// Prior of the bias of all ranges, standard deviation in metres: twice the makers' 10 mm.
pub(super) const PRIOR_RANGE_M: f64 = 0.02;

/// Standard deviation of the time error of a single pan segment, seconds: a stamp counts whole milliseconds (0.29 ms), and the
/// line through the polls is known to 0.1 ms (sweep-geometry section 3: 0.01 position at 97 positions a second).
pub(super) const SEGMENT_TIME_SIGMA_S: f64 = 0.3e-3;

/// Standard deviation above which an angle is not observable, radians: 0.1 deg, 7 mm at 4 m, more than the noise of a wall.
pub(super) const MAX_ANGLE_SIGMA_RAD: f64 = 0.1 * std::f64::consts::PI / 180.0;
/// The same for the backlash, radians: one count of a D46-17.
pub(super) const MAX_BACKLASH_SIGMA_RAD: f64 = 0.05 * std::f64::consts::PI / 180.0;
/// The same for the time offset, seconds: at 20 deg/s 0.02 deg.
pub(super) const MAX_TIME_SIGMA_S: f64 = 1e-3;
/// The same for positions and the bias of ranges, metres: a ruler is as good.
pub(super) const MAX_POSITION_SIGMA_M: f64 = 0.003;

/// Most steps of the solver in a round. Chosen.
pub(super) const MAX_STEPS: usize = 20;
/// Relative change of the cost at which the solver has converged. Chosen.
pub(super) const CONVERGED_COST_SHARE: f64 = 1e-9;

/// Share of its information that keeps an unknown in place when everything that determined it is left out: small against the
/// share of any plane, large against rounding.
pub(super) const RIDGE_SHARE: f64 = 1e-9;

/// Standard deviation of errors of an angle of the mount that all planes share, radians: 0.005 deg, a tenth of a count of a
/// D46-17. Measured on emulated robots (tests in src/devices/lockstep/calibration.rs): in one room the roll of all eight was
/// off by -0.004 to -0.010 deg.
pub(super) const COMMON_ANGLE_SIGMA_RAD: f64 = 0.005 * std::f64::consts::PI / 180.0;
