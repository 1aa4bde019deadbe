//! What one look from one place saw: points, and directions that gave nothing back.

use super::Pose;
use nalgebra::{Point3, Unit, Vector3};

/// Standard deviation of a range as a function of the range: `at_zero_m + per_m * range`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseLaw {
    /// Standard deviation at range zero, metres.
    pub at_zero_m: f64,
    /// Growth per metre of range.
    pub per_m: f64,
}

impl NoiseLaw {
    /// Standard deviation in metres of a range of `range_m` metres.
    pub fn sigma_m(&self, range_m: f64) -> f64 {
        self.at_zero_m + self.per_m * range_m
    }
}

/// One look around from one place. A recorded cloud has points only; a sweep of our own also knows
/// where the laser looked and saw nothing, and how noisy its ranges are.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// The sensor's optical centre, metres, in the frame of the points.
    pub origin: Point3<f64>,
    /// Measured points (n of them, all finite), metres, in the order in which they came.
    pub points: Vec<Point3<f64>>,
    /// Directions from `origin` along which the laser looked and nothing came back (range code 0).
    pub no_return: Vec<Unit<Vector3<f64>>>,
    /// Range in metres up to which a direction of `no_return` proves free space.
    pub free_range_m: f64,
    /// The sensor's own range noise where it is known; otherwise it is estimated from the points.
    pub noise: Option<NoiseLaw>,
    /// The axis, in the frame of the points, about which a line scanner was tilted: its lines crowd towards it. `None`
    /// for bare clouds and for sweeps of several pans, which have no one axis.
    pub tilt_axis: Option<Unit<Vector3<f64>>>,
}

impl View {
    /// A bare recorded cloud: points seen from `origin`, nothing known about empty directions.
    pub fn bare(points: Vec<Point3<f64>>, origin: Point3<f64>) -> Self {
        Self {
            origin,
            points,
            no_return: Vec::new(),
            free_range_m: 0.0,
            noise: None,
            tilt_axis: None,
        }
    }

    /// The same look, expressed in another frame.
    pub fn transformed(&self, other_from_this: &Pose) -> Self {
        Self {
            origin: other_from_this * self.origin,
            points: self.points.iter().map(|p| other_from_this * p).collect(),
            no_return: self
                .no_return
                .iter()
                .map(|d| other_from_this.rotation * *d)
                .collect(),
            free_range_m: self.free_range_m,
            noise: self.noise,
            tilt_axis: self.tilt_axis.map(|axis| other_from_this.rotation * axis),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::View;
    use crate::geometry::RollPitchYaw;
    use nalgebra::{Point3, Vector3};

    #[test]
    fn the_tilt_axis_turns_with_the_view() {
        let mut view = View::bare(vec![Point3::new(1.0, 0.0, 0.0)], Point3::origin());
        view.tilt_axis = Some(Vector3::y_axis());
        let quarter = RollPitchYaw {
            roll_rad: 0.0,
            pitch_rad: 0.0,
            yaw_rad: std::f64::consts::FRAC_PI_2,
        }
        .with_translation([5.0, 0.0, 0.0]);
        let axis = view.transformed(&quarter).tilt_axis.expect("carried");
        assert!((axis.into_inner() + Vector3::x()).norm() < 1e-12);
    }
}
