//! A scene: two views of one place, and the truth about what appeared.

use super::constants::MIN_SIDE_RATIO;
use nalgebra::{Matrix3, Point3};
use patrold_engine::geometry::View;
use patrold_engine::shape::{Class, Primitive};

/// The truth about the novelty of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct NoveltyTruth {
    /// Its class.
    pub class: Class,
    /// Its centre, frame of the current view, metres.
    pub centre: Point3<f64>,
    /// Its axes as columns; where a symmetry leaves a choice, the scorer compares all.
    pub rotation: Matrix3<f64>,
    /// Full lengths along the axes, metres.
    pub size_m: [f64; 3],
    /// Which of these lengths count: a person has a height, but no diameter.
    pub sized: [bool; 3],
    /// Whether the rotation about the third axis counts.
    pub turned: bool,
}

impl NoveltyTruth {
    /// The truth about a primitive seen from `sensor`.
    pub fn of_primitive(primitive: &Primitive, sensor: &Point3<f64>) -> Self {
        let size_m = primitive.size_m();
        Self {
            class: primitive.class(),
            centre: primitive.centre(),
            rotation: primitive.canonical_rotation(sensor),
            size_m,
            sized: [true; 3],
            turned: primitive.class() == Class::Plane && size_m[0] >= MIN_SIDE_RATIO * size_m[1],
        }
    }
}

/// Two views of one place, and what appeared between them.
#[derive(Debug, Clone)]
pub struct ScenePair {
    /// The name by which it can be run alone, such as `sphere-17`.
    pub name: String,
    /// The view before.
    pub reference: View,
    /// The view after.
    pub current: View,
    /// What appeared; `None` if nothing did.
    pub truth: Option<NoveltyTruth>,
    /// Whether an object truly disappeared, too (a door's former place): such novelties are no false shapes.
    pub vacated: bool,
}
