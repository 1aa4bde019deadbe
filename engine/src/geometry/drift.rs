//! From the frame of one view to that of another: a pose, and the drift of the sensor's ranges between the visits.

use super::Pose;
use nalgebra::Point3;

/// What must be added to ranges to agree with the reference's: `at_zero_m + per_m * range`. A warm sensor measures some
/// millimetres more than a cold one, everywhere alike.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RangeDrift {
    /// At range zero, metres.
    pub at_zero_m: f64,
    /// Growth per metre of range.
    pub per_m: f64,
}

impl RangeDrift {
    /// `p`, measured from `origin`, at the range that the reference's sensor would have measured.
    pub(crate) fn corrected(&self, p: &Point3<f64>, origin: &Point3<f64>) -> Point3<f64> {
        let v = p - origin;
        let range_m = v.norm().max(1e-9);
        p + v * ((self.at_zero_m + self.per_m * range_m) / range_m)
    }

    /// The inverse of [`Self::corrected`].
    pub(crate) fn uncorrected(&self, p: &Point3<f64>, origin: &Point3<f64>) -> Point3<f64> {
        let v = p - origin;
        let range_m = v.norm().max(1e-9);
        origin + v * ((range_m - self.at_zero_m) / (1.0 + self.per_m) / range_m)
    }
}

/// Maps points of one view into the frame of another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DriftTransform {
    /// The rigid part.
    pub(crate) pose: Pose,
    correction: RangeCorrection,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum RangeCorrection {
    None,
    /// Added before the pose, to ranges from this point.
    BeforePose(RangeDrift, Point3<f64>),
    /// Removed after the pose, from ranges from this point.
    AfterPose(RangeDrift, Point3<f64>),
}

impl DriftTransform {
    /// From a view to its own frame.
    pub(crate) fn identity() -> Self {
        Self {
            pose: Pose::identity(),
            correction: RangeCorrection::None,
        }
    }

    /// From the current view, measured from `origin` (in its frame), to the reference.
    pub(crate) fn to_reference(
        reference_from_current: Pose,
        drift: RangeDrift,
        origin: Point3<f64>,
    ) -> Self {
        Self {
            pose: reference_from_current,
            correction: RangeCorrection::BeforePose(drift, origin),
        }
    }

    /// The sensor whose ranges are corrected, in the source frame; the zero point where none are.
    pub(super) fn origin(&self) -> Point3<f64> {
        match self.correction {
            RangeCorrection::BeforePose(_, origin) => origin,
            RangeCorrection::None | RangeCorrection::AfterPose(..) => Point3::origin(),
        }
    }

    /// The inverse map.
    pub(crate) fn inverse(&self) -> Self {
        Self {
            pose: self.pose.inverse(),
            correction: match self.correction {
                RangeCorrection::None => RangeCorrection::None,
                RangeCorrection::BeforePose(drift, origin) => {
                    RangeCorrection::AfterPose(drift, origin)
                }
                RangeCorrection::AfterPose(drift, origin) => {
                    RangeCorrection::BeforePose(drift, origin)
                }
            },
        }
    }

    /// `p` in the target frame.
    #[inline]
    pub(crate) fn apply(&self, p: &Point3<f64>) -> Point3<f64> {
        match self.correction {
            RangeCorrection::None => self.pose * p,
            RangeCorrection::BeforePose(drift, origin) => self.pose * drift.corrected(p, &origin),
            RangeCorrection::AfterPose(drift, origin) => {
                drift.uncorrected(&(self.pose * p), &origin)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{DriftTransform, RangeDrift};
    use crate::geometry::RollPitchYaw;
    use nalgebra::Point3;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_inverse_undoes_the_transform(p in proptest::array::uniform3(-9.0..9.0f64), a in -0.03..0.03f64, b in -0.01..0.01f64, yaw in -1.0..1.0f64) {
            let pose = RollPitchYaw { roll_rad: 0.01, pitch_rad: -0.02, yaw_rad: yaw }.with_translation([0.1, -0.2, 0.0]);
            let drift = RangeDrift { at_zero_m: a, per_m: b };
            let origin = Point3::new(0.3, 0.1, 0.4);
            let transform = DriftTransform::to_reference(pose, drift, origin);
            let p = Point3::from(p);
            prop_assume!((p - origin).norm() > 0.1);
            prop_assert!((transform.inverse().apply(&transform.apply(&p)) - p).norm() < 1e-12);
            let longer = (drift.corrected(&p, &origin) - origin).norm() - (p - origin).norm();
            prop_assert!((longer - a - b * (p - origin).norm()).abs() < 1e-12);
        }
    }
}
