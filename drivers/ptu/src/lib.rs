//! Driver for the Directed Perception PTU-D46 pan-tilt unit, sans-IO: bytes and instants in, actions out.
//!
//! The caller owns the port and the clock. It hands received bytes to [`PtuDriver::handle_bytes`], calls
//! [`PtuDriver::handle_deadline`] at [`PtuDriver::deadline`], and carries out what [`PtuDriver::poll_action`] returns: bytes to
//! send, events to act on. An instant is the [`Duration`](std::time::Duration) since an origin that the caller chooses, the same
//! for all calls.
//!
//! [`emulator`] is the device's side of the same protocol. `ptu-d46 section N` is a section of `docs/protocols/ptu-d46.md`,
//! `sweep-geometry section N` one of `docs/protocols/sweep-geometry.md`.

mod action;
mod axis;
mod command;
mod connect;
#[cfg(test)]
mod connect_tests;
mod constants;
mod dialogue;
#[cfg(test)]
mod dialogue_tests;
mod driver;
pub mod emulator;
mod error;
mod head_line;
#[cfg(test)]
mod hostile_tests;
mod identity;
mod line;
mod motion;
mod power;
mod reply;
#[cfg(test)]
mod reconnect_tests;
#[cfg(test)]
mod request_tests;
mod requests;
#[cfg(test)]
mod odd_unit_tests;
#[cfg(test)]
mod test_rig;
mod who_answers;

pub use action::{PtuAction, PtuEvent};
pub use axis::{Axis, AxisScale, Sign, StepSize};
pub use constants::BAUD_RATES;
pub use driver::{PtuDriver, PtuOptions};
pub use error::{HeadError, RequestError};
pub use head_line::HeadLine;
pub use identity::{AxisIdentity, AxisLimits, HeadIdentity, Health};
pub use motion::{MotionProfile, MoveState, MoveWatch};
pub use power::{HoldPower, MovePower};
