//! From one view's frame into another's: a pose, and the drift of the sensor's ranges between the visits.

use super::Pose;
use nalgebra::Point3;

/// How much longer ranges would have to be told to agree with the reference's: `at_zero_m + per_m * range`.
/// A warm sensor measures some millimetres more than a cold one, everywhere alike.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RangeDrift {
    /// At range zero, metres.
    pub at_zero_m: f64,
    /// Growth per metre of range.
    pub per_m: f64,
}

impl RangeDrift {
    /// `p`, measured from `origin`, where the reference's sensor would have put it.
    pub fn corrected(&self, p: &Point3<f64>, origin: &Point3<f64>) -> Point3<f64> {
        let v = p - origin;
        let range_m = v.norm().max(1e-9);
        p + v * ((self.at_zero_m + self.per_m * range_m) / range_m)
    }

    /// The inverse of [`Self::corrected`].
    pub fn undone(&self, p: &Point3<f64>, origin: &Point3<f64>) -> Point3<f64> {
        let v = p - origin;
        let range_m = v.norm().max(1e-9);
        origin + v * ((range_m - self.at_zero_m) / (1.0 + self.per_m) / range_m)
    }
}

/// Maps places of one view into the frame of another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passage {
    /// The rigid part.
    pub pose: Pose,
    drift: Ranges,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Ranges {
    Alike,
    /// Corrected before the pose, seen from this place.
    Corrected(RangeDrift, Point3<f64>),
    /// Undone after it.
    Undone(RangeDrift, Point3<f64>),
}

impl Passage {
    /// From a view into its own frame.
    pub fn identity() -> Self {
        Self {
            pose: Pose::identity(),
            drift: Ranges::Alike,
        }
    }

    /// From the current view, seen from `origin` (its frame), to the reference.
    pub fn to_reference(
        reference_from_current: Pose,
        drift: RangeDrift,
        origin: Point3<f64>,
    ) -> Self {
        Self {
            pose: reference_from_current,
            drift: Ranges::Corrected(drift, origin),
        }
    }

    /// Where the sensor stood whose ranges are corrected, in the frame that is left; the origin where none are.
    pub(super) fn origin(&self) -> Point3<f64> {
        match self.drift {
            Ranges::Corrected(_, origin) => origin,
            Ranges::Alike | Ranges::Undone(..) => Point3::origin(),
        }
    }

    /// The way back.
    pub fn inverse(&self) -> Self {
        Self {
            pose: self.pose.inverse(),
            drift: match self.drift {
                Ranges::Alike => Ranges::Alike,
                Ranges::Corrected(drift, origin) => Ranges::Undone(drift, origin),
                Ranges::Undone(drift, origin) => Ranges::Corrected(drift, origin),
            },
        }
    }

    /// Where `p` lies in the other frame.
    #[inline]
    pub fn carry(&self, p: &Point3<f64>) -> Point3<f64> {
        match self.drift {
            Ranges::Alike => self.pose * p,
            Ranges::Corrected(drift, origin) => self.pose * drift.corrected(p, &origin),
            Ranges::Undone(drift, origin) => drift.undone(&(self.pose * p), &origin),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Passage, RangeDrift};
    use crate::geometry::RollPitchYaw;
    use nalgebra::Point3;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn there_and_back_is_nowhere(p in proptest::array::uniform3(-9.0..9.0f64), a in -0.03..0.03f64, b in -0.01..0.01f64, yaw in -1.0..1.0f64) {
            let pose = RollPitchYaw { roll_rad: 0.01, pitch_rad: -0.02, yaw_rad: yaw }.with_translation([0.1, -0.2, 0.0]);
            let drift = RangeDrift { at_zero_m: a, per_m: b };
            let origin = Point3::new(0.3, 0.1, 0.4);
            let there = Passage::to_reference(pose, drift, origin);
            let p = Point3::from(p);
            prop_assume!((p - origin).norm() > 0.1);
            prop_assert!((there.inverse().carry(&there.carry(&p)) - p).norm() < 1e-12);
            let longer = (drift.corrected(&p, &origin) - origin).norm() - (p - origin).norm();
            prop_assert!((longer - a - b * (p - origin).norm()).abs() < 1e-12);
        }
    }
}
