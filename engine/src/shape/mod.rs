//! Takes the points and Gaussians of one novelty, gives its shape (paper section IV).
//!
//! Method B (`covariance`) matches the exact moments of every class's visible surface; method A
//! (`ransac`) consumes points or samples on the Gaussians' ellipsoids; `retrieve` asks both and
//! chooses.

mod constants;
mod continued;
mod covariance;
mod edges;
mod euclidean;
mod faces;
mod hidden;
#[cfg(test)]
mod laws;
mod lengths;
mod lonely;
mod matching;
mod model;
mod moments;
mod primitive;
#[cfg(test)]
mod printed;
pub mod ransac;
#[cfg(test)]
mod recorded;
mod remains;
mod retrieve;
#[cfg(test)]
mod scenes;
mod settings;
mod starts;
#[cfg(test)]
mod trials;

pub use euclidean::primitives;
pub use model::{Alternative, Class, Method, Retrieval, Shape};
pub use moments::surface_moments;
pub use primitive::{Cone, Cuboid, Cylinder, Plane, Primitive, Sphere, Superquadric};
pub use retrieve::{ShapeError, retrieve};
pub use settings::{BeamDensity, Choice, RansacSource, ShapeSettings, SurfaceModel};
