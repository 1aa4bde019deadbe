//! `patrold waypoints [list|show NAME|restore NAME VERSION|forget NAME|rebuild NAME]`: the waypoints and their reference versions.

use super::failure::{CommandResult, DONE, Failure};
use super::local_time::local_time;
use super::{config, confirm, output, table, waypoint_rebuild};
use crate::service::record_time_now;
use crate::store::{Store, WaypointRow};
use clap::{Args, Subcommand};
use serde_json::{Value, json};
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
        /// Only this version of its reference
        #[arg(long, value_name = "N")]
        version: Option<i64>,
    },
    /// Make an older version of the reference the newest
    Restore {
        /// Name of the waypoint
        name: String,
        /// The version to restore
        version: i64,
        /// Make what these standing alarms show normal; without, nothing is restored while alarms stand
        #[arg(long, value_name = "ID", num_args = 1..)]
        accept: Vec<i64>,
    },
    /// Forget a waypoint; the log keeps its visits and alarms
    ///
    /// Lists what goes and asks; without a terminal it needs --yes.
    Forget {
        /// Name of the waypoint
        name: String,
        /// Do not ask
        #[arg(long)]
        yes: bool,
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
        Some(WaypointsAction::Show { name, version }) => {
            let store = Store::open_for_reading(dir)?;
            match version {
                None => show(&store, name, args.json),
                Some(version) => show_version(&store, name, *version, args.json),
            }
        }
        Some(WaypointsAction::Restore {
            name,
            version,
            accept,
        }) => {
            let mut store = Store::open_existing(dir)?;
            restore(&mut store, name, *version, accept, args.json)
        }
        Some(WaypointsAction::Forget { name, yes }) => {
            forget(&mut Store::open_existing(dir)?, name, *yes, args.json)
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
    let mut rows = table::table(&["version", "taken", "points", "components", "frame of"]);
    for reference in &waypoint.references {
        rows.add_row([
            reference.version.to_string(),
            local_time(&reference.taken_at, false),
            reference.points.to_string(),
            reference.components.to_string(),
            reference.frame_version.to_string(),
        ]);
    }
    output::line(rows.to_string())?;
    Ok(DONE)
}

fn show_version(store: &Store, name: &str, version: i64, as_json: bool) -> CommandResult {
    let stored = store.reference_version(name, version)?;
    let engine: Value = serde_json::from_str(&stored.engine).unwrap_or_default();
    if as_json {
        output::json(&json!({
            "waypoint": name,
            "version": stored.version,
            "frame": stored.positions_frame(name),
            "in_use": stored.in_use,
            "points": stored.view.points.len(),
            "no_return": stored.view.no_return.len(),
            "components": stored.components,
            "mixture": stored.mixture.state(),
            "engine": engine,
        }))?;
        return Ok(DONE);
    }
    let in_use = if stored.in_use {
        "in use"
    } else {
        "not in use"
    };
    output::line(format!(
        "reference {}: {in_use}, positions in the frame of {}\n  {} points, {} directions without a return\n  {} components, the mixture is {}",
        stored.frame(name),
        stored.positions_frame(name),
        stored.view.points.len(),
        stored.view.no_return.len(),
        stored.components,
        stored.mixture.state()
    ))?;
    Ok(DONE)
}

fn restore(
    store: &mut Store,
    name: &str,
    version: i64,
    accept: &[i64],
    as_json: bool,
) -> CommandResult {
    let new = store.restore_reference(name, version, accept, &record_time_now())?;
    if as_json {
        output::json(&json!({"waypoint": name, "restored": version, "version": new}))?;
    } else {
        output::line(format!(
            "reference {name}/{version} is in use again, as version {new}"
        ))?;
    }
    Ok(DONE)
}

fn forget(store: &mut Store, name: &str, yes: bool, as_json: bool) -> CommandResult {
    let waypoint = store.waypoint(name)?;
    if !yes {
        let what = format!(
            "{name}: {} reference version(s) go out of use, {} standing alarm(s) are cleared; visits and alarms stay in the log",
            waypoint.references.len(),
            waypoint.row.standing_alarms
        );
        if !confirm::can_ask() {
            return Err(Failure::Usage(format!("{what}; to do so give --yes")));
        }
        if !confirm::confirm(&format!("{what}\nforget {name}?"))? {
            return Err(Failure::Failed(format!("{name}: not forgotten")));
        }
    }
    store.forget_waypoint(name, &record_time_now())?;
    if as_json {
        output::json(&json!({"forgotten": name}))?;
    } else {
        output::line(format!("waypoint {name} forgotten"))?;
    }
    Ok(DONE)
}
