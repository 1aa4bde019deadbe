//! What can go wrong, as settings: which fault, when, for how long, how often.

mod board;
mod spec;

pub(super) use board::FaultBoard;
pub use spec::{Fault, FaultParseError, FaultSpec};
