//! Drivers against emulated devices in virtual time: no threads, no sleeping, deterministic.

mod agreement;
pub mod rig;
mod calibration;
mod faults;
mod sweeps;
pub mod links;
