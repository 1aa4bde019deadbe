//! patrold guards a building from a patrol robot.
//!
//! The mathematics is in `patrold_engine`, the simulated building in `patrold_sim`. A module may use the modules listed
//! above it and never those below (`tests/layering.rs` keeps this).

pub mod alarm;
pub mod patrol;
pub mod config;
pub mod store;
pub mod devices;
pub mod service;
pub mod cli;
