//! Takes what the devices, the clients and the engine report, gives what to do next: a visit as a state machine, events in,
//! actions out.

mod constants;
pub mod action;
pub mod event;
pub mod machine;
