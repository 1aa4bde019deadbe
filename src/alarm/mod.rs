//! The effect of a visit on its waypoint's alarms: raise a new one, extend a standing one, clear those that are over.

mod answer;
mod constants;
mod incident;
mod log_histogram;
mod position;
mod rule;
mod threshold;

pub use answer::AlarmAnswer;
pub use incident::{AlarmState, Incident, Sighting};
pub use log_histogram::{HistogramBin, LogHistogram};
pub use position::{GuardPosition, floor_height_m};
pub use rule::{AlarmDecision, decide};
pub use threshold::{AlarmCounts, PastCase, PastDistance, ThresholdEffect, ThresholdStudy};
