//! `patrold waypoints [list|show NAME|forget NAME|rebuild NAME]`: the waypoints and their reference versions.

use super::failure::{CommandResult, DONE};
use super::local_time::local_time;
use super::{config, output, table, waypoint_rebuild};
use crate::service::record_time_now;
use crate::store::{Store, WaypointRow};
use clap::{Args, Subcommand};
use serde_json::json;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(super) struct WaypointsArgs {
    #[command(subcommand)]
    action: Option<WaypointsAction>,
    /// Configuration file
    #[arg(long, value_name = "FILE", global = true)]
    config: Option<PathBuf>,
    /// Report as JSON
    #[arg(long, global = true)]
    json: bool,
}

#[derive(Debug, Subcommand)]
enum WaypointsAction {
    /// List all waypoints
    List,
    /// Show one waypoint with its reference versions
    Show {
        /// Name of the waypoint
        name: String,
    },
    /// Forget a waypoint; the log keeps its visits and alarms
    Forget {
        /// Name of the waypoint
        name: String,
    },
    /// Make the mixture of the reference anew from its stored view, with the current settings
    ///
    /// For a mixture that is damaged. The service may run; its next visit uses the new one.
    Rebuild {
        /// Name of the waypoint
        name: String,
        /// Another version than the newest, for `rejudge` of an old visit
        #[arg(long, value_name = "N")]
        reference_version: Option<i64>,
    },
}

pub(super) fn run(args: &WaypointsArgs) -> CommandResult {
    let file = args.config.as_deref();
    let settings = match &args.action {
        None | Some(WaypointsAction::List | WaypointsAction::Show { .. }) => {
            config::load_for_reading(file)?
        }
        Some(_) => config::load_settings(file)?,
    };
    let dir = &settings.store.dir;
    match &args.action {
        None | Some(WaypointsAction::List) => list(&Store::open_for_reading(dir)?, args.json),
        Some(WaypointsAction::Show { name }) => {
            show(&Store::open_for_reading(dir)?, name, args.json)
        }
        Some(WaypointsAction::Forget { name }) => {
            forget(&mut Store::open_existing(dir)?, name, args.json)
        }
        Some(WaypointsAction::Rebuild {
            name,
            reference_version,
        }) => waypoint_rebuild::run(&settings, name, *reference_version, args.json),
    }
}

fn list(store: &Store, as_json: bool) -> CommandResult {
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
        (Some(version), Some(at)) => format!("version {version}, {}", local_time(at, false)),
        _ => "-".to_owned(),
    };
    [
        waypoint.name.clone(),
        reference,
        or_none(
            &waypoint
                .last_visit_at
                .as_deref()
                .map(|at| local_time(at, false)),
        ),
        or_none(&waypoint.last_verdict),
        waypoint
            .last_d_gmm
            .map_or_else(|| "-".to_owned(), |d| format!("{d:.4}")),
        waypoint.standing_alarms.to_string(),
    ]
}

fn show(store: &Store, name: &str, as_json: bool) -> CommandResult {
    let waypoint = store.waypoint(name)?;
    if as_json {
        output::json(&waypoint)?;
        return Ok(DONE);
    }
    let row = &waypoint.row;
    output::line(format!(
        "{}, known since {}",
        row.name,
        local_time(&row.created_at, false)
    ))?;
    output::line(format!("  standing alarms: {}", row.standing_alarms))?;
    for (verdict, at) in row.last_verdict.iter().zip(&row.last_visit_at) {
        output::line(format!("  last visit {}: {verdict}", local_time(at, false)))?;
    }
    let mut rows = table::table(&["version", "taken", "points", "components"]);
    for reference in &waypoint.references {
        rows.add_row([
            reference.version.to_string(),
            local_time(&reference.taken_at, false),
            reference.points.to_string(),
            reference.components.to_string(),
        ]);
    }
    output::line(rows.to_string())?;
    Ok(DONE)
}

fn forget(store: &mut Store, name: &str, as_json: bool) -> CommandResult {
    store.forget_waypoint(name, &record_time_now())?;
    if as_json {
        output::json(&json!({"forgotten": name}))?;
    } else {
        output::line(format!("waypoint {name} forgotten"))?;
    }
    Ok(DONE)
}
