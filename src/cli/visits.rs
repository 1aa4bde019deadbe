//! `patrold visits [list|show ID]`: the log of visits, from the database whether or not the service runs.

use super::alarm_report::novelty_text;
use super::failure::{CommandResult, DONE};
use super::filter_args::RangeArgs;
use super::local_time::local_time;
use super::{config, output, table};
use crate::store::{Store, VisitDetail, VisitFilter, VisitRow};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Subcommand};
use patrold_engine::novelty::Verdict;
use serde_json::json;
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true)]
pub(super) struct VisitsArgs {
    #[command(subcommand)]
    action: Option<VisitsAction>,
    #[command(flatten)]
    list: ListArgs,
}

#[derive(Debug, Subcommand)]
enum VisitsAction {
    /// List visits, newest first
    List(ListArgs),
    /// Show all details of one visit
    Show(ShowArgs),
}

#[derive(Debug, Args)]
struct ListArgs {
    #[command(flatten)]
    range: RangeArgs,
    /// Only visits of this waypoint
    #[arg(long, value_name = "NAME")]
    waypoint: Option<String>,
    /// Only visits with this verdict
    #[arg(long, value_parser = verdict())]
    verdict: Option<Verdict>,
    /// Only the newest N visits
    #[arg(long, value_name = "N", default_value_t = 100)]
    limit: u32,
    #[command(flatten)]
    common: CommonArgs,
}

#[derive(Debug, Args)]
struct ShowArgs {
    /// Number of the visit
    id: i64,
    #[command(flatten)]
    common: CommonArgs,
}

#[derive(Debug, Args)]
struct CommonArgs {
    /// Configuration file
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Report as JSON
    #[arg(long)]
    json: bool,
}

fn verdict() -> impl TypedValueParser<Value = Verdict> {
    let all = [Verdict::Quiet, Verdict::Changed, Verdict::NotObserved];
    PossibleValuesParser::new(all.map(Verdict::as_str)).map(move |name| {
        let found = all.into_iter().find(|verdict| verdict.as_str() == name);
        found.unwrap_or(Verdict::NotObserved)
    })
}

pub(super) fn run(args: &VisitsArgs) -> CommandResult {
    match &args.action {
        None => list(&args.list),
        Some(VisitsAction::List(args)) => list(args),
        Some(VisitsAction::Show(args)) => show(args),
    }
}

fn list(args: &ListArgs) -> CommandResult {
    let settings = config::load_for_reading(args.common.config.as_deref())?;
    let filter = VisitFilter {
        range: args.range.range(),
        waypoint: args.waypoint.clone(),
        verdict: args.verdict,
        limit: args.limit,
    };
    let visits = Store::open_for_reading(&settings.store.dir)?.visits(&filter)?;
    if args.common.json {
        output::json(&json!({"visits": visits}))?;
    } else if visits.is_empty() {
        output::line("no visits")?;
    } else {
        output::line(visit_table(&visits))?;
    }
    Ok(DONE)
}

fn visit_table(visits: &[VisitRow]) -> String {
    let mut rows = table::table(&[
        "id", "at", "waypoint", "verdict", "d_gmm", "u_th", "alarm", "reason",
    ]);
    for visit in visits {
        let alarms: Vec<String> = visit.alarms.iter().map(i64::to_string).collect();
        let distance = |x| table::distance_text(x, 4, visit.ground.as_deref());
        rows.add_row([
            visit.id.to_string(),
            local_time(&visit.at, visit.clock_unset),
            visit.waypoint.clone(),
            visit.verdict.replace('_', " "),
            distance(visit.d_gmm),
            distance(visit.u_th),
            alarms.join(", "),
            visit.reason.clone(),
        ]);
    }
    rows.to_string()
}

fn show(args: &ShowArgs) -> CommandResult {
    let settings = config::load_for_reading(args.common.config.as_deref())?;
    let visit = Store::open_for_reading(&settings.store.dir)?.visit_detail(args.id)?;
    if args.common.json {
        output::json(&visit)?;
    } else {
        output::line(visit_text(&visit))?;
    }
    Ok(DONE)
}

fn visit_text(visit: &VisitDetail) -> String {
    let row = &visit.row;
    let distance = |x| table::distance_text(x, 6, row.ground.as_deref());
    let mut lines = vec![
        format!(
            "visit {} at {}: {}",
            row.id,
            row.waypoint,
            row.verdict.replace('_', " ")
        ),
        format!("  {}", local_time(&row.at, row.clock_unset)),
        format!(
            "  d_GMM {}, U_th {}: {}",
            distance(row.d_gmm),
            distance(row.u_th),
            row.reason
        ),
        match &row.coverage {
            Some(coverage) => format!("  {coverage}"),
            None => "  how much of the place was judged is not in the log".to_owned(),
        },
        match row.reference_version {
            Some(version) => format!(
                "  compared with reference version {version}, seed {}",
                visit.seed
            ),
            None => "  compared with no reference".to_owned(),
        },
        match (visit.points, visit.sweep_kept) {
            (None, _) => "  no sweep was taken".to_owned(),
            (Some(points), true) => format!(
                "  its sweep of {points} points is stored; judge it again: patrold rejudge {}",
                row.id
            ),
            (Some(points), false) => {
                format!("  its sweep of {points} points is not stored any more")
            }
        },
    ];
    lines.extend(
        row.alarms
            .iter()
            .map(|id| format!("  evidence of alarm {id}: patrold alarms show {id}")),
    );
    if !visit.novelties.is_empty() {
        lines.push(format!(
            "  positions in the frame of reference {}",
            visit.frame
        ));
    }
    let novelties = visit.novelties.iter();
    lines.extend(novelties.map(|n| format!("  {}, {} points", novelty_text(n), n.points)));
    lines.join("\n")
}
