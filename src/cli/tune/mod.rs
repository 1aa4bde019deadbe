//! `patrold tune`: what other thresholds would have done to the past, and one of them put into force.

mod apply;
mod command;
mod picture;
mod report;

pub(super) use command::{TuneArgs, run};
