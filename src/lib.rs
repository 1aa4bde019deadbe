//! patrold guards a building from a patrol robot.
//!
//! Data walks one corridor, and the rooms below are listed in its order:
//! bytes -> scans -> sweep -> mixture -> distance -> novelty -> shape -> alarm -> log.
//! Every room's front page says what it takes and what it gives; a room may use the rooms listed
//! above it and never those below (`tests/layering.rs` keeps this).

pub mod formats;
pub mod geometry;
pub mod mixture;
pub mod novelty;
pub mod shape;
pub mod world;
