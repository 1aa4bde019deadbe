//! `patrold events`: the log of devices, configuration and the service itself.

use super::failure::{CommandResult, DONE};
use super::filter_args::RangeArgs;
use super::local_time::local_time;
use super::{config, output, table};
use crate::patrol::severity::Severity;
use crate::store::{EventFilter, Store};
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use serde_json::json;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(super) struct EventsArgs {
    #[command(flatten)]
    range: RangeArgs,
    /// Only events of this level
    #[arg(long, value_parser = severity())]
    level: Option<Severity>,
    /// Only events of this device: laser, ptu, devices or service
    #[arg(long, value_name = "NAME")]
    device: Option<String>,
    /// Only the newest N events
    #[arg(long, value_name = "N", default_value_t = 100)]
    limit: u32,
    /// Configuration file
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Report as JSON
    #[arg(long)]
    json: bool,
}

fn severity() -> impl TypedValueParser<Value = Severity> {
    let all = [Severity::Info, Severity::Warning, Severity::Error];
    PossibleValuesParser::new(all.map(Severity::as_str)).map(move |name| {
        let found = all.into_iter().find(|severity| severity.as_str() == name);
        found.unwrap_or(Severity::Error)
    })
}

pub(super) fn run(args: &EventsArgs) -> CommandResult {
    let settings = config::load_for_reading(args.config.as_deref())?;
    let filter = EventFilter {
        range: args.range.range(),
        severity: args.level,
        device: args.device.clone(),
        limit: args.limit,
    };
    let events = Store::open_for_reading(&settings.store.dir)?.events(filter)?;
    if args.json {
        output::json(&json!({"events": events}))?;
        return Ok(DONE);
    }
    if events.is_empty() {
        output::line("no events")?;
        return Ok(DONE);
    }
    let mut rows = table::table(&["id", "at", "level", "device", "event"]);
    for event in &events {
        rows.add_row([
            event.id.to_string(),
            local_time(&event.at, event.clock_unset),
            event.level.clone(),
            event.device.clone(),
            event.text.clone(),
        ]);
    }
    output::line(rows.to_string())?;
    Ok(DONE)
}
