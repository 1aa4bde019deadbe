//! A scene: two looks at one place, and what is true of what came between them.

use super::constants::TURN_RATIO;
use nalgebra::{Matrix3, Point3};
use patrold_engine::geometry::View;
use patrold_engine::shape::{Class, Primitive};

/// What is true of a scene's novelty.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// Its class.
    pub class: Class,
    /// Its middle in the current view's frame, metres.
    pub centre: Point3<f64>,
    /// Its axes as columns, where it has any; a symmetry's choice is the scorer's business.
    pub rotation: Matrix3<f64>,
    /// Full lengths along them, metres.
    pub size_m: [f64; 3],
    /// Which of these a thing like this has: a person has a height, but no diameter.
    pub sized: [bool; 3],
    /// Whether its axes mean something beyond the third.
    pub turned: bool,
}

impl Truth {
    /// A primitive as seen from `sensor`.
    pub fn of(primitive: &Primitive, sensor: &Point3<f64>) -> Self {
        let size_m = primitive.size_m();
        Self {
            class: primitive.class(),
            centre: primitive.centre(),
            rotation: primitive.rotation(sensor),
            size_m,
            sized: [true; 3],
            turned: primitive.class() == Class::Plane && size_m[0] >= TURN_RATIO * size_m[1],
        }
    }
}

/// Two looks at one place, and what came between them.
#[derive(Debug, Clone)]
pub struct Look {
    /// Name that runs it again, such as `sphere-17`.
    pub name: String,
    /// How it was.
    pub reference: View,
    /// How it is.
    pub current: View,
    /// What came; `None` where nothing did.
    pub truth: Option<Truth>,
    /// Whether something else truly went (a door's old place): such novelties are no false shapes.
    pub vacated: bool,
}
