//! Gaussian mixtures of point clouds and how they are fitted (paper section III.A; `docs/novelty.md sections 3 and 12`).

mod bic;
pub(crate) mod constants;
pub mod em;
mod em_fit;
mod em_settings;
mod em_state;
mod error;
mod exponential;
mod fit;
mod gaussian;
pub(crate) mod instructions;
mod kernel;
pub mod kmeans;
pub(crate) mod linalg;
mod mml;
mod model;
mod morton;
mod point_blocks;
mod pool;
mod prepared_component;
mod record;
mod refit;
mod split;

pub use constants::{DEFAULT_MAX_COMPONENTS, DEFAULT_RESTARTS};
pub use em_fit::{Collapse, EmFit, FitStart, StopReason};
pub use em_settings::EmSettings;
pub use error::MixtureError;
pub use fit::{ComponentSelection, FitSettings, fit};
pub use gaussian::Gaussian;
pub use instructions::InstructionSet;
pub use model::Mixture;
pub use record::MixtureRecord;
pub use refit::{Refit, RefitSettings, Unexplained, refit};
pub use split::{SplitSettings, split_until_flat};
