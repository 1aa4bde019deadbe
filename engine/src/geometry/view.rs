//! What was measured from one position: points, and directions without a return.

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

/// What was measured from one position. A recorded cloud has points only; a sweep also has the directions without a return
/// and the noise of its ranges.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// The sensor's optical centre, metres, in the frame of the points.
    pub origin: Point3<f64>,
    /// Measured points, finite, metres, in the order of measurement.
    pub points: Vec<Point3<f64>>,
    /// Directions from `origin` in which the laser measured and nothing came back (range code 0).
    pub no_return: Vec<Unit<Vector3<f64>>>,
    /// Range in metres up to which a direction of `no_return` proves free space.
    pub free_range_m: f64,
    /// The sensor's own range noise where it is known; otherwise it is estimated from the points.
    pub noise: Option<NoiseLaw>,
    /// The axis, in the frame of the points, about which a line scanner was tilted: its lines converge towards it. `None` for
    /// recorded clouds and for sweeps of several pans.
    pub tilt_axis: Option<Unit<Vector3<f64>>>,
}

impl View {
    /// A recorded cloud: `points` measured from `origin`, nothing known about directions without a return.
    pub fn from_points(points: Vec<Point3<f64>>, origin: Point3<f64>) -> Self {
        Self {
            origin,
            points,
            no_return: Vec::new(),
            free_range_m: 0.0,
            noise: None,
            tilt_axis: None,
        }
    }

    /// The same view in another frame.
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
    fn the_tilt_axis_rotates_with_the_view() {
        let mut view = View::from_points(vec![Point3::new(1.0, 0.0, 0.0)], Point3::origin());
        view.tilt_axis = Some(Vector3::y_axis());
        let quarter = RollPitchYaw {
            roll_rad: 0.0,
            pitch_rad: 0.0,
            yaw_rad: std::f64::consts::FRAC_PI_2,
        }
        .with_translation([5.0, 0.0, 0.0]);
        let axis = view.transformed(&quarter).tilt_axis.expect("kept");
        assert!((axis.into_inner() + Vector3::x()).norm() < 1e-12);
    }
}
