//! `patrold alarms list|show|ack|export`: the alarm log, read from the database whether or not the service runs.

use super::alarm_report::{alarm_table, csv, details, json_lines, record};
use super::failure::{DONE, Failure, Outcome};
use super::{config, files, output, when};
use crate::alarm::State;
use crate::config::Settings;
use crate::service::stamp_now;
use crate::store::{AlarmFilter, Store};
use clap::{Args, Subcommand, ValueEnum};
use jiff::Timestamp;
use serde_json::json;
use std::path::PathBuf;

/// Arguments of `alarms`.
#[derive(Debug, Args)]
pub struct AlarmsArgs {
    #[command(subcommand)]
    action: Option<Action>,
    /// Configuration file
    #[arg(long, value_name = "FILE", global = true)]
    config: Option<PathBuf>,
    /// Report as JSON
    #[arg(long, global = true)]
    json: bool,
    #[command(flatten)]
    filters: Filters,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// List alarms, newest first
    List(Filters),
    /// Show one alarm with everything known about it
    Show {
        /// The alarm's number
        id: i64,
    },
    /// Acknowledge an alarm
    Ack(AckArgs),
    /// Write alarms as JSON lines or CSV
    Export(ExportArgs),
}

#[derive(Debug, Clone, Args)]
struct Filters {
    /// Only alarms whose change was last seen at or after this time (RFC 3339, a date, or 3h ago)
    #[arg(long, value_name = "TIME", value_parser = when::parse_from_now)]
    since: Option<Timestamp>,
    /// Only alarms raised at or before this time
    #[arg(long, value_name = "TIME", value_parser = when::parse_from_now)]
    until: Option<Timestamp>,
    /// Only alarms of this waypoint
    #[arg(long, value_name = "NAME")]
    waypoint: Option<String>,
    /// Only alarms in this state: open, acknowledged or cleared
    #[arg(long)]
    state: Option<State>,
    /// Only the newest so many
    #[arg(long, value_name = "N")]
    limit: Option<u32>,
}

#[derive(Debug, Args)]
struct AckArgs {
    /// The alarm's number
    id: i64,
    /// Who acknowledges [default: the user's login name]
    #[arg(long, value_name = "NAME")]
    by: Option<String>,
    /// What there is to say about it
    #[arg(long, value_name = "TEXT")]
    note: Option<String>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// One JSON object a line
    Jsonl,
    /// One line per thing that came or went
    Csv,
}

#[derive(Debug, Args)]
struct ExportArgs {
    #[command(flatten)]
    filters: Filters,
    /// How to write them [default: jsonl]
    #[arg(long, value_enum)]
    format: Option<Format>,
    /// Where to [default: standard output]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Runs `alarms`.
pub fn run(args: &AlarmsArgs) -> Outcome {
    let settings = config::settings(args.config.as_deref())?;
    let before = &args.filters;
    match &args.action {
        None => list(args, before.filter(), &settings),
        Some(Action::List(filters)) => list(args, filters.or(before).filter(), &settings),
        Some(Action::Export(export_args)) => export(args, export_args, &settings),
        Some(Action::Show { .. } | Action::Ack(_)) if !before.is_empty() => Err(Failure::Usage(
            "--since, --until, --waypoint, --state and --limit belong to list and export"
                .to_owned(),
        )),
        Some(Action::Show { id }) => show(args, *id, &settings),
        Some(Action::Ack(ack_args)) => acknowledge(args, ack_args, &settings),
    }
}

impl Filters {
    fn filter(&self) -> AlarmFilter {
        AlarmFilter {
            since: self.since,
            until: self.until,
            waypoint: self.waypoint.clone(),
            state: self.state,
            limit: self.limit,
        }
    }

    /// These, and those given before the command's name where these say nothing.
    fn or(&self, before: &Self) -> Self {
        Self {
            since: self.since.or(before.since),
            until: self.until.or(before.until),
            waypoint: self.waypoint.clone().or_else(|| before.waypoint.clone()),
            state: self.state.or(before.state),
            limit: self.limit.or(before.limit),
        }
    }

    fn is_empty(&self) -> bool {
        self.since.is_none()
            && self.until.is_none()
            && self.waypoint.is_none()
            && self.state.is_none()
            && self.limit.is_none()
    }
}

fn list(args: &AlarmsArgs, filter: AlarmFilter, settings: &Settings) -> Outcome {
    let alarms = Store::open_for_reading(&settings.store.dir)?.alarms(&filter)?;
    if args.json {
        let told: Vec<_> = alarms.iter().map(|a| record(a, settings)).collect();
        output::json(&json!({"alarms": told}))?;
    } else if alarms.is_empty() {
        output::line("no alarms")?;
    } else {
        output::line(alarm_table(&alarms))?;
    }
    Ok(DONE)
}

fn show(args: &AlarmsArgs, id: i64, settings: &Settings) -> Outcome {
    let alarm = Store::open_for_reading(&settings.store.dir)?.alarm(id)?;
    if args.json {
        output::json(&record(&alarm, settings))?;
    } else {
        output::line(details(&alarm, settings))?;
    }
    Ok(DONE)
}

fn acknowledge(args: &AlarmsArgs, ack: &AckArgs, settings: &Settings) -> Outcome {
    let mut store = Store::open_existing(&settings.store.dir)?;
    let login = || std::env::var("USER").unwrap_or_else(|_| "unknown".to_owned());
    let by = ack.by.clone().unwrap_or_else(login);
    let alarm = store.acknowledge(ack.id, &by, ack.note.as_deref(), &stamp_now())?;
    if args.json {
        output::json(&record(&alarm, settings))?;
    } else {
        output::line(format!(
            "alarm {} is {}, noted for {by}",
            alarm.id, alarm.state
        ))?;
    }
    Ok(DONE)
}

fn export(args: &AlarmsArgs, export: &ExportArgs, settings: &Settings) -> Outcome {
    if args.json && export.format == Some(Format::Csv) {
        return Err(Failure::Usage(
            "--json and --format csv contradict each other; choose one".to_owned(),
        ));
    }
    let filter = export.filters.or(&args.filters).filter();
    let alarms = Store::open_for_reading(&settings.store.dir)?.alarms(&filter)?;
    let text = match export.format.unwrap_or(Format::Jsonl) {
        Format::Jsonl => json_lines(&alarms, settings)?,
        Format::Csv => csv(&alarms, settings),
    };
    match &export.out {
        None if text.is_empty() => {}
        None => output::line(text.trim_end_matches('\n'))?,
        Some(path) => files::write(path, text.as_bytes())?,
    }
    Ok(DONE)
}
