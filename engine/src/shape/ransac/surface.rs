//! The unbounded surfaces that are searched for, in the frame of the [`Cloud`](super::cloud::Cloud).

use crate::shape::primitive::perpendicular;
use nalgebra::{Unit, Vector3};

/// A surface without extent; lengths in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum UnboundedSurface {
    /// All x with normal . x = offset.
    Plane {
        normal: Unit<Vector3<f64>>,
        offset_m: f64,
    },
    /// All x with |x - centre| = radius.
    Sphere { centre: Vector3<f64>, radius_m: f64 },
    /// All x whose distance from the line through `point` along `axis` is the radius.
    Cylinder {
        point: Vector3<f64>,
        axis: Unit<Vector3<f64>>,
        radius_m: f64,
    },
}

impl UnboundedSurface {
    /// Signed distance of `x`, metres; positive outside of a curved surface.
    pub(super) fn distance_m(&self, x: &Vector3<f64>) -> f64 {
        match self {
            Self::Plane { normal, offset_m } => normal.dot(x) - offset_m,
            Self::Sphere { centre, radius_m } => (x - centre).norm() - radius_m,
            Self::Cylinder {
                point,
                axis,
                radius_m,
            } => across(&(x - point), axis).norm() - radius_m,
        }
    }

    /// Outward unit normal next to `x`; `None` at the centre or on the axis.
    pub(super) fn normal_at(&self, x: &Vector3<f64>) -> Option<Vector3<f64>> {
        match self {
            Self::Plane { normal, .. } => Some(normal.into_inner()),
            Self::Sphere { centre, .. } => (x - centre).try_normalize(0.0),
            Self::Cylinder { point, axis, .. } => across(&(x - point), axis).try_normalize(0.0),
        }
    }

    /// `None` for a plane.
    pub(super) fn radius_m(&self) -> Option<f64> {
        match *self {
            Self::Plane { .. } => None,
            Self::Sphere { radius_m, .. } | Self::Cylinder { radius_m, .. } => Some(radius_m),
        }
    }

    /// Index of its class among plane, sphere, cylinder: fewer parameters first.
    pub(super) fn class_index(&self) -> usize {
        match self {
            Self::Plane { .. } => 0,
            Self::Sphere { .. } => 1,
            Self::Cylinder { .. } => 2,
        }
    }

    /// Free parameters: 3, 4, 5.
    pub(super) fn parameter_count(&self) -> usize {
        3 + self.class_index()
    }

    /// Whether every number is finite and a radius is positive.
    pub(super) fn is_valid(&self) -> bool {
        let finite = |v: &Vector3<f64>| v.iter().all(|c| c.is_finite());
        let radius = self.radius_m().is_none_or(|r| r.is_finite() && r > 0.0);
        radius
            && match self {
                Self::Plane { normal, offset_m } => finite(normal) && offset_m.is_finite(),
                Self::Sphere { centre, .. } => finite(centre),
                Self::Cylinder { point, axis, .. } => finite(point) && finite(axis),
            }
    }

    /// A right-handed frame whose third axis is a plane's normal or a cylinder's axis.
    pub(super) fn frame(&self) -> [Vector3<f64>; 3] {
        let third = match self {
            Self::Plane { normal, .. } => *normal,
            Self::Sphere { .. } => Vector3::z_axis(),
            Self::Cylinder { axis, .. } => *axis,
        };
        let first = perpendicular(&third);
        let second = third.cross(&first);
        [first.into_inner(), second, third.into_inner()]
    }
}

/// The part of `d` perpendicular to `axis`.
pub(super) fn across(d: &Vector3<f64>, axis: &Unit<Vector3<f64>>) -> Vector3<f64> {
    d - axis.as_ref() * axis.dot(d)
}
