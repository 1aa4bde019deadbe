//! Visits: what was swept, judged and decided, in one transaction, on disk before anyone is told.

use super::error::StoreError;
use super::files::Files;
use super::handle::{Stamp, Store};
use super::waypoints::known_waypoint;
use super::{alarms, cloud_blob};
use crate::alarm::{Decision, Sighting, decide};
use crate::geometry::View;
use crate::novelty::{Kind, Verdict};
use crate::patrol::NoveltyRecord;
use nalgebra::Point3;
use rusqlite::{OptionalExtension, Transaction, TransactionBehavior, params};

/// A sweep to be kept.
#[derive(Debug)]
pub struct SweepRecord<'a> {
    /// What was seen.
    pub view: &'a View,
    /// Raw data: ranges, stamps, polls (bytes of the sweep room's own form).
    pub raw: Option<&'a [u8]>,
    /// Quality figures, as JSON.
    pub quality: &'a str,
}

/// Names of the two files of a sweep.
pub(super) struct SweepFiles {
    view: String,
    raw: Option<String>,
}

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
}

/// A visit read back for another judgement.
#[derive(Debug, Clone)]
pub struct StoredVisit {
    /// The waypoint's name.
    pub waypoint: String,
    /// The reference it was compared with.
    pub reference_id: i64,
    /// What was seen.
    pub view: View,
    /// The stored verdict's word.
    pub verdict: String,
    /// The stored distance.
    pub d_gmm: Option<f64>,
    /// The threshold then in force.
    pub u_th: f64,
    /// The seed.
    pub seed: u64,
}

impl SweepRecord<'_> {
    pub(super) fn write_files(&self, files: &Files) -> Result<SweepFiles, StoreError> {
        Ok(SweepFiles {
            view: files.put(&cloud_blob::encode(self.view))?,
            raw: self.raw.map(|raw| files.put(raw)).transpose()?,
        })
    }
}

pub(super) fn insert_sweep(
    change: &Transaction<'_>,
    waypoint_id: i64,
    sweep: &SweepRecord<'_>,
    files: &SweepFiles,
    stamp: &Stamp,
) -> Result<i64, StoreError> {
    change.execute(
        "INSERT INTO sweep (waypoint_id, taken_at, boot_id, points, view_file, raw_file, quality)
         VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)",
        params![
            waypoint_id,
            stamp.text(),
            stamp.boot_id,
            sweep.view.points.len() as i64,
            files.view,
            files.raw,
            sweep.quality
        ],
    )?;
    Ok(change.last_insert_rowid())
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
        let waypoint = known_waypoint(&self.db, visit.waypoint)?;
        let files = visit
            .sweep
            .as_ref()
            .map(|sweep| sweep.write_files(&self.files))
            .transpose()?;
        let change = self
            .db
            .transaction_with_behavior(TransactionBehavior::Immediate)?;
        let sweep_id = match (&visit.sweep, &files) {
            (Some(sweep), Some(files)) => {
                Some(insert_sweep(&change, waypoint, sweep, files, stamp)?)
            }
            _ => None,
        };
        let visit_id = insert_visit(&change, waypoint, sweep_id, visit, stamp)?;
        insert_novelties(&change, visit_id, visit.novelties)?;
        let recorded = settle(&change, waypoint, visit_id, visit, stamp)?;
        change.commit()?;
        Ok(recorded)
    }

    /// Reads a visit back with its sweep, to be judged again.
    ///
    /// # Errors
    /// No such visit, its sweep was not kept, or a file is damaged.
    pub fn visit(&self, id: i64) -> Result<StoredVisit, StoreError> {
        let row = self
            .db
            .query_row(
                "SELECT w.name, v.reference_id, s.view_file, v.verdict, v.d_gmm, v.u_th, v.seed
                 FROM visit v JOIN waypoint w ON w.id = v.waypoint_id
                 JOIN sweep s ON s.id = v.sweep_id
                 WHERE v.id = ?1 AND v.reference_id IS NOT NULL AND s.view_file IS NOT NULL",
                [id],
                |row| {
                    let file: String = row.get(2)?;
                    Ok((
                        file,
                        row.get(0)?,
                        row.get(1)?,
                        row.get(3)?,
                        row.get(4)?,
                        row.get(5)?,
                        row.get::<_, i64>(6)?,
                    ))
                },
            )
            .optional()?;
        let (file, waypoint, reference_id, verdict, d_gmm, u_th, seed) =
            row.ok_or(StoreError::UnknownVisit(id))?;
        Ok(StoredVisit {
            waypoint,
            reference_id,
            view: cloud_blob::decode(&file, &self.files.get(&file)?)?,
            verdict,
            d_gmm,
            u_th,
            seed: seed as u64,
        })
    }
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
            visit.d_gmm,
            visit.u_th,
            visit.seed as i64,
            visit.engine,
            visit.report
        ],
    )?;
    Ok(change.last_insert_rowid())
}

fn insert_novelties(
    change: &Transaction<'_>,
    visit_id: i64,
    novelties: &[NoveltyRecord],
) -> Result<(), StoreError> {
    for (position, novelty) in novelties.iter().enumerate() {
        let record = serde_json::to_string(novelty).map_err(|source| StoreError::Record {
            what: "novelty",
            source,
        })?;
        change.execute(
            "INSERT INTO novelty (visit_id, position, kind, x_m, y_m, z_m, points, mass, contribution, record)
             VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10)",
            params![
                visit_id,
                position as i64,
                novelty.kind,
                novelty.centre[0],
                novelty.centre[1],
                novelty.centre[2],
                novelty.points as i64,
                novelty.mass,
                novelty.contribution,
                record
            ],
        )?;
        if let Some(shape) = &novelty.shape {
            let novelty_id = change.last_insert_rowid();
            change.execute(
                "INSERT INTO shape (novelty_id, class, method, probability, size_x_m, size_y_m, size_z_m)
                 VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)",
                params![
                    novelty_id,
                    shape.class,
                    shape.method,
                    shape.probability,
                    shape.size[0],
                    shape.size[1],
                    shape.size[2]
                ],
            )?;
        }
    }
    Ok(())
}

fn settle(
    change: &Transaction<'_>,
    waypoint_id: i64,
    visit_id: i64,
    visit: &NewVisit<'_>,
    stamp: &Stamp,
) -> Result<Recorded, StoreError> {
    let seen: Vec<Sighting> = visit.novelties.iter().map(sighting).collect();
    let standing = alarms::standing(change, waypoint_id)?;
    let mut recorded = Recorded {
        visit_id,
        raised: None,
        folded: None,
        cleared: Vec::new(),
    };
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
    Ok(recorded)
}

/// What the alarm rule needs of a stored novelty.
pub(super) fn sighting(novelty: &NoveltyRecord) -> Sighting {
    let kind = if novelty.kind == "disappeared" {
        Kind::Disappeared
    } else {
        Kind::Appeared
    };
    let centre = Point3::from(novelty.centre);
    Sighting { kind, centre }
}
