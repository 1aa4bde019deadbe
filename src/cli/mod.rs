//! Takes a command line, gives an exit code: one file per command, nothing but asking the other rooms and
//! telling people or programs what they said.

mod alarm_report;
mod alarms;
mod args;
mod calibrate;
mod calibration_report;
mod client;
mod clouds;
mod compare;
mod config;
mod demo;
mod devices;
mod distance;
mod emulate;
mod evaluate;
mod failure;
mod files;
mod fit;
mod output;
mod progress;
mod rejudge;
mod reproduce;
mod run;
mod shapes;
mod stopwatch;
mod scenes;
mod signals;
mod sweep;
mod table;
mod teach;
mod visit;
mod waypoints;
mod when;

pub use args::{Cli, run};
