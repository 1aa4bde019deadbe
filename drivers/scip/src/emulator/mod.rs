//! An emulator of the Hokuyo URG-04LX and its relatives UTM-30LX and UST: bytes in, bytes out, in virtual time.
//!
//! It is written from `docs/protocols/scip2.md` and shares no code with the driver: with its own encoder and its own sums,
//! a misreading of the protocol on one side shows on the other. It has no clock and no port. The caller passes bytes and
//! instants ([`EmulatedLaser::handle_bytes`], [`EmulatedLaser::advance`]), takes what is due
//! ([`EmulatedLaser::poll_output`]) and asks when to come back ([`EmulatedLaser::next_event`]). Ranges come from the
//! caller's [`RangeSource`], which is asked only for revolutions that are sent. All instants are durations since an
//! origin that the caller chose.
//!
//! [`LaserOptions`] choose model and state (`option_text`: from text), `request` cuts bytes into requests, `commands`,
//! `measuring` and `settings` answer them, `scan_reply` encodes scans, `output` paces replies over the link, `fault`
//! injects faults, `emulated_laser` schedules it all.

mod commands;
mod constants;
mod emulated_laser;
mod fault;
mod identity;
mod measuring;
mod motor;
mod option_text;
mod options;
mod output;
mod profile;
mod range_source;
mod request;
mod rng;
mod scan_reply;
mod settings;
mod state;
mod status;
mod streaming;
mod timer;
mod window;
mod wire;

#[cfg(test)]
mod tests;

pub use emulated_laser::EmulatedLaser;
pub use fault::{LaserFault, LaserFaultSpec};
pub use option_text::LaserOptionError;
pub use options::{LaserLink, LaserOptions, LaserStartState};
pub use output::LaserOutput;
pub use profile::{KeyedSumRule, LaserGeneration, LaserProfile, Scip1Lines};
pub use range_source::RangeSource;
