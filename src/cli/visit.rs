//! `patrold visit NAME`: the robot stands at NAME, inspect it.

use super::failure::{Outcome, verdict_code};
use super::{alarm_report, client, config, output};
use crate::service::replies::VisitReply;
use clap::Args;
use std::path::PathBuf;

/// Arguments of `visit`.
#[derive(Debug, Args)]
pub struct VisitArgs {
    /// The waypoint's name
    name: String,
    /// Configuration file; names the service's socket
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Report as JSON
    #[arg(long)]
    json: bool,
}

/// Runs `visit`.
pub fn run(args: &VisitArgs) -> Outcome {
    let settings = config::settings(args.config.as_deref())?;
    let visit: VisitReply = client::ask_at(&settings.api.socket, "/visit", &args.name)?;
    if args.json {
        output::json(&visit)?;
    } else {
        output::line(told(&visit))?;
    }
    Ok(verdict_code(visit.verdict()))
}

fn told(visit: &VisitReply) -> String {
    let mut lines = vec![format!(
        "{}: {} ({})",
        visit.waypoint,
        visit.verdict.replace('_', " "),
        visit.reason
    )];
    if let Some(d_gmm) = visit.d_gmm {
        lines.push(format!("  d_GMM {d_gmm:.6}, U_th {:.6}", visit.u_th));
    }
    match visit.alarm {
        Some(alarm) if alarm.raised => lines.push(format!("  alarm {} raised", alarm.id)),
        Some(alarm) => lines.push(format!("  belongs to alarm {}", alarm.id)),
        None => {}
    }
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
        lines.push(format!("  {}", alarm_report::describe(novelty)));
    }
    lines.join("\n")
}
