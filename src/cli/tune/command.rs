//! Arguments, and the study of each waypoint.

use super::apply::apply;
use super::picture::histogram_svg;
use super::report::{Example, Suggestion, WaypointStudy, tune_text};
use crate::alarm::ThresholdStudy;
use crate::cli::alarm_report::novelty_text;
use crate::cli::failure::{CommandResult, DONE, Failure};
use crate::cli::filter_args::RangeArgs;
use crate::cli::threshold_warning::never_alarms_text;
use crate::cli::value_parsers::parse_waypoint_name;
use crate::cli::{config, files, output};
use crate::config::{Settings, ground_name};
use crate::store::Store;
use clap::Args;
use serde_json::json;
use std::path::PathBuf;

/// Candidates of every power of ten.
const CANDIDATES: [f64; 3] = [1.0, 2.0, 5.0];
/// Powers of ten of the candidates, in the unit of the distances.
const CANDIDATE_DECADES: std::ops::Range<i32> = -6..2;

#[derive(Debug, Args)]
pub(crate) struct TuneArgs {
    #[command(flatten)]
    range: RangeArgs,
    /// Only this waypoint
    #[arg(long, value_name = "NAME", value_parser = parse_waypoint_name)]
    waypoint: Option<String>,
    /// Wanted share of visits to an unchanged place that alarm
    #[arg(long, value_name = "RATE", default_value_t = 0.01, value_parser = parse_rate)]
    false_alarm_rate: f64,
    /// Another threshold to try, in the unit of the distances
    #[arg(long, value_name = "U", value_parser = parse_threshold)]
    u_th: Option<f64>,
    /// Put this threshold into force at --waypoint: writes a file into patrold.d and reloads
    #[arg(long, value_name = "U", requires = "waypoint", conflicts_with = "u_th", value_parser = parse_threshold)]
    apply: Option<f64>,
    /// Write the histogram of --waypoint as a picture
    #[arg(long, value_name = "FILE", requires = "waypoint")]
    svg: Option<PathBuf>,
    /// Configuration file
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Report as JSON
    #[arg(long)]
    json: bool,
}

fn parse_rate(text: &str) -> Result<f64, String> {
    let rate = text
        .parse::<f64>()
        .ok()
        .filter(|rate| (0.0..1.0).contains(rate));
    rate.ok_or_else(|| format!("expected a share from 0 to below 1, got {text:?}"))
}

fn parse_threshold(text: &str) -> Result<f64, String> {
    // The range of the key.
    let u_th = text
        .parse::<f64>()
        .ok()
        .filter(|u| (1e-9..=1000.0).contains(u));
    u_th.ok_or_else(|| format!("expected a threshold from 1e-9 to 1000, got {text:?}"))
}

pub(crate) fn run(args: &TuneArgs) -> CommandResult {
    let settings = config::load_settings(args.config.as_deref())?;
    let store = Store::open_for_reading(&settings.store.dir)?;
    let names: Vec<String> = match &args.waypoint {
        Some(name) => vec![name.clone()],
        None => store.waypoints()?.into_iter().map(|row| row.name).collect(),
    };
    let mut studies = Vec::new();
    for name in &names {
        let (study, report) = study_waypoint(args, &settings, &store, name)?;
        if let Some(path) = &args.svg {
            files::write(path, histogram_svg(name, &study, report.u_th).as_bytes())?;
        }
        studies.push(report);
    }
    let applied = match (args.apply, &args.waypoint) {
        (Some(u_th), Some(waypoint)) => {
            Some(apply(args.config.as_deref(), &settings, waypoint, u_th)?)
        }
        _ => None,
    };
    if args.json {
        output::json(&json!({"waypoints": studies, "applied": applied}))?;
        return Ok(DONE);
    }
    if studies.is_empty() {
        output::line("no waypoints yet; take a reference: patrold teach NAME")?;
    }
    for study in &studies {
        output::line(tune_text(study))?;
    }
    if let Some(applied) = &applied {
        output::line(applied.text())?;
    }
    Ok(DONE)
}

fn study_waypoint(
    args: &TuneArgs,
    settings: &Settings,
    store: &Store,
    waypoint: &str,
) -> Result<(ThresholdStudy, WaypointStudy), Failure> {
    let u_th = settings.u_th(Some(waypoint));
    let ground = ground_name(settings.novelty.ground);
    let asked = args.apply.or(args.u_th);
    let range = args.range.range();
    let study_of = |thresholds: Vec<f64>| -> Result<ThresholdStudy, Failure> {
        let mut study = ThresholdStudy::new(thresholds);
        store.each_past_distance(waypoint, &range, ground, &mut |past| study.add(past))?;
        Ok(study)
    };
    let candidates =
        CANDIDATE_DECADES.flat_map(|decade| CANDIDATES.map(|digit| digit * 10f64.powi(decade)));
    let asked_for = [u_th].into_iter().chain(asked);
    let mut study = study_of(candidates.chain(asked_for.clone()).collect())?;
    let suggested = study.threshold_for(args.false_alarm_rate);
    if let Some(suggested) = suggested {
        // Its effect is counted in a second walk: the first one finds it.
        let known = study.effects().iter().map(|effect| effect.u_th);
        study = study_of(known.chain([suggested]).collect())?;
    }
    // Examples are shown for one threshold: the one asked for, else the suggested one.
    let looked_at = asked.or(suggested);
    let effect = study
        .effects()
        .iter()
        .find(|effect| Some(effect.u_th) == looked_at);
    let mut report = WaypointStudy::new(waypoint, ground, u_th, &study);
    report.suggestion = Suggestion {
        false_alarm_rate: args.false_alarm_rate,
        u_th: suggested,
    };
    report.looked_at = looked_at;
    for id in effect.iter().flat_map(|effect| &effect.gone_ids) {
        let alarm = store.alarm(*id)?;
        report.gone.push(Example {
            id: *id,
            at: alarm.raised_at,
            things: alarm.novelties.iter().map(novelty_text).collect(),
        });
    }
    for id in effect.iter().flat_map(|effect| &effect.alarming_ids) {
        let visit = store.visit_detail(*id)?;
        report.alarming.push(Example {
            id: *id,
            at: visit.row.at,
            things: visit.novelties.iter().map(novelty_text).collect(),
        });
    }
    if effect.is_some_and(|effect| effect.never_alarms()) && asked.is_some() {
        report.warnings.push(never_alarms_text(
            waypoint,
            asked.unwrap_or(u_th),
            study.alarms().all,
        ));
    }
    Ok((study, report))
}
