//! The Earth Mover's Distance between two mixtures, with its plan and duals (paper section III.B;
//! `docs/novelty.md section 7`).

mod bures;
mod constants;
mod emd;
mod error;
mod ground;
mod partial;
mod pricing;
mod simplex;
mod transport;

pub(crate) use emd::emd_with_prices;
pub use emd::{Emd, Flow, emd, emd_of_costs};
pub use error::DistanceError;
pub use ground::{CostMatrix, GroundDistance, cost_matrix};
pub use partial::{PartialEmd, partial_emd_of_costs};
