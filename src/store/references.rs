//! References of waypoints. Each `teach` adds a version; the newest is in use, older ones are kept.

pub(super) mod new_mixture;
pub(super) mod ready_reference;
pub(super) mod stored_mixture;

use super::alarms::incidents::{clear_alarms, standing_alarms};
use super::checksum::sha256_hex;
use super::connection::{RecordTime, Store};
use super::error::StoreError;
use super::lookup::{find_waypoint_id, newest_reference_id, waypoint_id};
use super::sweeps::{SweepFiles, SweepRecord, insert_sweep};
use crate::config::edit_distance;
use nalgebra::Point3;
use patrold_engine::blob::{decode_view, encode_mixture};
use patrold_engine::geometry::View;
use patrold_engine::novelty::ReferenceMixture;
use rusqlite::{Connection, OptionalExtension, Row, Transaction, params};
use serde::Serialize;
use stored_mixture::StoredMixture;

/// A new name this near to a known one may be a slip of the pen: letters to insert, delete or replace.
const MAX_NAME_EDITS: usize = 2;

/// A reference to be stored.
#[derive(Debug)]
pub struct NewReference<'a> {
    /// Name of the waypoint; created if it is new.
    pub waypoint: &'a str,
    /// The sweep it was made from; must have a view.
    pub sweep: SweepRecord<'a>,
    /// Mixture of the sweep's view.
    pub mixture: &'a ReferenceMixture,
    /// What the mixture was made by, as JSON.
    pub model: &'a str,
    /// Engine settings of the mixture, as JSON.
    pub engine: &'a str,
    /// Seed of the engine's random numbers.
    pub seed: u64,
    /// Standing alarms of the waypoint whose things are normal in it.
    pub accepted: &'a [i64],
    /// Whose frame it is in.
    pub frame: ReferenceFrame,
}

/// Frame of a reference's positions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReferenceFrame {
    /// Its own: the robot stood elsewhere than before. No alarm may stand beside those that are accepted.
    Own,
    /// That of this version. The other alarms stand on.
    Version(i64),
}

/// One version of a waypoint's reference.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReferenceRow {
    /// Version, from 1.
    pub version: i64,
    /// When it was taken, RFC 3339.
    pub taken_at: String,
    /// Points of its sweep.
    pub points: i64,
    /// Components of its mixture.
    pub components: i64,
    /// The version whose frame its positions are in: its own, or the one that it was accepted or restored from.
    pub frame_version: i64,
}

/// A reference as stored.
#[derive(Debug, Clone)]
pub struct StoredReference {
    /// Sequence number of the row.
    pub id: i64,
    /// Version, from 1.
    pub version: i64,
    /// Points of the sweep.
    pub view: View,
    /// Mixture of the view, as far as it is sound.
    pub mixture: StoredMixture,
    /// Checksum that the row has for the mixture; none in rows of earlier versions.
    pub checksum: Option<String>,
    /// Components of the mixture, as the row has them.
    pub components: usize,
    /// The version whose frame it is in.
    pub frame_version: i64,
    /// Whether it is the newest of a waypoint that is not forgotten.
    pub in_use: bool,
    /// Engine settings of the mixture, as JSON.
    pub engine: String,
    /// Seed of the engine's random numbers.
    pub seed: u64,
}

impl Store {
    /// Stores a reference as the waypoint's new version and clears the accepted alarms, whose things are normal in it.
    /// Returns the version.
    ///
    /// # Errors
    /// Alarms stand that are not accepted, the sweep has no view, or the disk or the database fails; nothing is changed
    /// then.
    pub fn teach(&mut self, new: &NewReference<'_>, stamp: &RecordTime) -> Result<i64, StoreError> {
        if new.sweep.view.is_none() {
            return Err(StoreError::NotKept {
                what: format!("the reference of {}", new.waypoint),
                why: "its sweep could not be assembled; teach it again",
            });
        }
        // Its waypoint may be in the journal under the same name.
        if self.changes_lost()? > 0 {
            let files = self.count_files()?;
            return Err(StoreError::DatabaseLost { files });
        }
        let files = new.sweep.files();
        self.check_space(files.bytes())?;
        files.write(&self.files)?;
        self.transaction(|change| insert_reference(change, new, &files, stamp))
    }

    /// Whether a reference of this name may be taken, before anyone sweeps for it.
    ///
    /// # Errors
    /// Standing alarms of the waypoint that are not in `accepted`, or alarms in `accepted` that are none of these; a new name that
    /// is within two letters of a known one, unless `new_name`.
    pub fn check_teach(
        &self,
        waypoint: &str,
        accepted: &[i64],
        new_name: bool,
    ) -> Result<(), StoreError> {
        self.query(|db| match find_waypoint_id(db, waypoint)? {
            Some(id) => check_accepted(db, id, waypoint, accepted, ReferenceFrame::Own),
            None if new_name => Ok(()),
            None => {
                let mut query = db.prepare(
                    "SELECT name FROM waypoint WHERE forgotten_at IS NULL ORDER BY name",
                )?;
                let names: Vec<String> = query
                    .query_map([], |row| row.get(0))?
                    .collect::<Result<_, _>>()?;
                let nearly = |known: &&String| edit_distance(known, waypoint) <= MAX_NAME_EDITS;
                match names.iter().find(nearly) {
                    None => Ok(()),
                    Some(like) => Err(StoreError::NameLike {
                        name: waypoint.to_owned(),
                        like: like.clone(),
                    }),
                }
            }
        })
    }

    /// Makes an older version of a waypoint's reference its newest: the same view and mixture, in the same frame. Returns the
    /// new version.
    ///
    /// # Errors
    /// No such version, its view was deleted, or alarms stand that are not accepted.
    pub fn restore_reference(
        &mut self,
        waypoint: &str,
        version: i64,
        accepted: &[i64],
        stamp: &RecordTime,
    ) -> Result<i64, StoreError> {
        // Its view is whole, or an error says what is missing.
        let stored = self.reference_version(waypoint, version)?;
        self.transaction(|change| {
            let id = waypoint_id(change, waypoint)?;
            check_accepted(change, id, waypoint, accepted, ReferenceFrame::Own)?;
            let next = next_version(change, waypoint)?;
            change.execute(
                "INSERT INTO reference (waypoint_id, version, sweep_id, taken_at, boot_id, components, seed, engine, mixture,
                                        mixture_sha256, model, frame_version)
                 SELECT ?2, ?3, sweep_id, taken_at, ?4, components, seed, engine, mixture, mixture_sha256, model, ?5
                 FROM reference WHERE id = ?1",
                params![stored.id, id, next, stamp.boot_id, stored.frame_version],
            )?;
            let because = format!("reference {waypoint}/{version} restored");
            clear_alarms(change, accepted, &stamp.to_rfc3339(), &because)?;
            Ok(next)
        })
    }

    /// The reference in use at a waypoint.
    ///
    /// # Errors
    /// Unknown waypoint, no reference, or a damaged file.
    pub fn reference(&self, waypoint: &str) -> Result<StoredReference, StoreError> {
        let id = self.query(|db| {
            let newest = newest_reference_id(db, waypoint_id(db, waypoint)?)?;
            newest.ok_or_else(|| StoreError::NoReference {
                name: waypoint.to_owned(),
            })
        });
        match id {
            Err(StoreError::UnknownWaypoint { .. } | StoreError::NoReference { .. })
                if self.is_lost()? =>
            {
                let files = self.count_files()?;
                Err(StoreError::DatabaseLost { files })
            }
            id => self.reference_by_id(id?),
        }
    }

    /// A version of a waypoint's reference, also of a forgotten waypoint.
    ///
    /// # Errors
    /// No such version, its sweep was deleted, or a damaged file of the view.
    pub fn reference_version(
        &self,
        waypoint: &str,
        version: i64,
    ) -> Result<StoredReference, StoreError> {
        let id = self.query(|db| {
            let row = db.query_row(
                "SELECT r.id FROM reference r JOIN waypoint w ON w.id = r.waypoint_id
                 WHERE w.name = ?1 AND r.version = ?2",
                params![waypoint, version],
                |row| row.get(0),
            );
            row.optional()?.ok_or_else(|| StoreError::NotKept {
                what: format!("reference {waypoint}/{version}"),
                why: "no such version; `patrold waypoints show NAME` lists them",
            })
        })?;
        self.reference_by_id(id)
    }

    /// The reference with this sequence number, whatever its version. A mixture that is not sound is no error.
    ///
    /// # Errors
    /// No such row, its sweep was deleted, or a damaged file of the view.
    pub fn reference_by_id(&self, id: i64) -> Result<StoredReference, StoreError> {
        let found = self.query(|db| {
            let row = db.query_row(
                "SELECT r.version, r.mixture, r.mixture_sha256, r.model, r.components, r.engine, r.seed, s.view_file,
                        w.forgotten_at IS NULL
                        AND r.version = (SELECT max(version) FROM reference WHERE waypoint_id = w.id),
                        coalesce(r.frame_version, r.version)
                 FROM reference r JOIN sweep s ON s.id = r.sweep_id JOIN waypoint w ON w.id = r.waypoint_id
                 WHERE r.id = ?1",
                [id],
                read_stored,
            );
            Ok(row.optional()?)
        })?;
        let gone = |why| StoreError::NotKept {
            what: format!("reference {id}"),
            why,
        };
        let (mut stored, file) = found.ok_or_else(|| gone("no such row"))?;
        let file =
            file.ok_or_else(|| gone("its waypoint was forgotten, and retention deleted it"))?;
        stored.id = id;
        stored.view = decode_view(&file, &self.files.get(&file)?)?;
        Ok(stored)
    }
}

/// The row without its view, and the file of that.
fn read_stored(row: &Row<'_>) -> rusqlite::Result<(StoredReference, Option<String>)> {
    let (bytes, checksum, model): (Vec<u8>, Option<String>, Option<String>) =
        (row.get(1)?, row.get(2)?, row.get(3)?);
    let stored = StoredReference {
        id: 0,
        version: row.get(0)?,
        view: View::from_points(Vec::new(), Point3::origin()),
        mixture: StoredMixture::from_row(&bytes, checksum.as_deref(), model),
        checksum,
        components: row.get::<_, i64>(4)?.max(0) as usize,
        in_use: row.get(8)?,
        frame_version: row.get(9)?,
        engine: row.get(5)?,
        seed: row.get::<_, i64>(6)? as u64,
    };
    Ok((stored, row.get(7)?))
}

fn insert_reference(
    change: &Transaction<'_>,
    new: &NewReference<'_>,
    files: &SweepFiles,
    stamp: &RecordTime,
) -> Result<i64, StoreError> {
    let at = stamp.to_rfc3339();
    let waypoint = match find_waypoint_id(change, new.waypoint)? {
        Some(id) => id,
        None => {
            change.execute(
                "INSERT INTO waypoint (name, created_at) VALUES (?1, ?2)",
                params![new.waypoint, at],
            )?;
            change.last_insert_rowid()
        }
    };
    check_accepted(change, waypoint, new.waypoint, new.accepted, new.frame)?;
    let sweep = insert_sweep(change, waypoint, &new.sweep, files, "stored", stamp)?;
    let version = next_version(change, new.waypoint)?;
    let frame_version = match new.frame {
        ReferenceFrame::Own => None,
        ReferenceFrame::Version(version) => Some(version),
    };
    let bytes = encode_mixture(new.mixture);
    change.execute(
        "INSERT INTO reference (waypoint_id, version, sweep_id, taken_at, boot_id, components, seed, engine, mixture,
                                mixture_sha256, model, frame_version)
         VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12)",
        params![
            waypoint,
            version,
            sweep,
            at,
            stamp.boot_id,
            new.mixture.mixture.len() as i64,
            new.seed as i64,
            new.engine,
            bytes,
            sha256_hex(&bytes),
            new.model,
            frame_version
        ],
    )?;
    let because = format!("accepted with reference {}/{version}", new.waypoint);
    clear_alarms(change, new.accepted, &at, &because)?;
    Ok(version)
}

/// Versions continue after those of a forgotten waypoint of the same name: the frame NAME/VERSION stays unique.
fn next_version(db: &Connection, waypoint: &str) -> rusqlite::Result<i64> {
    db.query_row(
        "SELECT coalesce(max(version), 0) + 1 FROM reference r JOIN waypoint w ON w.id = r.waypoint_id
         WHERE w.name = ?1",
        [waypoint],
        |row| row.get(0),
    )
}

/// Refuses to accept what does not stand at the waypoint, and, in a new frame, to leave what does.
fn check_accepted(
    db: &Connection,
    waypoint_id: i64,
    waypoint: &str,
    accepted: &[i64],
    frame: ReferenceFrame,
) -> Result<(), StoreError> {
    let standing = standing_alarms(db, waypoint_id)?;
    if let Some(id) = accepted.iter().find(|id| !standing.contains(id)) {
        return Err(StoreError::NotAcceptable {
            id: *id,
            why: format!("it does not stand at {waypoint}; `patrold alarms list` shows what does"),
        });
    }
    let left = standing.into_iter().filter(|id| !accepted.contains(id));
    let ids: Vec<i64> = left.collect();
    if frame == ReferenceFrame::Own && !ids.is_empty() {
        let name = waypoint.to_owned();
        return Err(StoreError::StandingAlarms { name, ids });
    }
    Ok(())
}

/// Every version of a waypoint's reference, newest first.
pub(super) fn reference_rows(
    db: &Connection,
    waypoint_id: i64,
) -> Result<Vec<ReferenceRow>, StoreError> {
    let mut query = db.prepare(
        "SELECT r.version, r.taken_at, s.points, r.components, coalesce(r.frame_version, r.version)
         FROM reference r JOIN sweep s ON s.id = r.sweep_id
         WHERE r.waypoint_id = ?1 ORDER BY r.version DESC",
    )?;
    let rows = query.query_map([waypoint_id], |row| {
        Ok(ReferenceRow {
            version: row.get(0)?,
            taken_at: row.get(1)?,
            points: row.get(2)?,
            components: row.get(3)?,
            frame_version: row.get(4)?,
        })
    })?;
    Ok(rows.collect::<Result<_, _>>()?)
}
