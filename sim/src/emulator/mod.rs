//! Takes a world, gives the two devices in it: pure in virtual time ([`Emulation`]), and on pseudo-terminals or TCP in
//! the time of a clock ([`Emulator`]).

mod constants;
mod emulation;
mod emulator;
mod end;
mod fault;
mod plug;

pub use emulation::{Emulation, EmulationOptions};
pub use emulator::{Emulator, EmulatorError, EmulatorPorts, Lag};
pub use fault::{EmulatedFault, EmulatedFaultError};
pub use plug::Unplug;
