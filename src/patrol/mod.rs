//! The patrol as a state machine: events of devices, clients and engine in, actions out.

mod constants;
pub mod action;
pub mod event;
pub mod machine;
pub mod name;
pub mod severity;
pub mod turn_history;
