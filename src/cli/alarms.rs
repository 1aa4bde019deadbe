//! `patrold alarms list|show|ack|export`: the alarm log, read from the database whether or not the service runs.

use super::failure::{DONE, Failure, Outcome};
use super::{config, files, output, table, when};
use crate::alarm::State;
use crate::service::stamp_now;
use crate::store::{AlarmFilter, AlarmRow, Store};
use clap::{Args, Subcommand, ValueEnum};
use jiff::Timestamp;
use serde_json::json;
use std::path::PathBuf;

/// Arguments of `alarms`.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true)]
pub struct AlarmsArgs {
    #[command(subcommand)]
    action: Option<Action>,
    #[command(flatten)]
    list: ListArgs,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// List alarms, newest first
    List(ListArgs),
    /// Show one alarm with everything known about it
    Show(ShowArgs),
    /// Acknowledge an alarm
    Ack(AckArgs),
    /// Write alarms as JSON lines or CSV
    Export(ExportArgs),
}

#[derive(Debug, Args)]
struct Common {
    /// Configuration file
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Report as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Args)]
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
struct ListArgs {
    #[command(flatten)]
    filters: Filters,
    #[command(flatten)]
    common: Common,
}

#[derive(Debug, Args)]
struct ShowArgs {
    /// The alarm's number
    id: i64,
    #[command(flatten)]
    common: Common,
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
    #[command(flatten)]
    common: Common,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
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
    /// How to write them
    #[arg(long, value_enum, default_value = "jsonl")]
    format: Format,
    /// Where to [default: standard output]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Configuration file
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// JSON lines, the default format
    #[arg(long, conflicts_with = "format")]
    json: bool,
}

/// Runs `alarms`.
pub fn run(args: &AlarmsArgs) -> Outcome {
    match &args.action {
        None => list(&args.list),
        Some(Action::List(list_args)) => list(list_args),
        Some(Action::Show(show_args)) => show(show_args),
        Some(Action::Ack(ack_args)) => acknowledge(ack_args),
        Some(Action::Export(export_args)) => export(export_args),
    }
}

fn reader(file: Option<&PathBuf>) -> Result<Store, Failure> {
    let settings = config::settings(file.map(PathBuf::as_path))?;
    Ok(Store::open_for_reading(&settings.store.dir)?)
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
}

fn list(args: &ListArgs) -> Outcome {
    let alarms = reader(args.common.config.as_ref())?.alarms(&args.filters.filter())?;
    if args.common.json {
        output::json(&json!({"alarms": alarms}))?;
    } else if alarms.is_empty() {
        output::line("no alarms")?;
    } else {
        output::line(alarm_table(&alarms))?;
    }
    Ok(DONE)
}

/// The log as people read it: one line per alarm, one sentence per thing.
pub fn alarm_table(alarms: &[AlarmRow]) -> String {
    let mut rows = table::table(&[
        "id",
        "raised",
        "waypoint",
        "state",
        "d_gmm (m)",
        "what, where (m), shape",
    ]);
    for alarm in alarms {
        let things: Vec<String> = alarm.novelties.iter().map(describe).collect();
        rows.add_row([
            alarm.id.to_string(),
            alarm.raised_at.clone(),
            alarm.waypoint.clone(),
            alarm.state.clone(),
            format!("{:.4}", alarm.d_gmm),
            things.join("\n"),
        ]);
    }
    rows.to_string()
}

/// One thing that came or went, in one sentence.
pub fn describe(novelty: &crate::patrol::NoveltyRecord) -> String {
    let moved = if novelty.moved_from.is_some() {
        " (moved)"
    } else {
        ""
    };
    let shape = match &novelty.shape {
        Some(shape) => {
            let [a, b, c] = shape.size;
            format!("{} {a:.2} x {b:.2} x {c:.2}", shape.class)
        }
        None => "too few points for a shape".to_owned(),
    };
    format!(
        "{}{moved} at {}: {shape}",
        novelty.kind,
        table::place(novelty.centre)
    )
}

fn show(args: &ShowArgs) -> Outcome {
    let alarm = reader(args.common.config.as_ref())?.alarm(args.id)?;
    if args.common.json {
        output::json(&alarm)?;
    } else {
        output::line(details(&alarm))?;
    }
    Ok(DONE)
}

fn details(alarm: &AlarmRow) -> String {
    let mut lines = vec![
        format!("alarm {} at {}: {}", alarm.id, alarm.waypoint, alarm.state),
        format!(
            "  raised {}, last seen {}, {} visit(s)",
            alarm.raised_at, alarm.last_seen_at, alarm.visits
        ),
        format!(
            "  d_GMM {:.6} m, U_th {:.6} m: {}",
            alarm.d_gmm, alarm.u_th, alarm.reason
        ),
        format!("  positions in the frame of reference {}", alarm.frame),
    ];
    for (at, by) in alarm.acknowledged_at.iter().zip(&alarm.acknowledged_by) {
        lines.push(format!("  acknowledged {at} by {by}"));
    }
    if let Some(note) = &alarm.note {
        lines.push(format!("  note: {note}"));
    }
    for (at, because) in alarm.cleared_at.iter().zip(&alarm.cleared_because) {
        lines.push(format!("  cleared {at}: {because}"));
    }
    for novelty in &alarm.novelties {
        lines.push(format!(
            "  {}, {} points",
            describe(novelty),
            novelty.points
        ));
    }
    lines.join("\n")
}

fn acknowledge(args: &AckArgs) -> Outcome {
    let settings = config::settings(args.common.config.as_deref())?;
    let mut store = Store::open_existing(&settings.store.dir)?;
    let login = || std::env::var("USER").unwrap_or_else(|_| "unknown".to_owned());
    let by = args.by.clone().unwrap_or_else(login);
    let alarm = store.acknowledge(args.id, &by, args.note.as_deref(), &stamp_now())?;
    if args.common.json {
        output::json(&alarm)?;
    } else {
        output::line(format!(
            "alarm {} is {}, noted for {by}",
            alarm.id, alarm.state
        ))?;
    }
    Ok(DONE)
}

fn export(args: &ExportArgs) -> Outcome {
    let alarms = reader(args.config.as_ref())?.alarms(&args.filters.filter())?;
    let text = match args.format {
        Format::Jsonl => json_lines(&alarms)?,
        Format::Csv => csv(&alarms),
    };
    match &args.out {
        None if text.is_empty() => {}
        None => output::line(text.trim_end_matches('\n'))?,
        Some(path) => files::write(path, text.as_bytes())?,
    }
    Ok(DONE)
}

fn json_lines(alarms: &[AlarmRow]) -> Result<String, Failure> {
    let line = |alarm| serde_json::to_string(alarm).map(|line| line + "\n");
    let lines: Result<String, _> = alarms.iter().map(line).collect();
    lines.map_err(Failure::failed)
}

fn csv(alarms: &[AlarmRow]) -> String {
    let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
    let mut text = "id,waypoint,state,raised_at,last_seen_at,d_gmm,u_th,kind,x_m,y_m,z_m,class,\
                    size_x_m,size_y_m,size_z_m,note\n"
        .to_owned();
    for alarm in alarms {
        for n in &alarm.novelties {
            let (class, size) = match &n.shape {
                Some(shape) => (shape.class.as_str(), shape.size.map(|s| s.to_string())),
                None => ("", [const { String::new() }; 3]),
            };
            let [x, y, z] = n.centre;
            text.push_str(&format!(
                "{},{},{},{},{},{},{},{},{x},{y},{z},{class},{},{}\n",
                alarm.id,
                quoted(&alarm.waypoint),
                alarm.state,
                alarm.raised_at,
                alarm.last_seen_at,
                alarm.d_gmm,
                alarm.u_th,
                n.kind,
                size.join(","),
                quoted(alarm.note.as_deref().unwrap_or("")),
            ));
        }
    }
    text
}
