//! `patrold demo`: a patrol without hardware, its alarms checked against the true changes.

mod building;
mod command;
mod report;
mod rounds;
mod system;
mod truth;

pub(crate) use command::{DemoArgs, run};
