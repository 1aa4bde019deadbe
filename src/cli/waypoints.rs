//! `patrold waypoints [list|show NAME|forget NAME]`: places and their reference versions.

use super::failure::{DONE, Outcome};
use super::{config, output, table};
use crate::service::stamp_now;
use crate::store::{Store, WaypointRow};
use clap::{Args, Subcommand};
use serde_json::json;
use std::path::PathBuf;

/// Arguments of `waypoints`.
#[derive(Debug, Args)]
pub struct WaypointsArgs {
    #[command(subcommand)]
    action: Option<Action>,
    /// Configuration file
    #[arg(long, value_name = "FILE", global = true)]
    config: Option<PathBuf>,
    /// Report as JSON
    #[arg(long, global = true)]
    json: bool,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// List all waypoints
    List,
    /// Show one waypoint with its reference versions
    Show {
        /// Its name
        name: String,
    },
    /// Forget a waypoint; the log keeps what happened there
    Forget {
        /// Its name
        name: String,
    },
}

/// Runs `waypoints`.
pub fn run(args: &WaypointsArgs) -> Outcome {
    let dir = config::settings(args.config.as_deref())?.store.dir;
    match &args.action {
        None | Some(Action::List) => list(&Store::open_for_reading(&dir)?, args.json),
        Some(Action::Show { name }) => show(&Store::open_for_reading(&dir)?, name, args.json),
        Some(Action::Forget { name }) => forget(&mut Store::open_existing(&dir)?, name, args.json),
    }
}

fn list(store: &Store, as_json: bool) -> Outcome {
    let waypoints = store.waypoints()?;
    if as_json {
        output::json(&json!({"waypoints": waypoints}))?;
    } else if waypoints.is_empty() {
        output::line("no waypoints yet; take a reference: patrold teach NAME")?;
    } else {
        let mut rows = table::table(&[
            "waypoint",
            "reference",
            "last visit",
            "verdict",
            "d_gmm (m)",
            "alarms",
        ]);
        for waypoint in &waypoints {
            rows.add_row(cells(waypoint));
        }
        output::line(rows.to_string())?;
    }
    Ok(DONE)
}

fn cells(waypoint: &WaypointRow) -> [String; 6] {
    let or_none = |text: &Option<String>| text.clone().unwrap_or_else(|| "-".to_owned());
    let reference = match (waypoint.reference_version, &waypoint.reference_taken_at) {
        (Some(version), Some(at)) => format!("version {version}, {at}"),
        _ => "-".to_owned(),
    };
    [
        waypoint.name.clone(),
        reference,
        or_none(&waypoint.last_visit_at),
        or_none(&waypoint.last_verdict),
        waypoint
            .last_d_gmm
            .map_or_else(|| "-".to_owned(), |d| format!("{d:.4}")),
        waypoint.standing_alarms.to_string(),
    ]
}

fn show(store: &Store, name: &str, as_json: bool) -> Outcome {
    let waypoint = store.waypoint(name)?;
    if as_json {
        output::json(&waypoint)?;
        return Ok(DONE);
    }
    let row = &waypoint.row;
    output::line(format!("{}, known since {}", row.name, row.created_at))?;
    output::line(format!("  standing alarms: {}", row.standing_alarms))?;
    for (verdict, at) in row.last_verdict.iter().zip(&row.last_visit_at) {
        output::line(format!("  last visit {at}: {verdict}"))?;
    }
    let mut rows = table::table(&["version", "taken", "points", "components"]);
    for reference in &waypoint.references {
        rows.add_row([
            reference.version.to_string(),
            reference.taken_at.clone(),
            reference.points.to_string(),
            reference.components.to_string(),
        ]);
    }
    output::line(rows.to_string())?;
    Ok(DONE)
}

fn forget(store: &mut Store, name: &str, as_json: bool) -> Outcome {
    store.forget_waypoint(name, &stamp_now())?;
    if as_json {
        output::json(&json!({"forgotten": name}))?;
    } else {
        output::line(format!("forgot waypoint {name}"))?;
    }
    Ok(DONE)
}
