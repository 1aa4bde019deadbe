//! The service `patrold`, which guards a building from a patrol robot, and its command line.
//!
//! The modules below are listed in the order of the pipeline; a module may use those above it, never those below
//! (`tests/layering.rs` checks it). The engine, the simulation and the drivers are crates of their own; ARCHITECTURE.md has
//! the map.

pub mod bounded_file;
pub mod alarm;
pub mod patrol;
pub mod config;
pub mod store;
pub mod devices;
pub mod service;
pub mod cli;
