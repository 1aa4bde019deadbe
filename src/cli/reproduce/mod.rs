//! `patrold reproduce`: the tables and figures of the paper beside ours.

mod command;
mod figure_numbers;
mod figure_scenes;
mod figure_svg;
mod panel;
mod plan;
mod projection;
mod removal_curve;
mod report;

pub(crate) use command::{ReproduceArgs, run};
