//! Drivers against emulated devices in virtual time: no threads, no sleeping, deterministic.

mod agreement;
mod dialogues;
pub(crate) mod rig;
mod calibration;
mod faults;
mod sweeps;
pub(crate) mod links;
