//! Method A (paper section IV.A): random sample consensus after Schnabel, Wahl and Klein (2007), and the samples on
//! ellipsoids that it may be given.

mod bitmap;
mod candidate;
mod classes;
mod cloud;
mod constants;
mod detect;
mod ellipsoid;
mod extent;
mod fit;
mod kd_tree;
mod minimal;
mod normals;
mod octree;
mod patch;
mod sample;
mod score;
mod search;
mod surface;
#[cfg(test)]
mod tests;

pub(super) use classes::{ClassFit, fit_classes};
pub use detect::{Detected, RansacSettings, detect};
pub use ellipsoid::surface_samples;
pub(super) use extent::smallest_rectangle;
pub use normals::estimate_normals;
pub(super) use normals::spacing_m;
