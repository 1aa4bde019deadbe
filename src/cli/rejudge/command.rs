//! One visit in full, or what differs in a stretch of the log.

use super::args::RejudgeArgs;
use super::{many, one};
use crate::cli::config;
use crate::cli::failure::{CommandResult, Failure};

pub(crate) fn run(args: &RejudgeArgs) -> CommandResult {
    let range = args.range.range();
    let selects = !range.is_all() || args.waypoint.is_some();
    match args.visit_ids[..] {
        [] if !selects => Err(Failure::Usage(
            "which visits? give their numbers, --since, --until or --waypoint".to_owned(),
        )),
        [_, ..] if selects => Err(Failure::Usage(
            "numbers of visits exclude --since, --until and --waypoint; give one of them"
                .to_owned(),
        )),
        [id] => one::run(args, id, config::load_settings(args.config.as_deref())?),
        _ if args.mixtures_out.is_some() => Err(Failure::Usage(
            "--mixtures-out is for one visit; give its number".to_owned(),
        )),
        ref ids => many::run(args, ids, &config::load_settings(args.config.as_deref())?),
    }
}
