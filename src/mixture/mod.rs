//! Takes points, gives Gaussian mixtures (paper section III.A, Eq. 1-4).

pub mod constants;
mod error;
mod gaussian;
mod model;
mod record;
pub mod symmetric;

pub use error::MixtureError;
pub use gaussian::{Density, Gaussian};
pub use model::Mixture;
pub use record::MixtureRecord;
