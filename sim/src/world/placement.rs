//! Poses of objects from the keys of scene files.

use nalgebra::{Rotation3, Translation3, UnitQuaternion, Vector3};
use patrold_engine::geometry::{Pose, RollPitchYaw};

/// The pose at `at` turned left by `yaw_deg`.
pub(crate) fn upright(at: [f64; 3], yaw_deg: f64) -> Pose {
    RollPitchYaw {
        roll_rad: 0.0,
        pitch_rad: 0.0,
        yaw_rad: yaw_deg.to_radians(),
    }
    .with_translation(at)
}

/// The pose at `at` whose z points along `axis` and whose x is level, then turned about z by `spin_deg`.
pub(crate) fn pointing(at: [f64; 3], axis: [f64; 3], spin_deg: f64) -> Pose {
    let axis = Vector3::from(axis)
        .try_normalize(1e-9)
        .unwrap_or_else(Vector3::z);
    let level = Vector3::z()
        .cross(&axis)
        .try_normalize(1e-9)
        .unwrap_or_else(Vector3::x);
    let rotation = Rotation3::from_basis_unchecked(&[level, axis.cross(&level), axis])
        * Rotation3::from_axis_angle(&Vector3::z_axis(), spin_deg.to_radians());
    Pose::from_parts(
        Translation3::from(Vector3::from(at)),
        UnitQuaternion::from_rotation_matrix(&rotation),
    )
}
