//! Rigid poses, and their roll-pitch-yaw form for people and JSON.

use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion, Vector3};

/// A rigid transform. `b_from_a` maps coordinates of frame `a` to frame `b`.
pub type Pose = Isometry3<f64>;

/// Fixed-axis roll, pitch, yaw in radians: `R = Rz(yaw) Ry(pitch) Rx(roll)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RollPitchYaw {
    /// About x, radians.
    pub roll_rad: f64,
    /// About y, radians.
    pub pitch_rad: f64,
    /// About z, radians.
    pub yaw_rad: f64,
}

impl RollPitchYaw {
    /// The rotation of `pose`; pitch lies in `[-pi/2, pi/2]`.
    pub fn from_pose(pose: &Pose) -> Self {
        let (roll_rad, pitch_rad, yaw_rad) = pose.rotation.euler_angles();
        Self {
            roll_rad,
            pitch_rad,
            yaw_rad,
        }
    }

    /// The pose with this rotation and the given translation in metres.
    pub fn with_translation(self, translation_m: [f64; 3]) -> Pose {
        let rotation = Rotation3::from_euler_angles(self.roll_rad, self.pitch_rad, self.yaw_rad);
        Pose::from_parts(
            Translation3::from(Vector3::from(translation_m)),
            UnitQuaternion::from_rotation_matrix(&rotation),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::RollPitchYaw;
    use nalgebra::Point3;

    #[test]
    fn a_yaw_of_a_quarter_turn_maps_forward_to_left() {
        let pose = RollPitchYaw {
            roll_rad: 0.0,
            pitch_rad: 0.0,
            yaw_rad: std::f64::consts::FRAC_PI_2,
        }
        .with_translation([1.0, 0.0, 0.0]);
        let left = pose * Point3::new(2.0, 0.0, 0.0);
        assert!((left - Point3::new(1.0, 2.0, 0.0)).norm() < 1e-12);
    }

    #[test]
    fn angles_survive_a_round_trip() {
        let given = RollPitchYaw {
            roll_rad: 0.1,
            pitch_rad: -0.4,
            yaw_rad: 2.0,
        };
        let back = RollPitchYaw::from_pose(&given.with_translation([0.0; 3]));
        assert!((back.roll_rad - 0.1).abs() < 1e-12);
        assert!((back.pitch_rad + 0.4).abs() < 1e-12);
        assert!((back.yaw_rad - 2.0).abs() < 1e-12);
    }
}
