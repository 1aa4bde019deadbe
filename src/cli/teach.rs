//! `patrold teach NAME`: the robot stands at NAME, take its reference.

use super::failure::{DONE, Outcome};
use super::{client, config, output};
use crate::service::replies::TeachReply;
use clap::Args;
use std::path::PathBuf;

/// Arguments of `teach`.
#[derive(Debug, Args)]
pub struct TeachArgs {
    /// The waypoint's name; made where it is new
    name: String,
    /// Configuration file; names the service's socket
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Report as JSON
    #[arg(long)]
    json: bool,
}

/// Runs `teach`.
pub fn run(args: &TeachArgs) -> Outcome {
    let settings = config::settings(args.config.as_deref())?;
    let taught: TeachReply = client::ask_at(&settings.api.socket, "/teach", &args.name)?;
    if args.json {
        output::json(&taught)?;
    } else {
        output::line(format!(
            "{}: reference version {}, {} points, {} components",
            taught.waypoint, taught.version, taught.points, taught.components
        ))?;
    }
    Ok(DONE)
}
