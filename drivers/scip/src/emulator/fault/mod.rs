//! Fault injection: which fault, when, for how long, how often.

mod schedule;
mod spec;

pub(super) use schedule::LaserFaultSchedule;
pub use spec::{LaserFault, LaserFaultSpec};
