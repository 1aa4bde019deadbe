//! `patrold alarms list|show|ack|export`: the alarm log, from the database whether or not the service runs.

use super::alarm_report::{alarm_csv, alarm_json, alarm_json_lines, alarm_table, alarm_text};
use super::failure::{CommandResult, DONE, Failure};
use super::{config, files, output, time_arg};
use crate::alarm::AlarmState;
use crate::config::Settings;
use crate::service::record_time_now;
use crate::store::{AlarmFilter, Store};
use clap::{Args, Subcommand, ValueEnum};
use jiff::Timestamp;
use serde_json::json;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(super) struct AlarmsArgs {
    #[command(subcommand)]
    action: Option<AlarmsAction>,
    /// Configuration file
    #[arg(long, value_name = "FILE", global = true)]
    config: Option<PathBuf>,
    /// Report as JSON
    #[arg(long, global = true)]
    json: bool,
    #[command(flatten)]
    filters: AlarmFilterArgs,
}

#[derive(Debug, Subcommand)]
enum AlarmsAction {
    /// List alarms, newest first
    List(AlarmFilterArgs),
    /// Show all details of one alarm
    Show {
        /// Number of the alarm
        id: i64,
    },
    /// Acknowledge an alarm
    Ack(AckArgs),
    /// Write alarms as JSON lines or CSV
    Export(ExportArgs),
}

#[derive(Debug, Clone, Args)]
struct AlarmFilterArgs {
    /// Only alarms whose change was last seen at or after this time (RFC 3339, a date, or 3h ago)
    #[arg(long, value_name = "TIME", value_parser = time_arg::parse_time)]
    since: Option<Timestamp>,
    /// Only alarms raised at or before this time
    #[arg(long, value_name = "TIME", value_parser = time_arg::parse_time)]
    until: Option<Timestamp>,
    /// Only alarms of this waypoint
    #[arg(long, value_name = "NAME")]
    waypoint: Option<String>,
    /// Only alarms in this state: open, acknowledged or cleared
    #[arg(long)]
    state: Option<AlarmState>,
    /// Only the newest N alarms
    #[arg(long, value_name = "N")]
    limit: Option<u32>,
}

#[derive(Debug, Args)]
struct AckArgs {
    /// Number of the alarm
    id: i64,
    /// Who acknowledges it [default: the user's login name]
    #[arg(long, value_name = "NAME")]
    by: Option<String>,
    /// A note to keep with the alarm
    #[arg(long, value_name = "TEXT")]
    note: Option<String>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ExportFormat {
    /// One JSON object per alarm
    Jsonl,
    /// One line per novelty
    Csv,
}

#[derive(Debug, Args)]
struct ExportArgs {
    #[command(flatten)]
    filters: AlarmFilterArgs,
    /// Output format [default: jsonl]
    #[arg(long, value_enum)]
    format: Option<ExportFormat>,
    /// Output file [default: standard output]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

pub(super) fn run(args: &AlarmsArgs) -> CommandResult {
    let settings = config::load_settings(args.config.as_deref())?;
    // Filters may also stand before the action.
    let outer = &args.filters;
    match &args.action {
        None => list(args, outer.filter(), &settings),
        Some(AlarmsAction::List(filters)) => list(args, filters.or(outer).filter(), &settings),
        Some(AlarmsAction::Export(export_args)) => export(args, export_args, &settings),
        Some(AlarmsAction::Show { .. } | AlarmsAction::Ack(_)) if !outer.is_empty() => {
            Err(Failure::Usage(
                "--since, --until, --waypoint, --state and --limit belong to list and export"
                    .to_owned(),
            ))
        }
        Some(AlarmsAction::Show { id }) => show(args, *id, &settings),
        Some(AlarmsAction::Ack(ack_args)) => acknowledge(args, ack_args, &settings),
    }
}

impl AlarmFilterArgs {
    fn filter(&self) -> AlarmFilter {
        AlarmFilter {
            since: self.since,
            until: self.until,
            waypoint: self.waypoint.clone(),
            state: self.state,
            limit: self.limit,
        }
    }

    /// These filters; where one is not given, that of `outer`.
    fn or(&self, outer: &Self) -> Self {
        Self {
            since: self.since.or(outer.since),
            until: self.until.or(outer.until),
            waypoint: self.waypoint.clone().or_else(|| outer.waypoint.clone()),
            state: self.state.or(outer.state),
            limit: self.limit.or(outer.limit),
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

fn list(args: &AlarmsArgs, filter: AlarmFilter, settings: &Settings) -> CommandResult {
    let alarms = Store::open_for_reading(&settings.store.dir)?.alarms(&filter)?;
    if args.json {
        let records: Vec<_> = alarms.iter().map(|a| alarm_json(a, settings)).collect();
        output::json(&json!({"alarms": records}))?;
    } else if alarms.is_empty() {
        output::line("no alarms")?;
    } else {
        output::line(alarm_table(&alarms))?;
    }
    Ok(DONE)
}

fn show(args: &AlarmsArgs, id: i64, settings: &Settings) -> CommandResult {
    let alarm = Store::open_for_reading(&settings.store.dir)?.alarm(id)?;
    if args.json {
        output::json(&alarm_json(&alarm, settings))?;
    } else {
        output::line(alarm_text(&alarm, settings))?;
    }
    Ok(DONE)
}

fn acknowledge(args: &AlarmsArgs, ack: &AckArgs, settings: &Settings) -> CommandResult {
    let mut store = Store::open_existing(&settings.store.dir)?;
    let login = || std::env::var("USER").unwrap_or_else(|_| "unknown".to_owned());
    let by = ack.by.clone().unwrap_or_else(login);
    let alarm = store.acknowledge(ack.id, &by, ack.note.as_deref(), &record_time_now())?;
    if args.json {
        output::json(&alarm_json(&alarm, settings))?;
    } else {
        output::line(format!(
            "alarm {}: acknowledgement by {by} stored; state {}",
            alarm.id, alarm.state
        ))?;
    }
    Ok(DONE)
}

fn export(args: &AlarmsArgs, export: &ExportArgs, settings: &Settings) -> CommandResult {
    if args.json && export.format == Some(ExportFormat::Csv) {
        return Err(Failure::Usage(
            "--json and --format csv exclude each other; give one".to_owned(),
        ));
    }
    let filter = export.filters.or(&args.filters).filter();
    let alarms = Store::open_for_reading(&settings.store.dir)?.alarms(&filter)?;
    let text = match export.format.unwrap_or(ExportFormat::Jsonl) {
        ExportFormat::Jsonl => alarm_json_lines(&alarms, settings)?,
        ExportFormat::Csv => alarm_csv(&alarms, settings),
    };
    match &export.out {
        None if text.is_empty() => {}
        None => output::line(text.trim_end_matches('\n'))?,
        Some(path) => files::write(path, text.as_bytes())?,
    }
    Ok(DONE)
}
