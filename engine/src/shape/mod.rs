//! The shape of one novelty: the primitive that its points lie on, with pose, size and uncertainty (paper section IV).
//!
//! Method B (`matching`) compares the moments of every class's visible surface with those of the points; method A
//! (`ransac`) searches the points, or samples on the Gaussians' ellipsoids, for primitives. `retrieve` runs both and
//! chooses.

mod consensus;
mod constants;
mod error;
mod matching;
mod model;
mod points;
mod primitive;
pub mod ransac;
mod retrieve;
mod settings;
#[cfg(test)]
mod tests;

pub use consensus::detect_shapes;
pub use constants::ELLIPSOID_SIGMAS;
pub use error::ShapeError;
pub use matching::moments::surface_moments;
pub use model::{Alternative, Class, Method, Retrieval, Shape};
pub use primitive::{Cone, Cuboid, Cylinder, Plane, Primitive, Sphere, Superquadric};
pub use retrieve::retrieve;
pub use settings::{BeamDensity, MethodChoice, RansacSource, ShapeSettings, SurfaceModel};
