//! The verdict on a stored sweep with other settings.

use super::source::{SweepSource, load_sweep};
use crate::cli::failure::{Failure, NOT_OBSERVED, verdict_exit_code};
use crate::config::Settings;
use crate::store::{ReadyReference, ReferenceError, StoredReference, StoredVisit};
use patrold_engine::inspect::inspect;
use patrold_engine::novelty::{ComparedMixtures, Verdict};
use patrold_engine::report::NoveltyRecord;
use serde::Serialize;

/// The verdict with the current settings.
#[derive(Debug, Serialize)]
pub(super) struct NewVerdict {
    pub(super) verdict: &'static str,
    pub(super) reason: String,
    pub(super) d_gmm: Option<f64>,
    pub(super) u_th: f64,
    pub(super) engine: &'static str,
    pub(super) novelties: Vec<NoveltyRecord>,
    #[serde(skip)]
    pub(super) exit_code: u8,
    /// What it began from.
    #[serde(skip)]
    pub(super) source: SweepSource,
    /// Why the stored mixture of the reference was not used.
    #[serde(skip)]
    pub(super) made_anew: Option<String>,
    /// `None` where nothing was compared.
    #[serde(skip)]
    pub(super) compared: Option<ComparedMixtures>,
}

/// The reference of a visit under `settings`; the reason where it cannot be compared with.
pub(super) type PreparedReference = Result<ReadyReference, String>;

/// # Errors
/// A reference that the engine cannot use at all.
pub(super) fn prepare(
    visit: &StoredVisit,
    reference: &StoredReference,
    settings: &Settings,
) -> Result<PreparedReference, Failure> {
    let engine = settings.engine_settings(Some(&visit.waypoint));
    match reference.make_ready(&visit.waypoint, &engine, visit.seed) {
        Ok(ready) => Ok(Ok(ready)),
        Err(error @ ReferenceError::Damaged { .. }) => Ok(Err(error.to_string())),
        Err(error) => Err(Failure::failed(error)),
    }
}

/// Judges the stored sweep as the service judges a new one.
///
/// # Errors
/// A stored sweep that cannot be read.
pub(super) fn judge(
    visit: &StoredVisit,
    reference: &PreparedReference,
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
        source: SweepSource::default(),
        made_anew: None,
        compared: None,
    };
    let loaded = load_sweep(visit)?;
    let source = loaded.source;
    let not_observed = |reason| NewVerdict {
        source: source.clone(),
        ..not_observed(reason)
    };
    let (view, quality) = match loaded.sweep {
        Ok(loaded) => loaded,
        Err(reason) => return Ok(not_observed(reason)),
    };
    let fault = quality.and_then(|q| q.fault(settings.sweep.max_missing_lines));
    if let Some(reason) = fault {
        return Ok(not_observed(reason));
    }
    let engine = settings.engine_settings(Some(&visit.waypoint));
    let ready = match reference {
        Ok(ready) => ready,
        Err(reason) => return Ok(not_observed(reason.clone())),
    };
    let made_anew = ready.made_anew.as_ref().map(|made| made.why.clone());
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
        source,
        made_anew,
        compared: Some(inspection.detection.compared),
    })
}
