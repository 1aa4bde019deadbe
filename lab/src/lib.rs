//! Experiments that measure the engine: [`evaluate`] counts how often it is right on simulated pairs of known truth,
//! [`reproduce`] repeats the experiments of the paper.

mod constants;
mod statistics;
mod timing;
pub mod evaluate;
pub mod reproduce;

pub use statistics::Rate;
pub use timing::{MillisClock, Timed};
