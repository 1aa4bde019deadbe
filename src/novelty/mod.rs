//! Takes two views and their mixtures, gives what changed (paper section III.C, Algorithm 1).

mod detect;
mod errors;
mod model;
pub mod noise;
mod prepared;
mod segment;
mod settings;
mod visibility;

pub use detect::{Found, find};
pub use errors::NoveltyError;
pub use model::{Kind, Novelty, Verdict};
pub use prepared::Prepared;
pub use segment::{Thing, segment};
pub use settings::{EvidenceSettings, SegmentSettings, Settings};
pub use visibility::{Evidence, Judge, Sight};
