//! Takes points, gives Gaussian mixtures (paper section III.A, Eq. 1-4).

mod ascent;
mod component;
pub mod constants;
mod curve;
pub mod em;
mod error;
mod exponential;
mod fit;
mod gaussian;
pub(crate) mod instructions;
mod kernel;
mod lattice;
pub mod mml;
mod model;
pub mod order;
mod pool;
mod record;
mod refit;
pub mod seed;
pub mod split;
pub mod symmetric;

pub use em::{Collapse, EmSettings, Fit, Start, Stopped};
pub use error::MixtureError;
pub use fit::{Components, FitSettings, fit};
pub use gaussian::{Density, Gaussian};
pub use instructions::Instructions;
pub use model::Mixture;
pub use record::MixtureRecord;
pub use refit::{Refit, RefitSettings, Unexplained, refit, sigmas_to_nearest};
pub use split::{SplitSettings, split_until_flat};
