//! Whole visits in virtual time: the patrol, the devices' state machines on emulated devices, and the engine, without
//! threads; `incident_histories` with a store.

mod device_faults;
mod displaced_robot;
pub(super) mod empty_sweep;
mod fault_cases;
mod incident_histories;
mod lost_steps;
mod return_to_start;
mod rounds;
mod scenes;
pub(super) mod stored_reference;
mod unplugging;
mod virtual_patrol;
