//! The effect of a visit on its waypoint's incidents. Takes what the visit saw and the incidents that are known there; gives
//! one decision for each: raised, seen again, moved, changed, gone, back.

mod answer;
mod assignment;
mod constants;
mod incident;
mod likeness;
mod log_histogram;
mod position;
mod rule;
mod sighting;
mod threshold;

pub use answer::AlarmAnswer;
pub use incident::{AlarmState, Incident, Relation};
pub use log_histogram::{HistogramBin, LogHistogram};
pub use position::{GuardPosition, floor_height_m};
pub use rule::{AlarmDecision, VisitFacts, decide};
pub use sighting::{Lengths, SHAPE_CLASSES, Sighting};
pub use threshold::{AlarmCounts, PastCase, PastDistance, ThresholdEffect, ThresholdStudy};
