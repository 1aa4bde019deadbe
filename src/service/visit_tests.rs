//! Whole visits in virtual time: the patrol, the devices' state machines on emulated devices, and the engine, without
//! threads or disk.

mod device_faults;
mod displaced_robot;
mod lost_steps;
mod return_to_start;
pub(super) mod stored_reference;
mod unplugging;
mod virtual_patrol;
