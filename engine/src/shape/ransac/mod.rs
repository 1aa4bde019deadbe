//! Method A, section IV.A: random sampling consensus after Schnabel, Wahl and Klein (2007), and
//! the samples on the ellipsoids that it consumes.

mod bitmap;
mod candidate;
mod classes;
mod cloud;
mod constants;
mod detect;
mod ellipsoid;
mod extent;
mod fit;
mod minimal;
mod neighbours;
mod normals;
mod octree;
mod patch;
mod sample;
#[cfg(test)]
mod scenes;
mod score;
mod search;
mod surface;

pub(super) use classes::{Judged, classes};
pub use detect::{Detected, RansacSettings, detect, remainder};
pub use ellipsoid::surface_samples;
pub(super) use extent::smallest_rectangle;
pub use normals::estimate_normals;
pub(super) use normals::spacing_m;
