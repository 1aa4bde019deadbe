//! `patrold run`: the service.

use super::failure::{CommandResult, DONE, Failure};
use super::value_parsers;
use crate::service::{ServiceError, run as run_service};
use clap::Args;
use link::Clock;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(super) struct RunArgs {
    /// Configuration file [default: /etc/patrold/patrold.toml, if there is one]
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// For emulated devices: device seconds per second of wall time, as given to `emulate`
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = value_parsers::parse_time_scale)]
    time_scale: f64,
}

pub(super) fn run(args: &RunArgs) -> CommandResult {
    match run_service(args.config.as_deref(), Clock::scaled(args.time_scale)) {
        Ok(()) => Ok(DONE),
        Err(ServiceError::Config(errors)) => Err(errors.into()),
        Err(error) => Err(Failure::failed(error)),
    }
}
