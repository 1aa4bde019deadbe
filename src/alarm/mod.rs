//! The effect of a visit on its waypoint's alarms: raise a new one, extend a standing one, clear those that are over.

mod incident;
mod rule;

pub use incident::{AlarmState, Incident, Sighting};
pub use rule::{AlarmDecision, decide};
