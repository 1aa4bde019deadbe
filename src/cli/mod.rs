//! Takes a command line, gives an exit code: one file per command, nothing but asking the other rooms and
//! telling people or programs what they said.

mod alarm_report;
mod alarms;
mod args;
mod clouds;
mod compare;
mod config;
mod devices;
mod distance;
mod emulate;
mod failure;
mod files;
mod fit;
mod output;
mod progress;
mod rejudge;
mod shapes;
mod stopwatch;
mod scenes;
mod signals;
mod sweep;
mod table;
mod waypoints;
mod when;

pub use args::{Cli, run};
