//! `patrold rejudge VISIT`: the verdict on a stored sweep with the current settings.

use super::alarm_report::novelty_text;
use super::failure::{CommandResult, Failure, NOT_OBSERVED, verdict_exit_code};
use super::{config, mixtures_out, output};
use crate::config::Settings;
use crate::store::{ReferenceError, Store, StoredReference, StoredVisit};
use clap::Args;
use patrold_engine::geometry::View;
use patrold_engine::inspect::inspect;
use patrold_engine::novelty::{ComparedMixtures, Verdict};
use patrold_engine::report::NoveltyRecord;
use patrold_engine::sweep::{SweepQuality, assemble, decode_raw_sweep};
use serde::Serialize;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(super) struct RejudgeArgs {
    /// Number of the visit, as `visit` and `alarms` report it
    visit_id: i64,
    /// Use the U_th that was in force at the visit
    #[arg(long)]
    stored_u_th: bool,
    /// Write both mixtures as compared to DIR/gamma.json and DIR/theta.json
    #[arg(long, value_name = "DIR")]
    mixtures_out: Option<PathBuf>,
    /// Configuration file
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Report as JSON
    #[arg(long)]
    json: bool,
}

/// The verdict in the log.
#[derive(Debug, Serialize)]
struct StoredVerdict {
    verdict: String,
    d_gmm: Option<f64>,
    u_th: Option<f64>,
}

/// The verdict with the current settings.
#[derive(Debug, Serialize)]
struct NewVerdict {
    verdict: &'static str,
    reason: String,
    d_gmm: Option<f64>,
    u_th: f64,
    engine: &'static str,
    novelties: Vec<NoveltyRecord>,
    #[serde(skip)]
    exit_code: u8,
    /// Why the stored mixture of the reference was not used.
    #[serde(skip)]
    made_anew: Option<String>,
    /// `None` where nothing was compared.
    #[serde(skip)]
    compared: Option<ComparedMixtures>,
}

#[derive(Debug, Serialize)]
struct RejudgeReport<'a> {
    visit_id: i64,
    waypoint: &'a str,
    frame: String,
    seed: u64,
    /// Why the mixture of the reference was made anew; null where the stored one was used.
    reference_made_anew: Option<String>,
    stored: StoredVerdict,
    judged: NewVerdict,
}

/// Writes nothing to the store.
pub(super) fn run(args: &RejudgeArgs) -> CommandResult {
    let mut settings = config::load_settings(args.config.as_deref())?;
    let store = Store::open_for_reading(&settings.store.dir)?;
    let visit = store.visit(args.visit_id)?;
    let id = visit.reference_id.ok_or_else(|| {
        let text = format!("visit {}: it was compared with no reference", args.visit_id);
        Failure::Failed(text)
    })?;
    let reference = store.reference_by_id(id)?;
    if args.stored_u_th {
        let u_th = visit.u_th.ok_or_else(|| {
            Failure::Failed(format!(
                "visit {}: its threshold is not in the store",
                args.visit_id
            ))
        })?;
        settings.set_u_th(&visit.waypoint, u_th);
    }
    let mut judged = judge(&visit, &reference, &settings)?;
    if let (Some(dir), Some(compared)) = (&args.mixtures_out, &judged.compared) {
        mixtures_out::write(dir, compared)?;
    }
    let report = RejudgeReport {
        visit_id: args.visit_id,
        waypoint: &visit.waypoint,
        frame: reference.frame(&visit.waypoint),
        seed: visit.seed,
        reference_made_anew: judged.made_anew.take(),
        stored: StoredVerdict {
            verdict: visit.verdict.clone(),
            d_gmm: visit.d_gmm,
            u_th: visit.u_th,
        },
        judged,
    };
    if args.json {
        output::json(&report)?;
    } else {
        output::line(report_text(&report))?;
    }
    Ok(report.judged.exit_code)
}

/// Judges the stored sweep as the service judges a new one.
fn judge(
    visit: &StoredVisit,
    reference: &StoredReference,
    settings: &Settings,
) -> Result<NewVerdict, Failure> {
    let not_observed = |reason: String| NewVerdict {
        verdict: Verdict::NotObserved.as_str(),
        reason,
        d_gmm: None,
        u_th: settings.u_th(Some(&visit.waypoint)),
        engine: settings.novelty.engine.as_str(),
        novelties: Vec::new(),
        exit_code: NOT_OBSERVED,
        made_anew: None,
        compared: None,
    };
    let (view, quality) = match load_view(visit)? {
        Ok(loaded) => loaded,
        Err(reason) => return Ok(not_observed(reason)),
    };
    let fault = quality.and_then(|q| q.fault(settings.sweep.max_missing_lines));
    if let Some(reason) = fault {
        return Ok(not_observed(reason));
    }
    let engine = settings.engine_settings(Some(&visit.waypoint));
    let ready = match reference.make_ready(&visit.waypoint, &engine, visit.seed) {
        Ok(ready) => ready,
        Err(error @ ReferenceError::Damaged { .. }) => return Ok(not_observed(error.to_string())),
        Err(error) => return Err(Failure::failed(error)),
    };
    let made_anew = ready.made_anew.map(|made| made.why);
    let inspection = match inspect(&ready.reference, &view, &engine, visit.seed, &mut |_| ()) {
        Ok(inspection) => inspection,
        Err(error) => {
            return Ok(NewVerdict {
                made_anew,
                ..not_observed(error.to_string())
            });
        }
    };
    let detection = &inspection.detection;
    let reference_from_current = detection.registration.current_from_reference.inverse();
    let novelties = detection
        .novelties
        .iter()
        .zip(&inspection.retrievals)
        .map(|(n, r)| NoveltyRecord::new_in_frame(n, r.as_ref(), &reference_from_current))
        .collect();
    Ok(NewVerdict {
        verdict: detection.verdict.as_str(),
        reason: detection.reason.clone(),
        d_gmm: Some(detection.d_gmm),
        u_th: detection.u_th,
        engine: settings.novelty.engine.as_str(),
        novelties,
        exit_code: verdict_exit_code(detection.verdict),
        made_anew,
        compared: Some(inspection.detection.compared),
    })
}

/// The stored view with its quality, or where there is none, the raw sweep assembled again; a reason where that fails.
fn load_view(visit: &StoredVisit) -> Result<Result<(View, Option<SweepQuality>), String>, Failure> {
    if let Some(view) = &visit.view {
        let quality = match visit.quality.as_str() {
            "" | "{}" | "null" => None,
            text => Some(
                serde_json::from_str(text)
                    .map_err(|error| Failure::Failed(format!("stored sweep quality: {error}")))?,
            ),
        };
        return Ok(Ok((view.clone(), quality)));
    }
    let raw = visit.raw.as_deref().unwrap_or_default();
    let raw = decode_raw_sweep(raw)
        .map_err(|error| Failure::Failed(format!("stored raw sweep: {error}")))?;
    Ok(assemble(&raw)
        .map(|sweep| (sweep.view, Some(sweep.quality)))
        .map_err(|error| error.to_string()))
}

fn report_text(report: &RejudgeReport<'_>) -> String {
    let number = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), |x| format!("{x:.6}"));
    let (stored, judged) = (&report.stored, &report.judged);
    let mut lines = vec![
        format!(
            "visit {} at {}, positions in the frame of reference {}",
            report.visit_id, report.waypoint, report.frame
        ),
        format!(
            "  stored: {}, d_GMM {}, U_th {}",
            stored.verdict,
            number(stored.d_gmm),
            number(stored.u_th)
        ),
        format!(
            "  now:    {}, d_GMM {}, U_th {}: {}",
            judged.verdict,
            number(judged.d_gmm),
            number(Some(judged.u_th)),
            judged.reason
        ),
    ];
    if let Some(why) = &report.reference_made_anew {
        lines.push(format!(
            "  the mixture of the reference was made anew from its view: {why}"
        ));
    }
    let novelties = judged.novelties.iter();
    lines.extend(novelties.map(|n| format!("  {}, {} points", novelty_text(n), n.points)));
    lines.join("\n")
}
