//! The dialogue with one laser: bytes and instants in, actions out.
//!
//! [`ScipDriver`] runs one of these dialogues at a time; each is a small state machine of its own:
//!
//! | file | from | to |
//! |---|---|---|
//! | `connecting` | anything, even left streaming, in time adjust or in SCIP 1.1 | identity known, idle, timer at zero |
//! | `raising_rate` | identified, on a slow line | the same at another bit rate, or at the old one |
//! | `time_exchange` | idle | idle, with pairs of host instants and timer values |
//! | `streaming` | idle | scans until stopped; `stamp_continuity` checks them, a silent device is restarted |
//! | `stopping` | anything | idle, laser off |
//!
//! Where no laser answers, `who_answers` judges by the bytes that came what is there instead.

mod action;
mod connecting;
mod dialogue;
mod error;
mod identity;
mod laser_line;
mod line_pace;
mod machine;
mod options;
mod pending_request;
mod raising_rate;
mod recovery;
mod stamp_continuity;
mod stopping;
mod streaming;
mod time_exchange;
mod who_answers;

pub use action::{LaserAction, LaserEvent, Rejection};
pub use error::ScipError;
pub use identity::LaserIdentity;
pub use laser_line::LaserLine;
pub use machine::ScipDriver;
pub use options::{ScipOptions, StreamPlan};
pub use recovery::{RecoveryCause, RecoveryStep};
