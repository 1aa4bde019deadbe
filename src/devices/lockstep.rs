//! Drivers against twins in lockstep virtual time: no thread, no sleep, the same answer every time.

mod agreement;
pub mod bench;
mod calibration;
mod faults;
mod sweeps;
pub mod wires;
