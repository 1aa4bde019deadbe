//! Pose of the laser for a pan and a tilt: the kinematic chain of sweep-geometry section 2.

use super::{Pose, RollPitchYaw};
use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};

/// The chain base -> pan axis -> tilt axis -> plate -> laser:
/// `p_base = o_pan + Rz(pan) (o_tilt + Ry(-tilt) (o_plate + R_L q + t_L))`.
#[derive(Debug, Clone, PartialEq)]
pub struct Mount {
    parameters: [f64; 15],
    base_from_pan: Vector3<f64>,
    pan_from_tilt: Vector3<f64>,
    tilt_from_laser: Pose,
}

impl Mount {
    /// The chain with four offsets in metres, each in the frame before it, and the laser's orientation on the plate.
    pub fn new(
        pan_axis_m: [f64; 3],
        tilt_axis_m: [f64; 3],
        plate_m: [f64; 3],
        laser_m: [f64; 3],
        laser: RollPitchYaw,
    ) -> Self {
        let rotation = [laser.roll_rad, laser.pitch_rad, laser.yaw_rad];
        let groups = [pan_axis_m, tilt_axis_m, plate_m, laser_m, rotation];
        Self::from_parameters(std::array::from_fn(|i| groups[i / 3][i % 3]))
    }

    /// The chain with the parameters in the order of [`parameters`](Self::parameters).
    pub(crate) fn from_parameters(parameters: [f64; 15]) -> Self {
        let triple = |at: usize| [parameters[at], parameters[at + 1], parameters[at + 2]];
        let [roll_rad, pitch_rad, yaw_rad] = triple(12);
        let laser = RollPitchYaw {
            roll_rad,
            pitch_rad,
            yaw_rad,
        };
        let plate = Translation3::from(Vector3::from(triple(6)));
        Self {
            parameters,
            base_from_pan: Vector3::from(triple(0)),
            pan_from_tilt: Vector3::from(triple(3)),
            tilt_from_laser: plate * laser.with_translation(triple(9)),
        }
    }

    /// Offsets of pan axis, tilt axis, plate, laser (x, y, z in metres each), then roll, pitch and yaw of the laser (radians).
    /// They determine the mount.
    pub(crate) fn parameters(&self) -> [f64; 15] {
        self.parameters
    }

    /// The axis about which the laser tilts, in the base frame.
    pub fn tilt_axis(&self, pan_rad: f64) -> Unit<Vector3<f64>> {
        UnitQuaternion::from_axis_angle(&Vector3::z_axis(), pan_rad) * Vector3::y_axis()
    }

    /// Pose of the laser in the base frame; pan positive to the left, tilt positive up, radians.
    pub fn base_from_laser(&self, pan_rad: f64, tilt_rad: f64) -> Pose {
        let pan = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), pan_rad);
        let tilt = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), -tilt_rad);
        Isometry3::from_parts(Translation3::from(self.base_from_pan), pan)
            * Isometry3::from_parts(Translation3::from(self.pan_from_tilt), tilt)
            * self.tilt_from_laser
    }
}

#[cfg(test)]
mod tests {
    use super::Mount;
    use crate::geometry::RollPitchYaw;
    use nalgebra::Point3;
    use std::f64::consts::FRAC_PI_2;

    fn d46() -> Mount {
        let straight = RollPitchYaw {
            roll_rad: 0.0,
            pitch_rad: 0.0,
            yaw_rad: 0.0,
        };
        Mount::new(
            [0.0, -0.00955, 0.046774],
            [0.0, 0.0, 0.043713],
            [0.0, 0.0, 0.039116],
            [0.0, 0.0, 0.05],
            straight,
        )
    }

    #[test]
    fn the_parameters_determine_the_mount() {
        let turned = RollPitchYaw {
            roll_rad: 0.1,
            pitch_rad: -0.2,
            yaw_rad: 0.3,
        };
        let mount = Mount::new([0.1; 3], [0.2; 3], [0.3; 3], [0.4; 3], turned);
        assert_eq!(Mount::from_parameters(mount.parameters()), mount);
        assert!((mount.tilt_axis(FRAC_PI_2).x + 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_level_laser_is_above_the_plate() {
        // Tilt axis 90.5 mm and plate 129.6 mm above the base (sweep-geometry section 2).
        let origin = d46().base_from_laser(0.0, 0.0) * Point3::origin();
        assert!((origin - Point3::new(0.0, -0.00955, 0.129603 + 0.05)).norm() < 1e-12);
    }

    #[test]
    fn tilting_up_moves_the_beam_up_and_the_laser_back() {
        let beam = d46().base_from_laser(0.0, FRAC_PI_2) * Point3::new(1.0, 0.0, 0.0);
        let axis_z = 0.046774 + 0.043713;
        assert!((beam - Point3::new(-0.089116, -0.00955, axis_z + 1.0)).norm() < 1e-12);
    }

    #[test]
    fn panning_left_moves_the_beam_left() {
        let beam = d46().base_from_laser(FRAC_PI_2, 0.0) * Point3::new(1.0, 0.0, 0.0);
        assert!((beam - Point3::new(0.0, 1.0 - 0.00955, 0.179603)).norm() < 1e-12);
    }
}
