//! `patrold teach NAME`: takes the reference of a waypoint through the service.

use super::failure::{CommandResult, DONE};
use super::{client, config, output};
use crate::service::replies::TeachReply;
use clap::Args;
use serde_json::json;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(super) struct TeachArgs {
    /// Name of the waypoint where the robot is; created where it is new
    name: String,
    /// Make what these standing alarms show normal; without, a waypoint with standing alarms is not taught
    #[arg(long, value_name = "ID", num_args = 1..)]
    accept: Vec<i64>,
    /// The name is new, though it is within two letters of a known one
    #[arg(long)]
    new: bool,
    /// Configuration file, for the socket of the service
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Report as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &TeachArgs) -> CommandResult {
    let settings = config::load_settings(args.config.as_deref())?;
    let options = json!({"accept": args.accept, "new": args.new});
    let reply: TeachReply =
        client::request_at_waypoint(&settings.api.socket, "/teach", &args.name, options)?;
    if args.json {
        output::json(&reply)?;
    } else {
        output::line(format!(
            "{}: reference version {}, {} points, {} components",
            reply.waypoint, reply.version, reply.points, reply.components
        ))?;
    }
    Ok(DONE)
}
