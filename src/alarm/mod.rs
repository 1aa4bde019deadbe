//! Takes what a visit saw, gives what becomes of the waypoint's alarms: raise, fold into one that stands, clear.

mod incident;
mod rule;

pub use incident::{Incident, Sighting, State};
pub use rule::{Decision, decide};
