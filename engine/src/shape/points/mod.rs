//! Which points belong to an object: outliers removed, points of the surroundings added.

pub(super) mod extension;
pub(super) mod outliers;
