//! The device's side of a PTU-D46: bytes and instants in, bytes with their instants out, in virtual time.
//!
//! Written from the protocol document alone (its section numbers are quoted beside the code). Nothing here knows the
//! host's driver. One [`Twin`] is one unit: feed it with [`Twin::handle_bytes`], let time pass with [`Twin::advance`],
//! fetch what it prints with [`Twin::poll_output`], and ask where the head really stands with [`Twin::true_position_at`].
//!
//! Reading order: [`options`] (what kind of unit it is; as text in [`option_text`]), `settings` (what commands change), `profile` (one axis's motion
//! on paper), `axis` (the same axis with stops, lost steps and a past; `segment` is a piece of it), `command`, `parser` and `commands` (text to effects),
//! `replies`, `reset`, `wire` (bytes on the line), [`fault`] (what goes wrong on demand), `unit` (the whole) and `clockwork` (what passes inside).
//!
//! Where the document leaves a point open the twin does this:
//!
//! - unknown commands, bad arguments and position commands in velocity mode: `! Illegal command`;
//! - `PA PB PU` while either axis moves: `! Illegal command while in motion`; `DR DF` likewise;
//! - `R` always calibrates both axes; `RE RP RT RD` only select what is reset at power-up, unless the option says otherwise;
//! - a failed calibration prints `! Reset failed`; E-series units then refuse position commands with `! Axis Error`;
//! - `@(...)` answers at the old speed and then changes it;
//! - on return from velocity mode the sign of the speed is ignored, and a speed of 0 counts as the lower bound.

mod axis;
mod clockwork;
mod command;
mod commands;
mod constants;
pub mod fault;
mod names;
pub mod option_text;
pub mod options;
mod parser;
mod profile;
mod replies;
mod reset;
mod segment;
mod settings;
mod unit;
mod wire;

#[cfg(test)]
mod tests;

pub use fault::{FaultError, FaultKind, FaultSpec};
pub use names::AxisName;
pub use option_text::OptionError;
pub use options::{InputDuringReset, LineEnd, Model, StartState, Supply, TwinOptions};
pub use unit::Twin;
pub use wire::Output;

/// A point of virtual time: the span since the epoch that the caller chose.
pub type Instant = std::time::Duration;
