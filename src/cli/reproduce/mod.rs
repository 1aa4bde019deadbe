//! `patrold reproduce`: the tables and figures of the paper beside ours.

mod command;
mod figure_numbers;
mod figure_svg;
mod plan;
mod projection;
mod report;

pub(crate) use command::{ReproduceArgs, run};
