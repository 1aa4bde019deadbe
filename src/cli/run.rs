//! `patrold run`: the service.

use super::failure::{DONE, Failure, Outcome};
use crate::service::{ServiceError, run as serve};
use clap::Args;
use link::Clock;
use std::path::PathBuf;

/// Arguments of `run`.
#[derive(Debug, Args)]
pub struct RunArgs {
    /// Configuration file [default: /etc/patrold/patrold.toml, if there is one]
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Seconds of the devices per second of the wall, for emulated devices that run at X times the wall's pace
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = super::emulate::scale)]
    time_scale: f64,
}

/// Runs `run`.
pub fn run(args: &RunArgs) -> Outcome {
    match serve(args.config.as_deref(), Clock::scaled(args.time_scale)) {
        Ok(()) => Ok(DONE),
        Err(ServiceError::Config(mistakes)) => Err(mistakes.into()),
        Err(error) => Err(Failure::failed(error)),
    }
}
