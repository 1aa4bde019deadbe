//! What the last visit saw of an alarm becomes normal, as a new version of the reference: prepared first, which takes seconds
//! and changes nothing, then stored.

use super::replies::AcceptReply;
use crate::config::Settings;
use crate::patrol::severity::Severity;
use crate::store::{
    AlarmRow, LastSighting, NewReference, RecordTime, ReferenceFrame, Store, StoreError,
    StoredReference, SweepRecord,
};
use nalgebra::Point3;
use patrold_engine::geometry::View;
use patrold_engine::inspect::prepare;
use patrold_engine::novelty::{Detection, ReferenceMixture, accept_novelties, detect};
use patrold_engine::report::NoveltyRecord;

/// A novelty found again in the stored sweep is within this of the recorded one, metres: the same data gives the same place,
/// another fit of the reference nearly so.
const MAX_OFF_M: f64 = 0.1;

/// A reference in which the thing of an alarm is normal.
#[derive(Debug)]
pub struct Acceptance {
    alarm: i64,
    waypoint: String,
    view: View,
    mixture: ReferenceMixture,
    model: String,
    engine: String,
    seed: u64,
    /// Sequence number of the reference that it is made from.
    replaces: i64,
    frame_version: i64,
}

impl Acceptance {
    /// Of the alarm with this number, under the settings in force. Only reads.
    ///
    /// # Errors
    /// No such alarm, one that is cleared or was seen in another frame, or its sweep does not show it any more.
    pub fn prepare(store: &Store, settings: &Settings, alarm: i64) -> Result<Self, StoreError> {
        let row = store.alarm(alarm)?;
        let waypoint = row.waypoint.clone();
        let stored = store.reference(&waypoint)?;
        let last = last_sighting(&row, &stored)?;
        let visit = store.visit(last.visit_id)?;
        let current = visit.view.ok_or_else(|| {
            refused(
                alarm,
                "its sweep gave no points; visit the waypoint again".to_owned(),
            )
        })?;
        let (engine, seed) = (
            settings.engine_settings(Some(&waypoint)),
            settings.mixture.seed,
        );
        let ready = stored
            .make_ready(&waypoint, &engine, seed)
            .map_err(|error| refused(alarm, error.to_string()))?;
        let detection = detect(
            &ready.reference,
            &current,
            &engine.novelty,
            seed,
            &mut |_| (),
        )
        .map_err(|error| refused(alarm, error.to_string()))?;
        let found: Option<Vec<usize>> =
            last.novelties.iter().map(|n| find(n, &detection)).collect();
        let found = found.filter(|found| !found.is_empty()).ok_or_else(|| {
            let why = format!(
                "the sweep of visit {} does not show it any more with the settings in force; visit the waypoint again",
                last.visit_id
            );
            refused(alarm, why)
        })?;
        let view = accept_novelties(&ready.reference, &detection, &found);
        let reference =
            prepare(&view, &engine, seed).map_err(|error| refused(alarm, error.to_string()))?;
        Ok(Self {
            alarm,
            waypoint,
            view,
            mixture: reference.gamma,
            model: engine.novelty.reference_model(seed),
            engine: settings.engine_json(),
            seed,
            replaces: stored.id,
            frame_version: stored.frame_version,
        })
    }

    /// Stores the reference; `by` has accepted the alarm.
    ///
    /// # Errors
    /// The reference was replaced or the alarm was cleared meanwhile, or the disk or the database fails.
    pub fn store(
        &self,
        store: &mut Store,
        by: &str,
        stamp: &RecordTime,
    ) -> Result<AcceptReply, StoreError> {
        let (alarm, waypoint) = (self.alarm, &self.waypoint);
        if store.reference(waypoint)?.id != self.replaces {
            let why = format!("the reference of {waypoint} was replaced meanwhile; try again");
            return Err(refused(alarm, why));
        }
        let new = NewReference {
            waypoint,
            sweep: SweepRecord {
                dialogue: None,
                view: Some(&self.view),
                raw: None,
                quality: "null",
            },
            mixture: &self.mixture,
            model: &self.model,
            engine: &self.engine,
            seed: self.seed,
            accepted: &[alarm],
            frame: ReferenceFrame::Version(self.frame_version),
        };
        let version = store.teach(&new, stamp)?;
        // After it: an alarm that could not be accepted stays as it was.
        store.acknowledge(alarm, by, None, stamp)?;
        let text = format!("alarm {alarm} accepted by {by}: reference {waypoint}/{version}");
        store.note_event(Severity::Info, "service", &text, stamp)?;
        Ok(AcceptReply {
            alarm,
            waypoint: waypoint.clone(),
            version,
            by: by.to_owned(),
        })
    }
}

/// The sighting to accept: of a standing alarm, in the frame of the reference in use.
fn last_sighting<'a>(
    alarm: &'a AlarmRow,
    stored: &StoredReference,
) -> Result<&'a LastSighting, StoreError> {
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

pub(super) fn refused(id: i64, why: String) -> StoreError {
    StoreError::NotAcceptable { id, why }
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
