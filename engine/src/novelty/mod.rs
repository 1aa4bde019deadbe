//! Takes two views and their mixtures, gives what changed (paper section III.C, Algorithm 1).

mod algorithm1;
mod common_surface;
mod detect;
mod drawn;
mod errors;
mod ledger;
mod model;
mod moved;
mod noise;
mod outline;
mod prepared;
mod quantify;
mod rim;
mod sampling;
mod segment;
mod settings;
mod tell;
mod verdict;
mod visibility;

pub use detect::{Detection, Pair, Reference, Stage, detect};
pub use drawn::Onlooker;
pub use errors::NoveltyError;
pub use model::{Kind, Novelty, Verdict};
pub use noise::Between;
pub use prepared::Prepared;
pub use quantify::Balance;
pub use rim::Rim;
pub use segment::{Thing, measure, segment};
pub use settings::{
    EvidenceSettings, Model, QuantifySettings, SegmentSettings, Segmentation, Settings,
    VerdictSettings,
};
pub use visibility::{Evidence, Judge, Sight};
