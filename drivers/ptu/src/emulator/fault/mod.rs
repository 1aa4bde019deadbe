//! Fault injection: faults as text (`spec`), and when they strike (`schedule`).

mod schedule;
mod spec;

pub(super) use schedule::{FaultEffect, FaultSchedule};
pub use spec::{HeadFaultKind, HeadFaultSpec};
