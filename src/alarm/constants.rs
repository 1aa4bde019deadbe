//! Numbers that decide in this module.

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
