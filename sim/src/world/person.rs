//! Solids of a standing person: a sphere and cylinders.

use super::solid::{Solid, SolidShape};
use nalgebra::{Translation3, Vector3};
use patrold_engine::geometry::Pose;

// Lengths as shares of the height: rounded averages of adults.
const HEAD_RADIUS: f64 = 0.06;
const NECK: f64 = 0.04;
const LEGS: f64 = 0.47;
const LEG_RADIUS: f64 = 0.045;
const LEG_APART: f64 = 0.055;
const TORSO_RADIUS: f64 = 0.085;
const ARM_RADIUS: f64 = 0.027;
const ARM_APART: f64 = 0.115;
const ARM_FROM: f64 = 0.44;
const SHOULDERS: f64 = 0.82;

/// The solids of a person of `height_m` whose feet are at the origin of `map_from_feet`; the arms hang left and right.
pub(crate) fn solids(map_from_feet: &Pose, height_m: f64) -> Vec<Solid> {
    let pose = |y: f64, z: f64| {
        map_from_feet
            * Pose::from_parts(
                Translation3::from(Vector3::new(0.0, y, z) * height_m),
                nalgebra::UnitQuaternion::identity(),
            )
    };
    let pillar = |y: f64, from: f64, to: f64, radius: f64| {
        let form = SolidShape::Cylinder {
            radius: radius * height_m,
            half_length: (to - from) / 2.0 * height_m,
        };
        Solid::new(pose(y, (from + to) / 2.0), form)
    };
    let head = SolidShape::Sphere {
        radius: HEAD_RADIUS * height_m,
    };
    vec![
        Solid::new(pose(0.0, 1.0 - HEAD_RADIUS), head),
        pillar(
            0.0,
            SHOULDERS,
            SHOULDERS + NECK + HEAD_RADIUS,
            HEAD_RADIUS / 2.0,
        ),
        pillar(0.0, LEGS, SHOULDERS, TORSO_RADIUS),
        pillar(LEG_APART, 0.0, LEGS, LEG_RADIUS),
        pillar(-LEG_APART, 0.0, LEGS, LEG_RADIUS),
        pillar(ARM_APART, ARM_FROM, SHOULDERS, ARM_RADIUS),
        pillar(-ARM_APART, ARM_FROM, SHOULDERS, ARM_RADIUS),
    ]
}
