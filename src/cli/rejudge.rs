//! `patrold rejudge VISIT`: what a stored sweep would be said to show under the settings in force now.

use super::alarm_report::describe;
use super::failure::{Failure, NOT_OBSERVED, Outcome, verdict_code};
use super::{config, output};
use crate::config::Settings;
use crate::store::{Store, StoredReference, StoredVisit};
use clap::Args;
use patrold_engine::geometry::View;
use patrold_engine::inspect::{inspect, prepare};
use patrold_engine::novelty::Verdict;
use patrold_engine::report::NoveltyRecord;
use patrold_engine::sweep::{Quality, assemble, decode};
use serde::Serialize;
use std::path::PathBuf;

/// Arguments of `rejudge`.
#[derive(Debug, Args)]
pub struct RejudgeArgs {
    /// Number of the visit, as `visit` and `alarms` tell it
    visit_id: i64,
    /// Judge by the threshold that was in force at the visit
    #[arg(long)]
    stored_u_th: bool,
    /// Configuration file
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Report as JSON
    #[arg(long)]
    json: bool,
}

/// The judgement in the log.
#[derive(Debug, Serialize)]
struct Stored {
    verdict: String,
    d_gmm: Option<f64>,
    u_th: Option<f64>,
}

/// The judgement of now.
#[derive(Debug, Serialize)]
struct Judged {
    verdict: &'static str,
    reason: String,
    d_gmm: Option<f64>,
    u_th: f64,
    engine: &'static str,
    novelties: Vec<NoveltyRecord>,
    #[serde(skip)]
    code: u8,
}

#[derive(Debug, Serialize)]
struct Rejudged<'a> {
    visit_id: i64,
    waypoint: &'a str,
    frame: String,
    seed: u64,
    stored: Stored,
    judged: Judged,
}

/// Runs `rejudge`; it writes nothing.
pub fn run(args: &RejudgeArgs) -> Outcome {
    let mut settings = config::settings(args.config.as_deref())?;
    let store = Store::open_for_reading(&settings.store.dir)?;
    let visit = store.visit(args.visit_id)?;
    let id = visit.reference_id.ok_or_else(|| {
        let told = format!("visit {}: it was compared with no reference", args.visit_id);
        Failure::Failed(told)
    })?;
    let reference = store.reference_by_id(id)?;
    if args.stored_u_th {
        let u_th = visit.u_th.ok_or_else(|| {
            Failure::Failed(format!(
                "visit {}: its threshold is not on record",
                args.visit_id
            ))
        })?;
        settings.set_u_th(&visit.waypoint, u_th);
    }
    let judged = judge(&visit, &reference, &settings)?;
    let told = Rejudged {
        visit_id: args.visit_id,
        waypoint: &visit.waypoint,
        frame: format!("{}/{}", visit.waypoint, reference.version),
        seed: visit.seed,
        stored: Stored {
            verdict: visit.verdict.clone(),
            d_gmm: visit.d_gmm,
            u_th: visit.u_th,
        },
        judged,
    };
    if args.json {
        output::json(&told)?;
    } else {
        output::line(prose(&told))?;
    }
    Ok(told.judged.code)
}

/// Judges the stored sweep as the service judges a fresh one.
fn judge(
    visit: &StoredVisit,
    reference: &StoredReference,
    settings: &Settings,
) -> Result<Judged, Failure> {
    let not_observed = |reason: String| Judged {
        verdict: Verdict::NotObserved.word(),
        reason,
        d_gmm: None,
        u_th: settings.u_th(Some(&visit.waypoint)),
        engine: settings.novelty.engine.word(),
        novelties: Vec::new(),
        code: NOT_OBSERVED,
    };
    let (view, quality) = match seen(visit)? {
        Ok(seen) => seen,
        Err(reason) => return Ok(not_observed(reason)),
    };
    let fault = quality.and_then(|q| q.fault(settings.sweep.max_missing_lines));
    if let Some(reason) = fault {
        return Ok(not_observed(reason));
    }
    let engine = settings.engine(Some(&visit.waypoint));
    let prepared = prepare(&reference.view, &engine, visit.seed)
        .map_err(|error| Failure::Failed(format!("reference {}: {error}", reference.version)))?;
    let inspection = match inspect(&prepared, &view, &engine, visit.seed, &mut |_| ()) {
        Ok(inspection) => inspection,
        Err(error) => return Ok(not_observed(error.to_string())),
    };
    let detection = &inspection.detection;
    let reference_from_current = detection.registration.current_from_reference.inverse();
    let novelties = detection
        .novelties
        .iter()
        .zip(&inspection.retrievals)
        .map(|(n, r)| NoveltyRecord::new_in(n, r.as_ref(), &reference_from_current))
        .collect();
    Ok(Judged {
        verdict: detection.verdict.word(),
        reason: detection.reason.clone(),
        d_gmm: Some(detection.d_gmm),
        u_th: detection.u_th,
        engine: settings.novelty.engine.word(),
        novelties,
        code: verdict_code(detection.verdict),
    })
}

/// What the visit saw and how well, from its points, or from its raw data where those gave none; or why there are
/// none now either.
fn seen(visit: &StoredVisit) -> Result<Result<(View, Option<Quality>), String>, Failure> {
    if let Some(view) = &visit.view {
        let quality = match visit.quality.as_str() {
            "" | "{}" | "null" => None,
            text => Some(
                serde_json::from_str(text)
                    .map_err(|error| Failure::Failed(format!("stored quality figures: {error}")))?,
            ),
        };
        return Ok(Ok((view.clone(), quality)));
    }
    let raw = visit.raw.as_deref().unwrap_or_default();
    let raw = decode(raw).map_err(|error| Failure::Failed(format!("stored raw data: {error}")))?;
    Ok(assemble(&raw)
        .map(|sweep| (sweep.view, Some(sweep.quality)))
        .map_err(|error| error.to_string()))
}

fn prose(told: &Rejudged<'_>) -> String {
    let figure = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), |x| format!("{x:.6}"));
    let (stored, judged) = (&told.stored, &told.judged);
    let mut lines = vec![
        format!(
            "visit {} at {}, positions in {}",
            told.visit_id, told.waypoint, told.frame
        ),
        format!(
            "  stored: {}, d_GMM {}, U_th {}",
            stored.verdict,
            figure(stored.d_gmm),
            figure(stored.u_th)
        ),
        format!(
            "  now:    {}, d_GMM {}, U_th {}: {}",
            judged.verdict,
            figure(judged.d_gmm),
            figure(Some(judged.u_th)),
            judged.reason
        ),
    ];
    let things = judged.novelties.iter();
    lines.extend(things.map(|n| format!("  {}, {} points", describe(n), n.points)));
    lines.join("\n")
}
