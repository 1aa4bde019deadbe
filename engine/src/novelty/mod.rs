//! Finds what appeared and disappeared between two views (`docs/novelty.md`; paper section III.C, Algorithm 1).

mod algorithm1;
mod common_surface;
mod compared_view;
mod detect;
mod error;
mod ledger;
mod listing;
mod model;
mod moved;
mod noise;
mod observer;
mod outline;
mod prepared;
mod quantified_change;
mod quantify;
mod reference;
mod sampling;
mod segment;
mod settings;
mod surroundings;
mod verdict;
mod view_pair;
mod visibility;

pub use detect::{Detection, DetectionStage, detect};
pub use error::NoveltyError;
pub use model::{Novelty, NoveltyKind, Segment, Surroundings, Verdict};
use observer::ObserverView;
pub use prepared::PreparedView;
pub use reference::Reference;
pub use segment::measure;
pub use settings::{
    EvidenceSettings, NoveltySettings, QuantifySettings, RevisitModel, SegmentSettings,
    Segmentation, VerdictSettings,
};
pub use visibility::{Evidence, Visibility};
