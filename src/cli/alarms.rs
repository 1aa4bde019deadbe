//! `patrold alarms list|show|ack|accept|export`: the alarm log, from the database whether or not the service runs.

use super::alarm_filter_args::AlarmFilterArgs;
use super::alarm_report::{
    CSV_HEADER, alarm_csv, alarm_json, alarm_json_for_guard, alarm_table, alarm_text,
};
use super::failure::{CommandResult, DONE, Failure};
use super::local_time::local_time;
use super::{alarm_accept, client, config, files, output};
use crate::alarm::{AlarmAnswer, floor_height_m};
use crate::config::Settings;
use crate::service::{operator, record_time_now};
use crate::store::{AlarmFilter, AlarmRow, Store};
use clap::{Args, Subcommand, ValueEnum};
use serde_json::json;
use std::path::PathBuf;

/// Alarms read at a time by `export`.
const PAGE: u32 = 200;
/// More than there are waypoints in any building.
const MAX_HEALTH_ROWS: u32 = 10_000;

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
    /// Make what the last visit saw of these alarms normal: a new version of the reference
    ///
    /// What appeared is part of it, what disappeared is not; what was hidden counts as not looked at. Nobody has to drive
    /// there. Other alarms stand on.
    Accept(AcceptArgs),
    /// Write alarms as JSON lines or CSV
    Export(ExportArgs),
}

#[derive(Debug, Args)]
struct AckArgs {
    /// Number of the alarm
    id: i64,
    /// Who acknowledges it, added to the user who runs this
    #[arg(long, value_name = "NAME")]
    by: Option<String>,
    /// Somebody was there: something had changed
    #[arg(long, conflicts_with = "false_alarm")]
    confirmed: bool,
    /// Somebody was there: nothing had changed
    #[arg(long)]
    false_alarm: bool,
    /// A note to keep with the alarm
    #[arg(long, value_name = "TEXT")]
    note: Option<String>,
}

#[derive(Debug, Args)]
struct AcceptArgs {
    /// Numbers of the alarms
    #[arg(required = true)]
    ids: Vec<i64>,
    /// Who accepts them, added to the user who runs this
    #[arg(long, value_name = "NAME")]
    by: Option<String>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ExportFormat {
    /// One JSON object per alarm
    Jsonl,
    /// One line per alarm, as it was last seen
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
    let file = args.config.as_deref();
    let settings = config::load_for_reading(file)?;
    // Filters may also stand before the action.
    let outer = &args.filters;
    match &args.action {
        None => list(args, outer, &settings),
        Some(AlarmsAction::List(filters)) => list(args, &filters.or(outer), &settings),
        Some(AlarmsAction::Export(export_args)) => export(args, export_args, &settings),
        Some(AlarmsAction::Show { .. } | AlarmsAction::Ack(_) | AlarmsAction::Accept(_))
            if *outer != AlarmFilterArgs::default() =>
        {
            let text = "options that select alarms belong to list and export; leave them out";
            Err(Failure::Usage(text.to_owned()))
        }
        Some(AlarmsAction::Show { id }) => show(args, *id, &settings),
        Some(AlarmsAction::Ack(ack_args)) => acknowledge(args, ack_args, &settings),
        Some(AlarmsAction::Accept(accept)) => {
            let by = accept.by.as_deref();
            alarm_accept::run(&settings, file, &accept.ids, by, args.json)
        }
    }
}

fn list(args: &AlarmsArgs, filters: &AlarmFilterArgs, settings: &Settings) -> CommandResult {
    let filter = filters.filter(settings)?;
    let store = Store::open_for_reading(&settings.store.dir)?;
    let alarms = store.alarms(&filter)?;
    let health = if filters.selects() {
        Vec::new()
    } else {
        store.health(true, MAX_HEALTH_ROWS)?
    };
    if args.json {
        let records: Vec<_> = alarms.iter().map(|a| alarm_json(a, settings)).collect();
        output::json(&json!({"alarms": records, "health": health}))?;
        return Ok(DONE);
    }
    if alarms.is_empty() {
        output::line("no alarms")?;
    } else {
        output::line(alarm_table(&alarms).to_string())?;
    }
    for row in health {
        output::line(format!(
            "health: {} since {}: {}",
            row.subject,
            local_time(&row.since, false),
            row.reason
        ))?;
    }
    Ok(DONE)
}

fn show(args: &AlarmsArgs, id: i64, settings: &Settings) -> CommandResult {
    let store = Store::open_for_reading(&settings.store.dir)?;
    let alarm = store.alarm(id)?;
    let floor_m = floor_m(&store, &alarm)?;
    if args.json {
        output::json(&alarm_json_for_guard(&alarm, settings, floor_m))?;
    } else {
        output::line(alarm_text(&alarm, settings, floor_m))?;
    }
    Ok(DONE)
}

/// Height of the floor in the frame of an alarm; `None` where its reference shows none.
fn floor_m(store: &Store, alarm: &AlarmRow) -> Result<Option<f64>, Failure> {
    let last = alarm.last_sighting.as_ref();
    let visit_id = last.map_or(alarm.visit_id, |last| last.visit_id);
    let reference = store.reference_of_visit(visit_id)?;
    Ok(reference.and_then(|gamma| floor_height_m(&gamma.mixture)))
}

/// The user of this process, and in front of it the name that was given.
fn user(given: Option<&str>) -> String {
    operator(given, rustix::process::getuid().as_raw())
}

/// Through the service, which sees who asks; where none runs, in the database.
fn acknowledge(args: &AlarmsArgs, ack: &AckArgs, settings: &Settings) -> CommandResult {
    let answer = match (ack.confirmed, ack.false_alarm) {
        (true, _) => Some(AlarmAnswer::Confirmed),
        (false, true) => Some(AlarmAnswer::FalseAlarm),
        (false, false) => None,
    };
    let body = json!({
        "id": ack.id,
        "by": ack.by,
        "note": ack.note,
        "answer": answer.map(AlarmAnswer::as_str),
    });
    let (store, alarm, by) = match client::request_ack(&settings.api.socket, body)? {
        Some(reply) => {
            let store = Store::open_for_reading(&settings.store.dir)?;
            let alarm = store.alarm(reply.alarm)?;
            (store, alarm, reply.by)
        }
        None => {
            let mut store = Store::open_existing(&settings.store.dir)?;
            let by = user(ack.by.as_deref());
            let (note, now) = (ack.note.as_deref(), record_time_now());
            let alarm = store.acknowledge_and_answer(ack.id, &by, note, answer, &now)?;
            (store, alarm, by)
        }
    };
    if args.json {
        let floor_m = floor_m(&store, &alarm)?;
        output::json(&alarm_json_for_guard(&alarm, settings, floor_m))?;
    } else {
        let said = answer.map_or_else(String::new, |answer| format!(", {answer}"));
        output::line(format!(
            "alarm {}: acknowledgement by {by} stored{said}; state {}",
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
    let filter = export.filters.or(&args.filters).filter(settings)?;
    let store = Store::open_for_reading(&settings.store.dir)?;
    let csv = export.format == Some(ExportFormat::Csv);
    let mut out = files::LineWriter::create(export.out.as_deref())?;
    if csv {
        out.line(CSV_HEADER)?;
    }
    export_pages(&store, filter, &mut |alarm| {
        if csv {
            alarm_csv(alarm, settings)
                .iter()
                .try_for_each(|line| out.line(line))
        } else {
            out.line(&output::json_text(&alarm_json(alarm, settings))?)
        }
    })?;
    out.finish()?;
    Ok(DONE)
}

/// Reads the log page by page: what it holds in memory does not grow with the log.
fn export_pages(
    store: &Store,
    mut filter: AlarmFilter,
    write: &mut dyn FnMut(&AlarmRow) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let mut left = filter.limit.unwrap_or(u32::MAX);
    while left > 0 {
        filter.limit = Some(left.min(PAGE));
        let page = store.alarms(&filter)?;
        page.iter().try_for_each(&mut *write)?;
        left -= page.len() as u32;
        match page.last() {
            Some(last) if page.len() == PAGE as usize => filter.before = Some(last.id),
            _ => break,
        }
    }
    Ok(())
}
