//! The words in which a shape is told.

use nalgebra::{Matrix3, Point3};

/// What a novelty may be.
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
    /// The data supports more than one class; the alternatives say which.
    Ambiguous,
}

/// How a shape was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Method {
    /// Method A, section IV.A: random sampling consensus.
    Ransac,
    /// Method B, section IV.B: covariance matching.
    Covariance,
}

/// A class that the data supports less, or as much.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alternative {
    /// The class.
    pub class: Class,
    /// Its posterior probability among the classes tried.
    pub probability: f64,
}

/// One geometric primitive with its place, attitude and size, in the frame of the points.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// What it is.
    pub class: Class,
    /// How it was found.
    pub method: Method,
    /// Posterior probability of the class among those tried.
    pub probability: f64,
    /// The other classes, most probable first; of an ambiguous shape all of them. What is not listed is less
    /// probable than 0.01, or was ruled out.
    pub alternatives: Vec<Alternative>,
    /// Centre, metres.
    pub centre: Point3<f64>,
    /// Standard deviation of the centre, metres.
    pub centre_sd_m: [f64; 3],
    /// Columns are the shape's axes; a right-handed rotation.
    pub rotation: Matrix3<f64>,
    /// Full lengths along those axes, metres.
    pub size_m: [f64; 3],
    /// Standard deviation of the size, metres.
    pub size_sd_m: [f64; 3],
    /// e1 and e2 of a superquadric.
    pub exponents: Option<[f64; 2]>,
    /// Root mean square distance of its points from its surface, metres.
    pub residual_m: f64,
    /// How many points lie on it.
    pub inliers: usize,
}

/// Everything retrieved for one novelty.
#[derive(Debug, Clone, PartialEq)]
pub struct Retrieval {
    /// The chosen answer.
    pub best: Shape,
    /// Method B's own answer, where it ran.
    pub covariance: Option<Shape>,
    /// Method A's own answer, where it ran.
    pub ransac: Option<Shape>,
    /// Several primitives with disjoint points, where one does not do (a person); else empty.
    pub parts: Vec<Shape>,
}
