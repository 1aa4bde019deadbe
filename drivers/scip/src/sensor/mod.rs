//! The dialogue with one sensor: bytes and instants in, actions out.
//!
//! [`Sensor`] runs one of the dialogues below at a time; each is a small state machine of its own.
//!
//! | file | from | to |
//! |---|---|---|
//! | `connect` | anything, even a device left streaming, in time adjust or in SCIP 1.1 | identity known, idle, timer at zero |
//! | `time_exchange` | idle | idle, with pairs of host instants and timer values |
//! | `ask` | idle | idle, with `II` or one scan |
//! | `streaming` | idle | scans, until stopped; judges them by `continuity`, restarts a silent device |
//! | `stopping` | anything | idle, laser off |

mod action;
mod ask;
mod connect;
mod continuity;
mod dialogue;
mod exchange;
mod machine;
mod options;
mod stopping;
mod streaming;
mod time_exchange;

pub use action::{Action, Event, Identity, RecoveryCause, RecoveryStep, Rejection};
pub use machine::Sensor;
pub use options::{SensorOptions, StreamPlan};
