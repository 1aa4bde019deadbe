//! Takes points, gives Gaussian mixtures (paper section III.A, Eq. 1-4).

pub mod constants;
pub mod em;
mod error;
mod exponential;
mod gaussian;
mod kernel;
mod lattice;
mod model;
mod record;
pub mod symmetric;

pub use em::{Collapse, EmSettings, Fit, Stopped};
pub use error::MixtureError;
pub use gaussian::{Density, Gaussian};
pub use model::Mixture;
pub use record::MixtureRecord;
