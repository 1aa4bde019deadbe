//! A building and the two devices of a patrol robot in it, simulated: [`world`] answers what a laser would measure, [`emulator`]
//! puts a Hokuyo URG-04LX and a PTU-D46 into it, byte for byte, on pseudo-terminals and TCP.

pub mod world;
pub mod emulator;
