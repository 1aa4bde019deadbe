//! Method A, section IV.A: random sampling consensus after Schnabel, Wahl and Klein (2007), and
//! the samples on the ellipsoids that it consumes.

mod candidate;
mod cells;
mod connect;
mod detect;
mod ellipsoid;
mod neighbours;
mod normals;
mod refit;
#[cfg(test)]
mod scenes;

pub use detect::{Detected, RansacSettings, detect};
pub use ellipsoid::surface_samples;
pub use normals::estimate_normals;
pub(super) use refit::smallest_rectangle;
