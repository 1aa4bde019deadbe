//! Shared by the tests of the built program: running it, validating its JSON, simulated clouds.
#![allow(dead_code, reason = "each test program uses a part")]

pub(crate) mod clouds;
pub(crate) mod program;
pub(crate) mod schema;
pub(crate) mod stored_mixture;
