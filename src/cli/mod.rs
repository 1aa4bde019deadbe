//! A command line in, an exit code out. Each command has a file or folder of its name (`waypoints rebuild` has one of its own); it parses arguments, calls the other
//! modules and reports the result as text or JSON.
//!
//! | file | what several commands share |
//! |---|---|
//! | `args`, `failure` | all commands; exit codes and errors |
//! | `value_parsers`, `time_arg` | parsers of option values |
//! | `filter_args`, `alarm_filter_args` | options that select a part of the log |
//! | `files`, `clouds`, `scenes` | files named on the command line |
//! | `output`, `table`, `local_time`, `progress`, `alarm_report`, `calibration_report`, `status_report`, `stopwatch` | what a command prints |
//! | `threshold_warning` | what `tune` and `config check` warn of |
//! | `drop_in` | what `tune --apply` and `setup` write into the configuration |
//! | `client`, `signals` | the socket of the service; SIGINT and SIGTERM |
//! | `confirm` | whether a person means it |
//! | `experiment` | what `evaluate` and `reproduce` share |
//! | `mixtures_out` | what `compare` and `rejudge` write for `distance` |

mod alarm_accept;
mod alarm_filter_args;
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
mod confirm;
mod demo;
mod devices;
mod distance;
mod diagnose;
mod drop_in;
mod emulate;
mod evaluate;
mod events;
mod experiment;
mod failure;
mod files;
mod filter_args;
mod fit;
mod fuse;
mod local_time;
mod mixtures_out;
mod output;
mod progress;
mod rejudge;
mod reload;
mod reproduce;
mod run;
mod scenes;
mod setup;
mod shapes;
mod signals;
mod status;
mod status_report;
mod stopwatch;
mod store;
mod sweep;
mod table;
mod teach;
mod threshold_warning;
mod time_arg;
mod tune;
mod value_parsers;
mod visit;
mod visits;
mod waypoint_rebuild;
mod waypoints;

pub use args::{Cli, run};
