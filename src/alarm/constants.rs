//! Constants that decide. "Measured": seven things and three missing ones in the storeroom, ten visits each, the robot off by
//! up to 5 cm and 2 degrees (simulated sweeps through `patrold_engine::inspect`).

/// Standard deviation of the mean of a thing's points between two visits, beyond what registration and shape state, metres.
/// Measured: up to 0.012; a robot that is off by more sees other parts.
pub(super) const CENTRE_SD_M: f64 = 0.03;
/// The same for the widths of its points, metres and as a share. Measured: 0.005 to 0.01 for the two longer ones.
pub(super) const WIDTH_SD_M: f64 = 0.01;
pub(super) const WIDTH_SD_SHARE: f64 = 0.03;
/// The same for the least width, the depth of what is seen, metres. Measured: up to 0.035, of thin parts at its edge.
pub(super) const DEPTH_SD_M: f64 = 0.03;
/// Error of a shape's lengths beside those that it states, metres (the noise of a range) and as a share. Measured: a crouching person as a cylinder of 0.82 to
/// 1.01 m with a stated 0.01 m.
pub(super) const BODY_SD_M: f64 = 0.01;
pub(super) const BODY_SD_SHARE: f64 = 0.1;
/// Error of the widths of a thing seen from another side, as shares; the least one, the depth of what is seen, says nothing.
pub(super) const TURNED_SD_SHARES: [f64; 3] = [0.3, 0.3, 1.0];
/// Share of shapes whose class is wrong whatever probability is stated.
pub(super) const WRONG_CLASS_SHARE: f64 = 0.1;

/// Chi-squares that one same thing in a thousand exceeds, by degrees of freedom: of three, six and nine figures.
pub(super) const MAX_CHI_SQUARE_3: f64 = 16.27;
pub(super) const MAX_CHI_SQUARE_6: f64 = 22.46;
pub(super) const MAX_CHI_SQUARE_9: f64 = 27.88;

/// Probabilities for a thing from one visit to the next. They matter where things are nearly alike: a factor of two moves a
/// limit by less than a tenth of a standard deviation.
pub(super) const STAYS: f64 = 0.9;
pub(super) const MOVES: f64 = 0.05;
pub(super) const GOES: f64 = 0.05;
pub(super) const COMES_BACK: f64 = 0.05;
/// New things expected in a visit.
pub(super) const NEW_THINGS: f64 = 0.1;
/// Where a new thing may be: what the laser reaches, cubic metres.
pub(super) const PLACE_VOLUME_M3: f64 = 50.0;
/// A new thing's widths, metres; each order of magnitude is equally probable.
pub(super) const WIDTH_RANGE_M: [f64; 2] = [0.05, 2.5];
/// How much longer a whole thing may be than what is seen of it.
pub(super) const WHOLE_RATIO: f64 = 3.0;

/// Cosine of the greatest tilt of a floor: 15 degrees, steeper than any ramp a robot drives.
pub(super) const FLOOR_MIN_UPRIGHT: f64 = 0.966;
/// A component is flat where its second axis is so many times its third (standard deviations).
pub(super) const FLAT_MIN_RATIO: f64 = 3.0;
/// Heights within it are one floor, metres: the depth of the steps of sensor and mount.
pub(super) const FLOOR_BAND_M: f64 = 0.1;
/// Least share of all level surface that is a floor: a table top is less.
pub(super) const FLOOR_MIN_SHARE: f64 = 0.2;
/// Edge of the first bin of distances above zero, in their unit; far below every threshold.
pub(super) const HISTOGRAM_FROM: f64 = 1e-7;
/// Powers of ten that the bins span.
pub(super) const HISTOGRAM_DECADES: usize = 10;
/// Bins per power of ten: a quantile is right within 2 %.
pub(super) const BINS_PER_DECADE: usize = 120;
/// Examples kept for each threshold.
pub(super) const MAX_EXAMPLES: usize = 20;
