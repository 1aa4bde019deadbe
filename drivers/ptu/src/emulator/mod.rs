//! Emulator of a PTU-D46: bytes and instants in, bytes with their instants out, in virtual time.
//!
//! Written from `docs/protocols/ptu-d46.md` alone; it uses nothing of the driver. One [`EmulatedHead`] is one unit:
//! [`EmulatedHead::handle_bytes`] gives it bytes, [`EmulatedHead::advance`] lets time pass, [`EmulatedHead::poll_output`] returns
//! what it prints, and [`EmulatedHead::true_position_at`] where the head really points.
//!
//! Reading order: `options` and `option_text` (kind of unit and start state), `settings` (what commands change), `motion_profile`
//! (motion of one axis in closed form), `segment` and `axis` (the same with stops, lost steps and a history), `command`, `parser`
//! and `commands` (from text to effect), `replies`, `reset`, `wire` (bytes on the line), `fault` (fault injection), `state` (the whole
//! unit), `event_loop` (what happens between two calls), `head` (the interface).
//!
//! Where the document leaves a point open, the emulator does this:
//!
//! - unknown commands, bad arguments and position commands in velocity mode: `! Illegal command`;
//! - `PA PB PU` while either axis moves: `! Illegal command while in motion`; `DR DF` likewise;
//! - `R` always calibrates both axes; `RE RP RT RD` only select what is reset at power-up, unless the option differs;
//! - a failed calibration prints `! Reset failed`; E-series units then refuse position commands with `! Axis Error`;
//! - `@(...)` answers at the old speed and then changes it;
//! - on return from velocity mode the sign of the speed is ignored, and a speed of 0 counts as the lower bound.

mod axis;
mod axis_name;
mod command;
mod commands;
mod constants;
mod event_loop;
mod fault;
mod head;
mod option_text;
mod options;
mod parser;
mod motion_profile;
mod replies;
mod reset;
mod segment;
mod settings;
mod state;
mod wire;

#[cfg(test)]
mod tests;

pub use axis_name::AxisName;
pub use fault::{HeadFaultKind, HeadFaultSpec};
pub use option_text::HeadOptionError;
pub use options::{HeadModel, HeadOptions, HeadStartState, InputDuringReset, LineEnd, Supply};
pub use state::EmulatedHead;
pub use wire::HeadOutput;
