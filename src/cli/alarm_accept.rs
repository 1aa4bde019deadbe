//! `patrold alarms accept ID...`: what the last visit saw of these alarms becomes normal, as a new version of the reference.

use super::failure::{CommandResult, DONE, Failure};
use super::output;
use crate::config::Settings;
use crate::patrol::severity::Severity;
use crate::service::record_time_now;
use crate::store::{
    AlarmRow, LastSighting, NewReference, ReferenceFrame, Store, StoreError, StoredReference,
    SweepRecord,
};
use nalgebra::Point3;
use patrold_engine::inspect::prepare;
use patrold_engine::novelty::{Detection, accept_novelties, detect};
use patrold_engine::report::NoveltyRecord;
use serde::Serialize;

/// A novelty found again in the stored sweep is within this of the recorded one, metres: the same data gives the same place,
/// another fit of the reference nearly so.
const MAX_OFF_M: f64 = 0.1;

#[derive(Debug, Serialize)]
struct AcceptReport {
    alarm: i64,
    waypoint: String,
    /// The new version of its reference.
    version: i64,
}

pub(super) fn run(settings: &Settings, ids: &[i64], by: &str, as_json: bool) -> CommandResult {
    let mut store = Store::open_existing(&settings.store.dir)?;
    let mut accepted = Vec::new();
    for id in ids {
        let report = accept(&mut store, settings, *id, by)?;
        if !as_json {
            output::line(format!(
                "alarm {id}: normal from reference {}/{} on",
                report.waypoint, report.version
            ))?;
        }
        accepted.push(report);
    }
    if as_json {
        output::json(&serde_json::json!({"accepted": accepted}))?;
    }
    Ok(DONE)
}

fn accept(
    store: &mut Store,
    settings: &Settings,
    id: i64,
    by: &str,
) -> Result<AcceptReport, Failure> {
    let alarm = store.alarm(id)?;
    let waypoint = alarm.waypoint.clone();
    let stored = store.reference(&waypoint)?;
    let last = last_sighting(&alarm, &stored)?;
    let visit = store.visit(last.visit_id)?;
    let current = visit.view.ok_or_else(|| {
        refused(
            id,
            "its sweep gave no points; visit the waypoint again".to_owned(),
        )
    })?;
    let (engine, seed) = (
        settings.engine_settings(Some(&waypoint)),
        settings.mixture.seed,
    );
    let ready = stored
        .make_ready(&waypoint, &engine, seed)
        .map_err(Failure::failed)?;
    let detection = detect(
        &ready.reference,
        &current,
        &engine.novelty,
        seed,
        &mut |_| (),
    )
    .map_err(Failure::failed)?;
    let found: Option<Vec<usize>> = last.novelties.iter().map(|n| find(n, &detection)).collect();
    let found = found.filter(|found| !found.is_empty()).ok_or_else(|| {
        let why = format!(
            "the sweep of visit {} does not show it any more with the settings in force; visit the waypoint again",
            last.visit_id
        );
        refused(id, why)
    })?;
    let view = accept_novelties(&ready.reference, &detection, &found);
    let reference = prepare(&view, &engine, seed).map_err(Failure::failed)?;
    let new = NewReference {
        waypoint: &waypoint,
        sweep: SweepRecord {
            dialogue: None,
            view: Some(&view),
            raw: None,
            quality: "null",
        },
        mixture: &reference.gamma,
        model: &engine.novelty.reference_model(seed),
        engine: &settings.engine_json(),
        seed,
        accepted: &[id],
        frame: ReferenceFrame::Version(stored.frame_version),
    };
    let now = record_time_now();
    let version = store.teach(&new, &now)?;
    // After it: an alarm that could not be accepted stays as it was.
    store.acknowledge(id, by, None, &now)?;
    let text = format!("alarm {id} accepted by {by}: reference {waypoint}/{version}");
    store.note_event(Severity::Info, "service", &text, &now)?;
    Ok(AcceptReport {
        alarm: id,
        waypoint,
        version,
    })
}

/// The sighting to accept: of a standing alarm, in the frame of the reference in use.
fn last_sighting<'a>(
    alarm: &'a AlarmRow,
    stored: &StoredReference,
) -> Result<&'a LastSighting, Failure> {
    if alarm.state == "cleared" {
        return Err(refused(alarm.id, "it is cleared".to_owned()));
    }
    let last = alarm
        .last_sighting
        .as_ref()
        .ok_or_else(|| refused(alarm.id, "the log does not say what it is".to_owned()))?;
    let frame = stored.positions_frame(&alarm.waypoint);
    if last.frame != frame {
        let why = format!(
            "it was seen in the frame of {}, the reference is in that of {frame}; visit the waypoint again",
            last.frame
        );
        return Err(refused(alarm.id, why));
    }
    Ok(last)
}

fn refused(id: i64, why: String) -> Failure {
    StoreError::NotAcceptable { id, why }.into()
}

/// Position of the recorded novelty, which is in the reference's frame, among those of the detection.
fn find(recorded: &NoveltyRecord, detection: &Detection) -> Option<usize> {
    let reference_from_current = detection.registration.current_from_reference.inverse();
    let off_m = |position: &usize| {
        let centre = reference_from_current * detection.novelties[*position].moments.mean;
        (centre - Point3::from(recorded.centre)).norm()
    };
    (0..detection.novelties.len())
        .filter(|position| detection.novelties[*position].kind.as_str() == recorded.kind)
        .filter(|position| off_m(position) <= MAX_OFF_M)
        .min_by(|a, b| off_m(a).total_cmp(&off_m(b)))
}
