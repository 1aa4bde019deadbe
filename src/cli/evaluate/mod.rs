//! `patrold evaluate`: how often the engine is right, on hundreds of simulated pairs.

mod command;
mod tell;

pub use command::{EvaluateArgs, run};
