//! Every figure that decides something about a calibration, its unit and where it comes from.

/// Edge of the cells in which surfaces are looked for, metres: walls of rooms are many of them wide.
pub const CELL_M: f64 = 0.1;

/// Rounds of looking for surfaces: how far a cell may lie off its surface in metres, and be turned against it in
/// radians. The first admits a laser mounted 2 deg awry at 3 m, the last what noise does to cells (20 mm are three sigmas
/// of one range at 3 m).
pub const ROUNDS: [(f64, f64); 4] = [(0.12, 0.26), (0.06, 0.17), (0.03, 0.14), (0.02, 0.14)];

/// Cells that are tried as the beginning of a surface.
pub const TRIALS: usize = 200;

/// Fewest cells of a surface, over all legs: at 10 cm, half a square metre seen once.
pub const LEAST_CELLS: usize = 50;

/// Fewest beams of a surface: at a sweep's usual density, a tenth of a square metre at 3 m.
pub const LEAST_BEAMS: usize = 300;

/// Most surfaces: a room has six and furniture some more; every one costs three unknowns.
pub const MOST_PLANES: usize = 16;

/// Fewest surfaces that a calibration may stand on (sweep-geometry section 5: three differently oriented ones).
pub const LEAST_PLANES: usize = 3;

/// Least cosine of a floor's tilt: 18 deg, more than any mount awry.
pub const FLOOR_COS: f64 = 0.95;

/// Least cosine of incidence of a beam that counts: at 80 deg a spot of a few centimetres is metres long.
pub const LEAST_COS: f64 = 0.17;

/// Beams further from their cell's own plane than this many standard deviations of a range are of something else.
pub const OWN_CELL_SIGMAS: f64 = 4.0;

/// Least standard deviation of a place across its surface, metres: a millimetre of the sensor's counting and the
/// roughness of walls, whatever the incidence.
pub const LEAST_SIGMA_M: f64 = 0.001;

/// Residuals, in standard deviations, beyond which weight falls as one over the residual (Huber).
pub const ROBUST_SIGMAS: f64 = 2.0;

/// Neighbouring beams over which noise may be shared: the recorded correlation is gone at the fourth
/// (.48, .28, .13).
pub const LAGS: usize = 6;

/// What is believed beforehand of angles of the mount, standard deviation in radians: wide, 6 deg.
pub const PRIOR_ANGLE_RAD: f64 = 0.1;
/// Of the laser's place on the plate, metres: it was measured with a ruler.
pub const PRIOR_PLACE_M: f64 = 0.02;
/// Of the time offset, seconds: poll latency with a USB adapter's 16 ms, and the angle of step 0.
pub const PRIOR_TIME_S: f64 = 0.03;
/// Of the backlash, radians: 1 deg.
pub const PRIOR_BACKLASH_RAD: f64 = 0.017;
/// Of the bias of all ranges, metres: the makers' 10 mm or 1 %.
pub const PRIOR_RANGE_M: f64 = 0.02;

/// Standard deviation of the time error of one leg by itself, seconds: a stamp counts whole milliseconds (0.29 ms), and
/// the line through the polls is known to 0.1 ms (sweep-geometry section 3: 0.01 position at 97 a second).
pub const LEG_TIME_S: f64 = 0.3e-3;

/// Standard deviation above which an angle counts as not observable, radians: 0.1 deg, 7 mm at 4 m, more than a wall's
/// own noise.
pub const MOST_ANGLE_RAD: f64 = 0.1 * std::f64::consts::PI / 180.0;
/// The same for the backlash, radians: one count of a D46-17.
pub const MOST_BACKLASH_RAD: f64 = 0.05 * std::f64::consts::PI / 180.0;
/// The same for the time offset, seconds: at 20 deg/s 0.02 deg.
pub const MOST_TIME_S: f64 = 1e-3;
/// The same for places and the bias of ranges, metres: a ruler does as well.
pub const MOST_PLACE_M: f64 = 0.003;

/// Steps of the solver in one round, and the change of the cost, as a share, at which it is done.
pub const MOST_STEPS: usize = 20;
/// See [`MOST_STEPS`].
pub const DONE_SHARE: f64 = 1e-9;

/// What keeps an unknown where it is when all that determined it is left out, as a share of its information: small
/// against any surface's share, large against rounding.
pub const UNDETERMINED_SHARE: f64 = 1e-9;

/// Standard deviation of what errs alike on all surfaces about an angle of the mount, radians: 0.005 deg, a tenth of a
/// count of a D46-17. Emulated robots (`stated_uncertainties_hold_the_truth_of_many_robots`) show it: in one room the
/// roll of all eight was off by -0.004 to -0.010 deg.
pub const COMMON_ANGLE_RAD: f64 = 0.005 * std::f64::consts::PI / 180.0;
