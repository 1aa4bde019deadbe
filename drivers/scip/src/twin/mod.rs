//! The device's side of a Hokuyo URG-04LX, and of its relatives UTM-30LX and UST: bytes in, bytes out, virtual time, faults as settings.
//!
//! Written from the protocol alone and sharing nothing with the host's driver beside it: the twin has its own encoder
//! and its own sums, so that one misreading cannot hide another. It owns no clock and no port. A caller hands it bytes
//! and instants ([`Twin::handle_bytes`], [`Twin::advance`]), takes what falls due ([`Twin::poll_output`]) and asks when
//! it should come back ([`Twin::next_event`]). What the head sees comes from the caller's [`Surroundings`], which are
//! asked for a revolution only when somebody is waiting for one.
//!
//! Walk through: [`options`](TwinOptions) say which sensor and in what state ([`option_text`]: as text), `request` cuts bytes into requests,
//! `commands`, `measuring` and `settings` answer them, `scanning` turns revolutions into replies, `output` paces them over the link, `fault` spoils
//! them, `engine` decides what happens next.

mod commands;
mod constants;
mod engine;
mod fault;
mod identity;
mod measuring;
mod motor;
mod noise;
pub mod option_text;
mod options;
mod output;
mod profile;
mod request;
mod scanning;
mod settings;
mod state;
mod streaming;
mod surroundings;
mod timer;
mod wire;

#[cfg(test)]
mod tests;

pub use engine::Twin;
pub use fault::{Fault, FaultParseError, FaultSpec};
pub use option_text::OptionError;
pub use options::{Link, StartState, TwinOptions};
pub use output::Output;
pub use profile::{Generation, KeyedSum, Profile, Scip1Lines};
pub use surroundings::Surroundings;

/// An instant of virtual time: the time since power was first applied to the emulation.
pub type Instant = std::time::Duration;
