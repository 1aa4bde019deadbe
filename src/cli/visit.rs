//! `patrold visit NAME`: inspects a waypoint through the service.

use super::failure::{CommandResult, verdict_exit_code};
use super::{alarm_report, client, config, output, value_parsers};
use crate::service::replies::VisitReply;
use clap::Args;
use serde_json::json;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(super) struct VisitArgs {
    /// Name of the waypoint where the robot is
    #[arg(value_parser = value_parsers::parse_waypoint_name)]
    name: String,
    /// Configuration file, for the socket of the service
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Report as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &VisitArgs) -> CommandResult {
    let settings = config::load_settings(args.config.as_deref())?;
    let socket = &settings.api.socket;
    let visit: VisitReply =
        client::request_at_waypoint(socket, "/visit", &args.name, json!({}), &args.name)?;
    if args.json {
        output::json(&visit)?;
    } else {
        output::line(visit_text(&visit))?;
    }
    Ok(verdict_exit_code(visit.verdict()))
}

fn visit_text(visit: &VisitReply) -> String {
    let mut lines = vec![format!(
        "{}: {} ({})",
        visit.waypoint,
        visit.verdict.replace('_', " "),
        visit.reason
    )];
    if let Some(d_gmm) = visit.d_gmm {
        lines.push(format!("  d_GMM {d_gmm:.6}, U_th {:.6}", visit.u_th));
    }
    lines.push(format!("  {}", visit.coverage));
    if let Some(why) = &visit.not_stored_because {
        lines.push(format!("  NOT STORED: {why}"));
    }
    if let Some(why) = &visit.evidence_missing_because {
        lines.push(format!("  its sweep is not stored yet: {why}"));
    }
    lines.extend(visit.alarms.iter().map(|alarm| format!("  {alarm}")));
    for cleared in &visit.cleared {
        lines.push(format!("  alarm {cleared} cleared"));
    }
    if !visit.novelties.is_empty() {
        lines.push(format!(
            "  positions in the frame of reference {}:",
            visit.frame
        ));
    }
    for novelty in &visit.novelties {
        lines.push(format!("  {}", alarm_report::novelty_text(novelty)));
    }
    lines.join("\n")
}
