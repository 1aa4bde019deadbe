//! The answer of method B before it becomes a [`Shape`](crate::shape::Shape).

use crate::shape::primitive::Primitive;

/// The most probable primitive, in the frame of the points.
#[derive(Debug, Clone)]
pub(in crate::shape) struct PrimitiveEstimate {
    pub primitive: Primitive,
    pub centre_sd_m: [f64; 3],
    pub size_sd_m: [f64; 3],
    /// Posterior among all classes.
    pub probability: f64,
    /// Posterior among the classes that were fitted: a box hidden behind a flat front is left out, since no number of
    /// points would tell it from the plane.
    pub probability_among_fitted: f64,
}
