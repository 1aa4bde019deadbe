//! The two devices emulated in a world: pure in virtual time ([`Emulation`]), and on pseudo-terminals or TCP in the time of
//! a clock ([`Emulator`]).

mod constants;
mod emulation;
mod on_ports;
mod error;
mod fault;
mod held_output;
mod plug;
mod port;

pub use emulation::{Emulation, EmulationOptions};
pub use error::EmulatorError;
pub use fault::{EmulatedFault, EmulatedFaultError};
pub use on_ports::{Emulator, EmulatorLag, EmulatorPorts};
pub use plug::UnplugFault;
