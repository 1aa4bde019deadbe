//! `patrold run`: the service.

use super::failure::{DONE, Failure, Outcome};
use crate::service::{ServiceError, run as serve};
use clap::Args;
use std::path::PathBuf;

/// Arguments of `run`.
#[derive(Debug, Args)]
pub struct RunArgs {
    /// Configuration file [default: /etc/patrold/patrold.toml, if there is one]
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
}

/// Runs `run`.
pub fn run(args: &RunArgs) -> Outcome {
    match serve(args.config.as_deref()) {
        Ok(()) => Ok(DONE),
        Err(ServiceError::Config(mistakes)) => Err(mistakes.into()),
        Err(error) => Err(Failure::failed(error)),
    }
}
