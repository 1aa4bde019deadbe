//! `patrold store check|rebuild`: whether the store is whole; its database made anew from what is beside it.

use super::failure::{CommandResult, DONE, FAILED, Failure};
use super::progress::Work;
use super::{config, output};
use crate::service::{StoreLock, record_time_now};
use crate::store::{RebuildResult, Store, StoreCheck};
use clap::{Args, Subcommand};
use std::path::PathBuf;

/// Entries of each kind that the text lists; the JSON has all.
const MAX_LISTED: usize = 20;

#[derive(Debug, Args)]
pub(super) struct StoreArgs {
    #[command(subcommand)]
    action: StoreAction,
    /// Configuration file
    #[arg(long, value_name = "FILE", global = true)]
    config: Option<PathBuf>,
    /// Report as JSON
    #[arg(long, global = true)]
    json: bool,
}

#[derive(Debug, Subcommand)]
enum StoreAction {
    /// Check the database, every evidence file and the journal; the service may run
    ///
    /// Nothing is changed. Files that no row names are listed; they are no damage. The exit code is 1 where something is
    /// missing or damaged.
    Check,
    /// Make the database anew from the journal and the evidence files; the service must not run
    ///
    /// The old database is kept under another name.
    Rebuild,
}

pub(super) fn run(args: &StoreArgs) -> CommandResult {
    let settings = config::load_settings(args.config.as_deref())?;
    let dir = &settings.store.dir;
    match args.action {
        StoreAction::Check => {
            let work = Work::start("checking");
            let check =
                Store::open_for_reading(dir)?.check(|done, all| work.set_steps(done, all))?;
            drop(work);
            if args.json {
                output::json(&check)?;
            } else {
                output::line(check_text(&check))?;
            }
            Ok(if check.is_sound() { DONE } else { FAILED })
        }
        StoreAction::Rebuild => {
            let _lock = StoreLock::acquire(dir).map_err(Failure::failed)?;
            let rebuilt = Store::rebuild(dir, &record_time_now())?;
            if args.json {
                output::json(&rebuilt)?;
            } else {
                output::line(rebuild_text(&rebuilt))?;
            }
            Ok(DONE)
        }
    }
}

pub(super) fn check_text(check: &StoreCheck) -> String {
    let mut lines = Vec::new();
    for error in &check.database_errors {
        lines.push(format!("database: {error}"));
    }
    if check.database_errors.is_empty() {
        lines.push("database: sound".to_owned());
    }
    lines.push(format!("evidence: {} files sound", check.evidence_files));
    for missing in check.missing.iter().take(MAX_LISTED) {
        let of = match missing.visit_id {
            Some(visit) => format!("visit {visit} of {}", missing.waypoint),
            None => format!("a reference of {}", missing.waypoint),
        };
        lines.push(format!("  missing for {of}: {}", missing.why));
    }
    more(&mut lines, check.missing.len());
    let bytes: u64 = check.unnamed.iter().map(|file| file.bytes).sum();
    let unnamed = check.unnamed.len();
    lines.push(format!("files that no row names: {unnamed}, {bytes} bytes"));
    for file in check.unnamed.iter().take(MAX_LISTED) {
        lines.push(format!("  {} ({} bytes)", file.file, file.bytes));
    }
    more(&mut lines, unnamed);
    let journal = &check.journal;
    lines.push(format!(
        "journal: {} lines, {} damaged, {} changes to be added",
        journal.lines, journal.damaged_lines, journal.waiting_rows
    ));
    if journal.ahead > 0 {
        lines.push(format!(
            "  it knows {} changes that the database lost; stop the service and run patrold store rebuild",
            journal.ahead
        ));
    }
    lines.join("\n")
}

fn more(lines: &mut Vec<String>, count: usize) {
    if count > MAX_LISTED {
        lines.push(format!(
            "  and {} more (--json has all)",
            count - MAX_LISTED
        ));
    }
}

fn rebuild_text(rebuilt: &RebuildResult) -> String {
    let rows = |table: &str| rebuilt.rows.get(table).copied().unwrap_or(0);
    let mut lines = vec![format!(
        "rebuilt: {} waypoints, {} references, {} visits, {} alarms",
        rows("waypoint"),
        rows("reference"),
        rows("visit"),
        rows("alarm")
    )];
    for (count, what) in [
        (rebuilt.damaged_lines, "lines of the journal are damaged"),
        (
            rebuilt.incomplete_rows,
            "rows are left out: what they belong to is not in the journal",
        ),
        (rebuilt.evidence_missing, "sweeps have no sound files"),
        (
            rebuilt.unnamed_files,
            "evidence files that no row names are kept",
        ),
    ] {
        if count > 0 {
            lines.push(format!("  {count} {what}"));
        }
    }
    if let Some(path) = &rebuilt.old_database {
        lines.push(format!("  the old database is {}", path.display()));
    }
    lines.join("\n")
}
