//! Simulated sensors: which beams they take, what the beams truly meet, how the sensors err about it.

mod cast;
mod law;
mod pattern;
mod rings;
mod setting;

pub use cast::{Met, cast, meet};
pub use setting::{BEAMS_PER_PROBE, Sensor, Setting, Sweep};
