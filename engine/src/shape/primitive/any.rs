//! One primitive of whichever class.

use super::{Cone, Cuboid, Cylinder, Plane, Sphere, Superquadric, SurfaceElement};
use crate::shape::Class;
use nalgebra::{Isometry3, Matrix3, Point3, Unit, Vector3};

/// A geometric primitive: sphere, cylinder and plane as in paper section IV, and those that the paper leaves for later.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Primitive {
    /// Sphere.
    Sphere(Sphere),
    /// Circular cylinder of finite length.
    Cylinder(Cylinder),
    /// Rectangle.
    Plane(Plane),
    /// Rectangular box.
    Cuboid(Cuboid),
    /// Circular cone.
    Cone(Cone),
    /// Superquadric ellipsoid.
    Superquadric(Superquadric),
}

impl Primitive {
    /// Its class.
    pub fn class(&self) -> Class {
        match self {
            Self::Sphere(_) => Class::Sphere,
            Self::Cylinder(_) => Class::Cylinder,
            Self::Plane(_) => Class::Plane,
            Self::Cuboid(_) => Class::Box,
            Self::Cone(_) => Class::Cone,
            Self::Superquadric(_) => Class::Superquadric,
        }
    }

    /// Its centre, metres.
    pub fn centre(&self) -> Point3<f64> {
        match self {
            Self::Sphere(s) => s.centre,
            Self::Cylinder(c) => c.centre,
            Self::Plane(p) => p.centre,
            Self::Cuboid(b) => b.centre,
            Self::Cone(c) => c.centre,
            Self::Superquadric(s) => s.centre,
        }
    }

    /// Full lengths along its axes, metres: (D, D, D), (D, D, L), (A, B, 0) with A >= B, a box's longest first, a cone's
    /// (D, D, H), a superquadric's with the longer of those across z first.
    pub fn size_m(&self) -> [f64; 3] {
        match self {
            Self::Sphere(s) => [2.0 * s.radius_m; 3],
            Self::Cylinder(c) => [2.0 * c.radius_m, 2.0 * c.radius_m, c.length_m],
            Self::Plane(p) => {
                let [a, b] = p.longer_first().sides_m;
                [a, b, 0.0]
            }
            Self::Cuboid(b) => b.size_m(),
            Self::Cone(c) => [2.0 * c.radius_m, 2.0 * c.radius_m, c.height_m],
            Self::Superquadric(s) => s.longer_first().sides_m,
        }
    }

    /// e1 and e2 of a superquadric.
    pub fn exponents(&self) -> Option<[f64; 2]> {
        match self {
            Self::Superquadric(s) => Some(s.exponents),
            _ => None,
        }
    }

    /// Its axes as columns, right-handed. What a symmetry leaves open is fixed by the sensor's position: a cylinder's first
    /// column and a plane's normal point towards it.
    pub fn canonical_rotation(&self, sensor: &Point3<f64>) -> Matrix3<f64> {
        match self {
            // A sphere has no axes: those of the frame.
            Self::Sphere(_) => Matrix3::identity(),
            Self::Cylinder(c) => c.canonical_rotation(sensor),
            Self::Plane(p) => p.canonical_rotation(sensor),
            Self::Cuboid(b) => b.canonical_rotation(),
            Self::Cone(c) => c.canonical_rotation(sensor),
            Self::Superquadric(s) => s.canonical_rotation(),
        }
    }

    /// Signed distance of `p` from the surface (unbounded for all but sphere and superquadric), metres.
    pub fn distance_m(&self, p: &Point3<f64>) -> f64 {
        match self {
            Self::Sphere(s) => s.distance_m(p),
            Self::Cylinder(c) => c.distance_m(p),
            Self::Plane(plane) => plane.distance_m(p),
            Self::Cuboid(b) => b.distance_m(p),
            Self::Cone(c) => c.distance_m(p),
            Self::Superquadric(s) => s.distance_m(p),
        }
    }

    /// Unit normal of the surface next to `p`; `None` where there is none (centre, axis).
    pub fn normal_at(&self, p: &Point3<f64>) -> Option<Vector3<f64>> {
        match self {
            Self::Sphere(s) => s.normal_at(p),
            Self::Cylinder(c) => c.normal_at(p),
            Self::Plane(plane) => Some(plane.normal()),
            Self::Cuboid(b) => Some(b.normal_at(p)),
            Self::Cone(c) => c.normal_at(p),
            Self::Superquadric(s) => s.normal_at(p),
        }
    }

    /// Signed distance of `p` from the part of the surface that `sensor` sees, metres.
    pub fn visible_distance_m(&self, p: &Point3<f64>, sensor: &Point3<f64>) -> f64 {
        match self {
            Self::Cylinder(c) => c.visible_distance_m(p, sensor),
            Self::Cuboid(b) => b.visible_distance_m(p, sensor),
            Self::Cone(c) => c.visible_distance_m(p, sensor),
            Self::Superquadric(s) => s.visible_distance_m(p, sensor),
            other => other.distance_m(p),
        }
    }

    /// Number of the face that `p` belongs to among those that `sensor` sees.
    pub(in crate::shape) fn visible_face(&self, p: &Point3<f64>, sensor: &Point3<f64>) -> usize {
        match self {
            Self::Cylinder(c) => c.visible_face(p, sensor),
            Self::Cuboid(b) => b.visible_face(p, sensor),
            Self::Cone(c) => c.visible_face(p, sensor),
            Self::Sphere(_) | Self::Plane(_) | Self::Superquadric(_) => 0,
        }
    }

    /// The primitive in another frame.
    pub fn transformed(&self, other_from_this: &Isometry3<f64>) -> Self {
        match *self {
            Self::Sphere(s) => Self::Sphere(Sphere {
                centre: other_from_this * s.centre,
                ..s
            }),
            Self::Cylinder(c) => Self::Cylinder(Cylinder {
                centre: other_from_this * c.centre,
                axis: other_from_this.rotation * c.axis,
                ..c
            }),
            Self::Plane(p) => Self::Plane(Plane {
                centre: other_from_this * p.centre,
                rotation: other_from_this.rotation.to_rotation_matrix() * p.rotation,
                ..p
            }),
            Self::Cuboid(b) => Self::Cuboid(Cuboid {
                centre: other_from_this * b.centre,
                rotation: other_from_this.rotation.to_rotation_matrix() * b.rotation,
                ..b
            }),
            Self::Cone(c) => Self::Cone(Cone {
                centre: other_from_this * c.centre,
                axis: other_from_this.rotation * c.axis,
                ..c
            }),
            Self::Superquadric(s) => Self::Superquadric(Superquadric {
                centre: other_from_this * s.centre,
                rotation: other_from_this.rotation.to_rotation_matrix() * s.rotation,
                ..s
            }),
        }
    }

    /// Visits the elements of the surface that `sensor` sees.
    pub(in crate::shape) fn for_each_visible(
        &self,
        sensor: &Point3<f64>,
        visit: &mut impl FnMut(SurfaceElement),
    ) {
        match self {
            Self::Sphere(s) => s.for_each_visible(sensor, visit),
            Self::Cylinder(c) => c.for_each_visible(sensor, visit),
            Self::Plane(p) => p.for_each_visible(sensor, visit),
            Self::Cuboid(b) => b.for_each_visible(sensor, visit),
            Self::Cone(c) => c.for_each_visible(sensor, visit),
            Self::Superquadric(s) => s.for_each_visible(sensor, visit),
        }
    }

    /// Visits the elements of the whole ideal surface (paper section IV.B; without caps and base).
    pub(in crate::shape) fn for_each_ideal(&self, visit: &mut impl FnMut(SurfaceElement)) {
        match self {
            Self::Sphere(s) => s.for_each_ideal(visit),
            Self::Cylinder(c) => c.for_each_ideal(visit),
            Self::Plane(p) => p.for_each_ideal(visit),
            Self::Cuboid(b) => b.for_each_ideal(visit),
            Self::Cone(c) => c.for_each_ideal(visit),
            Self::Superquadric(s) => s.for_each_ideal(visit),
        }
    }

    /// Free parameters of the class, centre included (k of the score).
    pub(in crate::shape) fn parameter_count(&self) -> usize {
        match self {
            Self::Sphere(_) => 4,
            Self::Cylinder(_) => 7,
            Self::Plane(_) => 8,
            Self::Cuboid(_) => 9,
            Self::Cone(_) => 7,
            Self::Superquadric(_) => 11,
        }
    }

    /// Initial guesses of the paper's classes for the given moments, by class; `axes` are the covariance's eigenvectors and
    /// `view` points from the sensor to the object.
    pub(in crate::shape) fn initial_guesses(
        mean: &Point3<f64>,
        covariance: &Matrix3<f64>,
        view: &Unit<Vector3<f64>>,
        axes: &[Unit<Vector3<f64>>],
    ) -> Vec<Vec<Self>> {
        vec![
            Sphere::initial_guesses(mean, covariance, view)
                .into_iter()
                .map(Self::Sphere)
                .collect(),
            Cylinder::initial_guesses(mean, covariance, view, axes)
                .into_iter()
                .map(Self::Cylinder)
                .collect(),
            Plane::initial_guesses(mean, covariance, axes)
                .into_iter()
                .map(Self::Plane)
                .collect(),
        ]
    }

    /// This primitive with its parameters changed by `x`; the centre in units of `scale_m`. `None` if the length of `x` is
    /// not [`parameter_count`](Self::parameter_count).
    pub(in crate::shape) fn perturbed(&self, x: &[f64], scale_m: f64) -> Option<Self> {
        match self {
            Self::Sphere(s) => s.perturbed(x, scale_m).map(Self::Sphere),
            Self::Cylinder(c) => c.perturbed(x, scale_m).map(Self::Cylinder),
            Self::Plane(p) => p.perturbed(x, scale_m).map(Self::Plane),
            Self::Cuboid(b) => b.perturbed(x, scale_m).map(Self::Cuboid),
            Self::Cone(c) => c.perturbed(x, scale_m).map(Self::Cone),
            Self::Superquadric(s) => s.perturbed(x, scale_m).map(Self::Superquadric),
        }
    }
}
