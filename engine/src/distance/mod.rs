//! Takes two mixtures, gives the Earth Mover's Distance between them with its plan and duals (paper
//! section III.B, Eq. 5-6).

mod bures;
pub mod constants;
mod emd;
mod error;
mod ground;
mod pricing;
mod simplex;
mod transport;

pub use emd::{Emd, Flow, emd, emd_of_costs};
pub use error::DistanceError;
pub use ground::{CostMatrix, Ground, cost_matrix, euclid, fm, w2};
pub use transport::{Transport, transport};
