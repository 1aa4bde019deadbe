//! `patrold teach NAME`: takes the reference of a waypoint through the service.

use super::failure::{CommandResult, DONE, Failure};
use super::{client, config, confirm, output, value_parsers};
use clap::Args;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(super) struct TeachArgs {
    /// Name of the waypoint where the robot is; created where it is new
    #[arg(value_parser = value_parsers::parse_waypoint_name)]
    name: String,
    /// Make what these standing alarms show normal; without, a waypoint with standing alarms is not taught
    #[arg(long, value_name = "ID", num_args = 1..)]
    accept: Vec<i64>,
    /// The name is new, though it is within two letters of a known one; without, a terminal is asked
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
    let request = |new, may_ask| {
        let socket = &settings.api.socket;
        client::request_teach(socket, &args.name, &args.accept, new, may_ask)
    };
    let not_taught = || Failure::Failed(format!("{}: not taught", args.name));
    let name = &args.name;
    let reply = match request(args.new, confirm::can_ask())? {
        Ok(reply) => reply,
        Err(known) => {
            let question =
                format!("there is no waypoint {name}, but {known}; is {name} a new one?");
            if !confirm::confirm(&question)? {
                return Err(not_taught());
            }
            request(true, false)?.map_err(|_| not_taught())?
        }
    };
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
