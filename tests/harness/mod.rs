//! What the tests of the built program share: running it, checking its JSON, making clouds.
#![allow(dead_code, reason = "each test program uses its part")]

pub mod clouds;
pub mod program;
pub mod schema;
