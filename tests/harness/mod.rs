//! Shared by the tests of the built program: running it, validating its JSON, simulated clouds.
#![allow(dead_code, reason = "each test program uses a part")]

pub mod clouds;
pub mod program;
pub mod schema;
