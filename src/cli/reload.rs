//! `patrold reload`: the service reads its configuration again; the exit code says whether it was taken.

use super::failure::{CommandResult, DONE, Failure};
use super::{client, config, output};
use clap::Args;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(super) struct ReloadArgs {
    /// Configuration file, for the socket of the service
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Report as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &ReloadArgs) -> CommandResult {
    // The new file may be the bad one: the service says what it thinks of it.
    let (settings, _) = crate::config::load_leniently(args.config.as_deref())?;
    let reply = client::request_reload(&settings.api.socket)?;
    if args.json {
        output::json(&reply)?;
    }
    if !reply.taken {
        let mistakes = reply.mistakes.join("\n");
        return Err(Failure::Usage(format!(
            "configuration not taken, the old one stays in force\n{mistakes}"
        )));
    }
    if !args.json {
        output::line(format!("in force: {}", config::sources_text(&reply.files)))?;
        for key in &reply.needs_restart {
            output::line(format!(
                "  {key} takes effect when the service is restarted"
            ))?;
        }
    }
    Ok(DONE)
}
