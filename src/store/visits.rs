//! Visits: what was swept, judged and decided, in one transaction, on disk before anyone is told.

use super::alarms;
use super::error::StoreError;
use super::handle::{Stamp, Store};
use super::novelties::{finite, insert_novelties, sighting};
use super::references::newest_reference;
use super::sweeps::{SweepRecord, insert_sweep};
use super::waypoints::known_waypoint;
use crate::alarm::{Decision, Sighting, decide};
use patrold_engine::blob::decode_view;
use patrold_engine::geometry::View;
use patrold_engine::novelty::Verdict;
use patrold_engine::report::NoveltyRecord;
use rusqlite::{OptionalExtension, Row, Transaction, params};

/// A visit to be kept.
#[derive(Debug)]
pub struct NewVisit<'a> {
    /// The waypoint's name.
    pub waypoint: &'a str,
    /// Sequence number of the reference it was compared with.
    pub reference_id: Option<i64>,
    /// Its sweep, if one was taken.
    pub sweep: Option<SweepRecord<'a>>,
    /// The verdict.
    pub verdict: Verdict,
    /// Why.
    pub reason: &'a str,
    /// d_GMM where one could be computed.
    pub d_gmm: Option<f64>,
    /// The threshold in force.
    pub u_th: f64,
    /// Seed of the engine.
    pub seed: u64,
    /// Engine settings, as JSON.
    pub engine: &'a str,
    /// The whole report, as JSON.
    pub report: &'a str,
    /// Novelties in the waypoint's reference frame.
    pub novelties: &'a [NoveltyRecord],
    /// Distance within which a change seen again is the same, metres.
    pub same_place_m: f64,
}

/// What became of a visit.
#[derive(Debug, Clone, PartialEq)]
pub struct Recorded {
    /// Sequence number of the visit.
    pub visit_id: i64,
    /// The alarm that this visit raised.
    pub raised: Option<i64>,
    /// The standing alarm that this visit belongs to.
    pub folded: Option<i64>,
    /// Alarms that this visit cleared.
    pub cleared: Vec<i64>,
    /// Whether the reference it was compared with was in use no more, taught anew or forgotten while the
    /// comparison ran: such a visit is on record and touches no alarm.
    pub outdated: bool,
}

/// A visit read back for another judgement.
#[derive(Debug, Clone)]
pub struct StoredVisit {
    /// The waypoint's name.
    pub waypoint: String,
    /// The reference it was compared with, if there was one.
    pub reference_id: Option<i64>,
    /// What was seen; `None` where the raw data could not be assembled.
    pub view: Option<View>,
    /// Raw data, in the sweep room's form.
    pub raw: Option<Vec<u8>>,
    /// Quality figures of the sweep, as JSON.
    pub quality: String,
    /// The stored verdict's word.
    pub verdict: String,
    /// The stored distance.
    pub d_gmm: Option<f64>,
    /// The threshold then in force.
    pub u_th: Option<f64>,
    /// The seed.
    pub seed: u64,
    /// The engine settings then in force, as JSON.
    pub engine: String,
}

impl Store {
    /// Keeps a visit and what it does to the waypoint's alarms. When this returns, it is on disk.
    ///
    /// # Errors
    /// Unknown waypoint, or the disk or database refuses; nothing was changed then.
    pub fn record_visit(
        &mut self,
        visit: &NewVisit<'_>,
        stamp: &Stamp,
    ) -> Result<Recorded, StoreError> {
        let files = visit
            .sweep
            .as_ref()
            .map(|sweep| sweep.write_files(&self.files))
            .transpose()?;
        self.change(|change| {
            let (waypoint, outdated) = place_of(change, visit)?;
            let sweep_id = match (&visit.sweep, &files) {
                (Some(sweep), Some(files)) => {
                    Some(insert_sweep(change, waypoint, sweep, files, stamp)?)
                }
                _ => None,
            };
            let visit_id = insert_visit(change, waypoint, sweep_id, visit, stamp)?;
            insert_novelties(change, visit_id, visit.novelties)?;
            let mut recorded = Recorded {
                visit_id,
                raised: None,
                folded: None,
                cleared: Vec::new(),
                outdated,
            };
            if !outdated {
                settle(change, waypoint, visit, stamp, &mut recorded)?;
            }
            Ok(recorded)
        })
    }

    /// Reads a visit back with its sweep, to be judged again.
    ///
    /// # Errors
    /// No such visit, its sweep is not kept, or a file is damaged.
    pub fn visit(&self, id: i64) -> Result<StoredVisit, StoreError> {
        let (mut visit, files) = self.read(|db| {
            let row = db.query_row(
                "SELECT w.name, v.reference_id, v.verdict, v.d_gmm, v.u_th, v.seed, v.engine,
                        coalesce(s.quality, 'null'), s.view_file, s.raw_file
                 FROM visit v JOIN waypoint w ON w.id = v.waypoint_id
                 LEFT JOIN sweep s ON s.id = v.sweep_id
                 WHERE v.id = ?1",
                [id],
                |row| {
                    let files: [Option<String>; 2] = [row.get(8)?, row.get(9)?];
                    Ok((read_visit(row)?, files))
                },
            );
            row.optional()?.ok_or(StoreError::UnknownVisit(id))
        })?;
        if files.iter().all(Option::is_none) {
            return Err(StoreError::NotKept {
                what: format!("the sweep of visit {id}"),
                why: "none was taken, or retention took it (store.keep_days, store.keep_gib)",
            });
        }
        let [view, raw] = files;
        if let Some(file) = view {
            visit.view = Some(decode_view(&file, &self.files.get(&file)?)?);
        }
        visit.raw = raw.map(|file| self.files.get(&file)).transpose()?;
        Ok(visit)
    }
}

fn read_visit(row: &Row<'_>) -> rusqlite::Result<StoredVisit> {
    Ok(StoredVisit {
        waypoint: row.get(0)?,
        reference_id: row.get(1)?,
        view: None,
        raw: None,
        quality: row.get(7)?,
        verdict: row.get(2)?,
        d_gmm: row.get(3)?,
        u_th: row.get(4)?,
        seed: row.get::<_, i64>(5)? as u64,
        engine: row.get(6)?,
    })
}

/// The waypoint that a visit belongs to, and whether its reference is no longer the one in use there.
fn place_of(change: &Transaction<'_>, visit: &NewVisit<'_>) -> Result<(i64, bool), StoreError> {
    let Some(reference) = visit.reference_id else {
        return Ok((known_waypoint(change, visit.waypoint)?, false));
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
    let newest = newest_reference(change, waypoint)?;
    Ok((waypoint, forgotten || newest != Some(reference)))
}

fn insert_visit(
    change: &Transaction<'_>,
    waypoint_id: i64,
    sweep_id: Option<i64>,
    visit: &NewVisit<'_>,
    stamp: &Stamp,
) -> Result<i64, StoreError> {
    change.execute(
        "INSERT INTO visit (waypoint_id, reference_id, sweep_id, at, boot_id, verdict, reason, d_gmm, u_th,
                            seed, engine, report)
         VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12)",
        params![
            waypoint_id,
            visit.reference_id,
            sweep_id,
            stamp.text(),
            stamp.boot_id,
            visit.verdict.word(),
            visit.reason,
            visit.d_gmm.and_then(finite),
            finite(visit.u_th),
            visit.seed as i64,
            visit.engine,
            visit.report
        ],
    )?;
    Ok(change.last_insert_rowid())
}

fn settle(
    change: &Transaction<'_>,
    waypoint_id: i64,
    visit: &NewVisit<'_>,
    stamp: &Stamp,
    recorded: &mut Recorded,
) -> Result<(), StoreError> {
    let visit_id = recorded.visit_id;
    let seen: Vec<Sighting> = visit.novelties.iter().map(sighting).collect();
    let standing = alarms::standing(change, waypoint_id)?;
    for decision in decide(visit.verdict, &seen, &standing, visit.same_place_m) {
        match decision {
            Decision::Raise => {
                recorded.raised = Some(alarms::raise(change, waypoint_id, visit_id, stamp)?);
            }
            Decision::Fold(id) => {
                alarms::fold(change, id, visit_id, stamp)?;
                recorded.folded = Some(id);
            }
            Decision::Clear(id) => {
                alarms::clear(change, id, &stamp.text(), "seen without the change")?;
                recorded.cleared.push(id);
            }
        }
    }
    Ok(())
}
