//! Visits: verdict, novelties and alarms in one transaction, which is on disk before the client gets its reply. The files of
//! the sweep are written after it; its row says whether they are there.

use super::alarms::incidents::{AlarmEffects, apply_decisions};
use super::connection::{RecordTime, Store};
use super::error::StoreError;
use super::lookup::{newest_reference_id, waypoint_id};
use super::novelties::{finite_or_null, insert_novelties};
use super::sweeps::{SweepFiles, SweepRecord, insert_sweep};
use crate::alarm::{Sighting, VisitFacts};
use patrold_engine::blob::decode_view;
use patrold_engine::geometry::View;
use patrold_engine::novelty::{PlaceView, Verdict};
use patrold_engine::report::NoveltyRecord;
use rusqlite::{OptionalExtension, Row, Transaction, params};

/// A visit to be stored.
#[derive(Debug, Clone)]
pub struct NewVisit<'a> {
    /// Name of the waypoint.
    pub waypoint: &'a str,
    /// Sequence number of the reference it was compared with.
    pub reference_id: Option<i64>,
    /// Its sweep, if one was taken.
    pub sweep: Option<SweepRecord<'a>>,
    /// Verdict of the engine.
    pub verdict: Verdict,
    /// Reason of the verdict, one line.
    pub reason: &'a str,
    /// d_GMM, if it could be computed.
    pub d_gmm: Option<f64>,
    /// U_th, in the unit of d_GMM.
    pub u_th: f64,
    /// Seed of the engine's random numbers.
    pub seed: u64,
    /// Engine settings, as JSON.
    pub engine: &'a str,
    /// The whole report, as JSON.
    pub report: &'a str,
    /// Novelties in the waypoint's reference frame.
    pub novelties: &'a [NoveltyRecord],
    /// How the visit saw the places of the waypoint's incidents, by number.
    pub places: &'a [(i64, PlaceView)],
    /// A thing that is further from where it was has moved, metres.
    pub same_place_m: f64,
}

/// The row of a visit and what it did to the alarms.
#[derive(Debug, Clone, PartialEq)]
pub struct VisitOutcome {
    /// Sequence number of the visit.
    pub visit_id: i64,
    /// What it did to the alarms.
    pub effects: AlarmEffects,
    /// The reference was replaced or forgotten while the comparison ran: the visit is stored and changes no alarm.
    pub outdated: bool,
    /// Sequence number of its sweep.
    pub sweep_id: Option<i64>,
    /// Why the files of the sweep could not be written; `None` where they are on disk.
    pub evidence_missing: Option<String>,
}

/// A visit as stored, to be judged again.
#[derive(Debug, Clone)]
pub struct StoredVisit {
    /// Name of the waypoint.
    pub waypoint: String,
    /// Sequence number of the reference it was compared with.
    pub reference_id: Option<i64>,
    /// Points of the sweep; `None`: the raw data could not be assembled.
    pub view: Option<View>,
    /// Raw sweep, encoded.
    pub raw: Option<Vec<u8>>,
    /// The bytes of both devices, as docs/recording.md has them; why they are not there.
    pub dialogue: Result<Vec<u8>, String>,
    /// Quality figures of the sweep, as JSON.
    pub quality: String,
    /// Verdict: quiet, changed or not_observed.
    pub verdict: String,
    /// d_GMM.
    pub d_gmm: Option<f64>,
    /// U_th then in force.
    pub u_th: Option<f64>,
    /// Seed of the engine's random numbers.
    pub seed: u64,
    /// Engine settings then in force, as JSON.
    pub engine: String,
}

/// Why a visit of an earlier version has no dialogue.
const TAKEN_BEFORE: &str = "it was taken before patrold kept the bytes of the devices";

impl Store {
    /// Stores a visit and its effect on the waypoint's alarms, then the files of its sweep. The rows are on disk when this
    /// returns; where the files are not, the outcome and the row say why.
    ///
    /// # Errors
    /// Unknown waypoint, or the database fails; nothing is changed then.
    pub fn record_visit(
        &mut self,
        visit: &NewVisit<'_>,
        stamp: &RecordTime,
    ) -> Result<VisitOutcome, StoreError> {
        self.record_visit_with(visit, stamp, visit.verdict == Verdict::Changed)
    }

    /// As [`record_visit`](Self::record_visit); `may_use_reserve`: an alarm depends on it.
    pub(super) fn record_visit_with(
        &mut self,
        visit: &NewVisit<'_>,
        stamp: &RecordTime,
        may_use_reserve: bool,
    ) -> Result<VisitOutcome, StoreError> {
        let files = visit.sweep.as_ref().map(SweepRecord::files);
        let rows = |change: &Transaction<'_>| insert_rows(change, visit, files.as_ref(), stamp);
        let mut outcome = if may_use_reserve {
            self.write_with_reserve(rows)?
        } else {
            self.check_space(0)?;
            self.write(rows)?
        };
        if let (Some(sweep_id), Some(files)) = (outcome.sweep_id, &files) {
            let written = self.write_evidence(sweep_id, files);
            outcome.evidence_missing = written.err().map(|error| error.to_string());
        }
        self.append_to_journal();
        Ok(outcome)
    }

    /// Reads a visit with its sweep.
    ///
    /// # Errors
    /// No such visit, its sweep was deleted, or a file is damaged.
    pub fn visit(&self, id: i64) -> Result<StoredVisit, StoreError> {
        let (mut visit, [view, raw, dialogue], missing, why) = self.query(|db| {
            let row = db.query_row(
                "SELECT w.name, v.reference_id, v.verdict, v.d_gmm, v.u_th, v.seed, v.engine,
                        coalesce(s.quality, 'null'), s.view_file, s.raw_file,
                        CASE s.evidence WHEN 'missing' THEN coalesce(s.evidence_why, '') END,
                        s.dialogue_file, s.dialogue_why
                 FROM visit v JOIN waypoint w ON w.id = v.waypoint_id
                 LEFT JOIN sweep s ON s.id = v.sweep_id
                 WHERE v.id = ?1",
                [id],
                |row| {
                    let files: [Option<String>; 3] = [row.get(8)?, row.get(9)?, row.get(11)?];
                    Ok((read_visit(row)?, files, row.get(10)?, row.get(12)?))
                },
            );
            row.optional()?.ok_or(StoreError::UnknownVisit(id))
        })?;
        visit.dialogue = match (dialogue, why) {
            (_, Some(why)) => Err(why),
            (Some(file), None) => self.files.get(&file).map_err(|error| error.to_string()),
            (None, None) => Err(TAKEN_BEFORE.to_owned()),
        };
        if visit.dialogue.is_err()
            && let Some(why) = missing
        {
            let what = format!("the sweep of visit {id}");
            return Err(StoreError::EvidenceMissing { what, why });
        }
        if visit.dialogue.is_err() && view.is_none() && raw.is_none() {
            return Err(StoreError::NotKept {
                what: format!("the sweep of visit {id}"),
                why: "none was taken, or retention deleted it (store.keep_days, store.keep_gib)",
            });
        }
        // What is damaged there, the bytes of the devices may give again.
        let is_needed = visit.dialogue.is_err();
        if let Some(file) = view {
            let view = self.files.get(&file);
            let view = view.and_then(|bytes| Ok(decode_view(&file, &bytes)?));
            visit.view = keep(view, is_needed)?;
        }
        if let Some(file) = raw {
            visit.raw = keep(self.files.get(&file), is_needed)?;
        }
        Ok(visit)
    }
}

fn keep<T>(read: Result<T, StoreError>, is_needed: bool) -> Result<Option<T>, StoreError> {
    match read {
        Err(error) if is_needed => Err(error),
        read => Ok(read.ok()),
    }
}

fn read_visit(row: &Row<'_>) -> rusqlite::Result<StoredVisit> {
    Ok(StoredVisit {
        waypoint: row.get(0)?,
        reference_id: row.get(1)?,
        view: None,
        raw: None,
        dialogue: Err(String::new()),
        quality: row.get(7)?,
        verdict: row.get(2)?,
        d_gmm: row.get(3)?,
        u_th: row.get(4)?,
        seed: row.get::<_, i64>(5)? as u64,
        engine: row.get(6)?,
    })
}

/// Id of the visit's waypoint, and whether its reference is no longer in use there.
fn find_waypoint_of_visit(
    change: &Transaction<'_>,
    visit: &NewVisit<'_>,
) -> Result<(i64, bool), StoreError> {
    let Some(reference) = visit.reference_id else {
        return Ok((waypoint_id(change, visit.waypoint)?, false));
    };
    let of_reference = change
        .query_row(
            "SELECT w.id, w.forgotten_at IS NOT NULL
             FROM reference r JOIN waypoint w ON w.id = r.waypoint_id WHERE r.id = ?1",
            [reference],
            |row| row.try_into(),
        )
        .optional()?;
    let (waypoint, forgotten): (i64, bool) = of_reference.ok_or_else(|| StoreError::NotKept {
        what: format!("reference {reference}"),
        why: "no such row",
    })?;
    let newest = newest_reference_id(change, waypoint)?;
    Ok((waypoint, forgotten || newest != Some(reference)))
}

fn insert_visit(
    change: &Transaction<'_>,
    waypoint_id: i64,
    sweep_id: Option<i64>,
    visit: &NewVisit<'_>,
    stamp: &RecordTime,
) -> Result<i64, StoreError> {
    change.execute(
        "INSERT INTO visit (waypoint_id, reference_id, sweep_id, at, boot_id, verdict, reason, d_gmm, u_th,
                            seed, engine, report)
         VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12)",
        params![
            waypoint_id,
            visit.reference_id,
            sweep_id,
            stamp.to_rfc3339(),
            stamp.boot_id,
            visit.verdict.as_str(),
            visit.reason,
            visit.d_gmm.and_then(finite_or_null),
            finite_or_null(visit.u_th),
            visit.seed as i64,
            visit.engine,
            visit.report
        ],
    )?;
    Ok(change.last_insert_rowid())
}

fn insert_rows(
    change: &Transaction<'_>,
    visit: &NewVisit<'_>,
    files: Option<&SweepFiles>,
    stamp: &RecordTime,
) -> Result<VisitOutcome, StoreError> {
    let (waypoint, outdated) = find_waypoint_of_visit(change, visit)?;
    let sweep_id = match (&visit.sweep, files) {
        (Some(sweep), Some(files)) => Some(insert_sweep(
            change, waypoint, sweep, files, "pending", stamp,
        )?),
        _ => None,
    };
    let visit_id = insert_visit(change, waypoint, sweep_id, visit, stamp)?;
    insert_novelties(change, visit_id, visit.novelties)?;
    let mut outcome = VisitOutcome {
        visit_id,
        effects: AlarmEffects::default(),
        outdated,
        sweep_id,
        evidence_missing: None,
    };
    if !outdated {
        let seen: Vec<Sighting> = visit.novelties.iter().map(Sighting::new).collect();
        let facts = VisitFacts {
            verdict: visit.verdict,
            seen: &seen,
            places: visit.places,
            same_place_m: visit.same_place_m,
        };
        outcome.effects = apply_decisions(change, waypoint, visit_id, &facts, stamp)?;
    }
    Ok(outcome)
}
