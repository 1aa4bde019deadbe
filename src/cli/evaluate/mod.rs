//! `patrold evaluate`: how often the engine is right, on hundreds of simulated pairs.

mod command;
mod miss;
mod report;

pub(crate) use command::{EvaluateArgs, run};
