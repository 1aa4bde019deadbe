//! A retrieved shape: class, pose, size and their uncertainties.

use nalgebra::{Matrix3, Point3};

/// Class of a shape; each gives the order of its size.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Class {
    /// Size (D, D, D).
    Sphere,
    /// Size (D, D, L), axis third.
    Cylinder,
    /// Size (A, B, 0), A >= B, normal third.
    Plane,
    /// Size Sx >= Sy >= Sz.
    Box,
    /// Size (D, D, H), axis third, towards the apex.
    Cone,
    /// Size along its own axes, with exponents.
    Superquadric,
    /// The data supports more than one class; see the alternatives.
    Ambiguous,
}

/// How a shape was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Method {
    /// Method A, paper section IV.A: random sample consensus.
    Ransac,
    /// Method B, paper section IV.B: covariance matching.
    Covariance,
}

/// Another class for the same points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alternative {
    /// Its class.
    pub class: Class,
    /// Posterior probability among the classes tried.
    pub probability: f64,
}

/// A primitive fitted to points, in their frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// Its class, or `Ambiguous`.
    pub class: Class,
    /// How it was found.
    pub method: Method,
    /// Posterior probability of the class among those tried.
    pub probability: f64,
    /// The other classes, most probable first; of an ambiguous shape all of them. Those less probable than 0.01 or ruled
    /// out early are not listed.
    pub alternatives: Vec<Alternative>,
    /// Centre, metres.
    pub centre: Point3<f64>,
    /// Standard deviation of the centre, metres.
    pub centre_sd_m: [f64; 3],
    /// The shape's axes as columns; right-handed.
    pub rotation: Matrix3<f64>,
    /// Full lengths along those axes, metres.
    pub size_m: [f64; 3],
    /// Standard deviation of the size, metres.
    pub size_sd_m: [f64; 3],
    /// e1 and e2 of a superquadric.
    pub exponents: Option<[f64; 2]>,
    /// Root mean square distance of the points from the surface, metres.
    pub residual_m: f64,
    /// How many points are on it.
    pub inliers: usize,
}

/// Everything retrieved for one novelty.
#[derive(Debug, Clone, PartialEq)]
pub struct Retrieval {
    /// The chosen answer.
    pub best: Shape,
    /// Method B's answer, where it ran.
    pub covariance: Option<Shape>,
    /// Method A's answer, where it ran.
    pub ransac: Option<Shape>,
    /// Several primitives with disjoint points, where one does not explain them (a person); else empty.
    pub parts: Vec<Shape>,
}
