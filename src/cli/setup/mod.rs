//! `patrold setup`: from two devices that are plugged in to a configuration that names them, with pictures of what they see.

mod command;
mod picture;
mod search;

pub(super) use command::{SetupArgs, run};
