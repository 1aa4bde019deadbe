//! Directed Perception PTU-D46, sans-IO: bytes and instants in, actions out.
//!
//! The caller owns the port and the clock. It hands bytes to [`Head::handle_bytes`], wakes [`Head::handle_deadline`] at
//! [`Head::deadline`], and carries out what [`Head::poll_action`] gives: bytes to send, events to believe.
//!
//! Section numbers in the comments are those of the protocol document for the D46.

mod action;
mod axis;
#[cfg(test)]
mod bench;
mod command;
mod connect;
#[cfg(test)]
mod connect_tests;
mod constants;
mod head;
#[cfg(test)]
mod hostile_tests;
mod identity;
mod line;
mod motion;
mod power;
mod reply;
mod requests;
mod service;
#[cfg(test)]
mod service_tests;

pub use action::{Action, Counters, Event, HeadError, RequestError};
pub use axis::{Axis, AxisScale, Sign, StepSize};
pub use constants::BAUD_RATES;
pub use head::{Head, HeadOptions};
pub use identity::{AxisIdentity, AxisLimits, HeadIdentity, Health};
pub use motion::{MotionProfile, MoveState, MoveWatch};
pub use power::{HoldPower, MovePower};

/// Time since an origin the caller chose, the same for all calls.
pub type Instant = std::time::Duration;

pub mod twin;
