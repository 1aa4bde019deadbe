//! A command line in, an exit code out. Each command has a file or folder of its name (`waypoints rebuild` has one of its own); it parses arguments, calls the other
//! modules and reports the result as text or JSON.
//!
//! | file | what several commands share |
//! |---|---|
//! | `args`, `failure` | all commands; exit codes and errors |
//! | `value_parsers`, `time_arg` | parsers of option values |
//! | `files`, `clouds`, `scenes` | files named on the command line |
//! | `output`, `table`, `progress`, `alarm_report`, `calibration_report`, `stopwatch` | what a command prints |
//! | `client`, `signals` | the socket of the service; SIGINT and SIGTERM |
//! | `experiment` | what `evaluate` and `reproduce` share |
//! | `mixtures_out` | what `compare` and `rejudge` write for `distance` |

mod alarm_report;
mod alarms;
mod args;
mod backup;
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
mod experiment;
mod failure;
mod files;
mod fit;
mod fuse;
mod mixtures_out;
mod output;
mod progress;
mod rejudge;
mod reproduce;
mod run;
mod scenes;
mod shapes;
mod signals;
mod stopwatch;
mod store;
mod sweep;
mod table;
mod teach;
mod time_arg;
mod value_parsers;
mod visit;
mod waypoint_rebuild;
mod waypoints;

pub use args::{Cli, run};
