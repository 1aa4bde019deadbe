//! A simulated building with the two devices of a patrol robot in it: [`world`] computes what a laser measures there,
//! [`emulator`] serves a Hokuyo URG-04LX and a PTU-D46, byte for byte, on pseudo-terminals and TCP.

pub mod world;
pub mod emulator;
