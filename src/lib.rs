//! patrold guards a building from a patrol robot.
//!
//! Data walks one corridor, and the rooms below are listed in its order:
//! bytes -> scans -> sweep -> mixture -> distance -> novelty -> shape -> alarm -> log.
//! Every room's front page says what it takes and what it gives; a room may use the rooms listed
//! above it and never those below (`tests/layering.rs` keeps this). `evaluate` and
//! `reproduce` stand beside the corridor and walk it.

pub mod geometry;
pub mod formats;
pub mod scan;
pub mod sweep;
pub mod mixture;
pub mod distance;
pub mod novelty;
pub mod shape;
pub mod alarm;
pub mod patrol;
pub mod config;
pub mod store;
pub mod world;
pub mod devices;
pub mod service;
pub mod evaluate;
pub mod reproduce;
pub mod cli;
