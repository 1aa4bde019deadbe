//! Finds what appeared and disappeared between two views (`docs/novelty.md`; paper section III.C, Algorithm 1).

mod absorbing;
mod accepted;
mod algorithm1;
mod alone;
mod bounding_box;
mod common_surface;
mod compared_mixtures;
mod compared_view;
mod constants;
mod coverage;
mod detect;
mod error;
mod evidence;
mod gaps;
mod listing;
mod mixture_evidence;
mod model;
mod moved;
mod noise;
mod observer;
mod outline;
mod places;
mod plates;
mod plausible_view;
mod prediction;
mod prepared;
mod quantified_change;
mod reference;
mod reference_mixture;
mod sampling;
mod segment;
mod settings;
mod stored_view;
mod surroundings;
mod theta;
mod verdict;
mod view_pair;
mod visibility;

pub use accepted::accept_novelties;
pub use algorithm1::{ChangeSegmentation, Removal, RemovalExtent, segment_changes};
pub use compared_mixtures::{ComparedComponent, ComparedFlow, ComparedMixtures};
pub use coverage::Coverage;
pub use detect::{Detection, DetectionStage, detect};
pub use error::NoveltyError;
pub use evidence::{Evidence, Visibility};
pub use model::{AbsorbingThing, Novelty, NoveltyKind, Segment, Surroundings, Verdict};
use observer::ObserverView;
pub use places::{PlaceView, WatchedPlace, observe_places};
pub use prepared::PreparedView;
pub use reference::Reference;
pub use reference_mixture::{ComponentBeams, ReferenceMixture};
pub use segment::measure;
pub use settings::{
    EvidenceSettings, EvidenceSource, NoveltySettings, QuantifySettings, RevisitModel,
    SegmentSettings, VerdictSettings,
};
pub(crate) use verdict::unmatched_reason;
