//! Takes points, gives Gaussian mixtures (paper section III.A, Eq. 1-4).

mod gaussian;
mod model;

pub use gaussian::Gaussian;
pub use model::Mixture;
