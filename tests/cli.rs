//! The command line as a contract: the built program, its exit codes, its JSON against `docs/schema`, its errors.

mod harness;

#[path = "cli/bad_files.rs"]
mod bad_files;
#[path = "cli/bad_input.rs"]
mod bad_input;
#[path = "cli/bad_usage.rs"]
mod bad_usage;
#[path = "cli/commands.rs"]
mod commands;
#[path = "cli/compare.rs"]
mod compare;
#[path = "cli/configuration.rs"]
mod configuration;
#[path = "cli/demo.rs"]
mod demo;
#[path = "cli/diagnose.rs"]
mod diagnose;
#[path = "cli/emulate.rs"]
mod emulate;
#[path = "cli/evaluate.rs"]
mod evaluate;
#[path = "cli/hardware.rs"]
mod hardware;
#[path = "cli/log.rs"]
mod log;
#[path = "cli/log_alarms.rs"]
mod log_alarms;
#[path = "cli/log_visits.rs"]
mod log_visits;
#[path = "cli/log_waypoints.rs"]
mod log_waypoints;
#[path = "cli/manifest.rs"]
mod manifest;
#[path = "cli/odd_devices.rs"]
mod odd_devices;
#[path = "cli/rejudge.rs"]
mod rejudge;
#[path = "cli/mixtures_out.rs"]
mod mixtures_out;
#[path = "cli/reference_mixture.rs"]
mod reference_mixture;
#[path = "cli/reproduce.rs"]
mod reproduce;
#[path = "cli/schemas.rs"]
mod schemas;
#[path = "cli/setup.rs"]
mod setup;
#[path = "cli/store.rs"]
mod store;
#[path = "cli/tune.rs"]
mod tune;
