//! References of waypoints. Each `teach` adds a version; the newest is in use, older ones are kept.

use super::alarms::clear_all;
use super::checksum::sha256_hex;
use super::connection::{RecordTime, Store};
use super::error::StoreError;
use super::lookup::{find_waypoint_id, newest_reference_id, waypoint_id};
use super::stored_mixture::StoredMixture;
use super::sweeps::{SweepFiles, SweepRecord, insert_sweep};
use nalgebra::Point3;
use patrold_engine::blob::{decode_view, encode_mixture};
use patrold_engine::geometry::View;
use patrold_engine::novelty::ReferenceMixture;
use rusqlite::{Connection, OptionalExtension, Row, Transaction, params};
use serde::Serialize;

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
    /// Whether it is the newest of a waypoint that is not forgotten.
    pub in_use: bool,
    /// Engine settings of the mixture, as JSON.
    pub engine: String,
    /// Seed of the engine's random numbers.
    pub seed: u64,
}

impl Store {
    /// Stores a reference as the waypoint's new version and clears the waypoint's alarms, which compare with the old one.
    /// Returns the version.
    ///
    /// # Errors
    /// The sweep has no view, or the disk or the database fails; nothing is changed then.
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
                        AND r.version = (SELECT max(version) FROM reference WHERE waypoint_id = w.id)
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
    let sweep = insert_sweep(change, waypoint, &new.sweep, files, "stored", stamp)?;
    // Versions continue after those of a forgotten waypoint of the same name: the frame NAME/VERSION stays unique.
    let version: i64 = change.query_row(
        "SELECT coalesce(max(version), 0) + 1 FROM reference r JOIN waypoint w ON w.id = r.waypoint_id
         WHERE w.name = ?1",
        [new.waypoint],
        |row| row.get(0),
    )?;
    let bytes = encode_mixture(new.mixture);
    change.execute(
        "INSERT INTO reference (waypoint_id, version, sweep_id, taken_at, boot_id, components, seed, engine, mixture,
                                mixture_sha256, model)
         VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11)",
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
            new.model
        ],
    )?;
    clear_all(change, waypoint, &at, "reference taught anew")?;
    Ok(version)
}

/// Every version of a waypoint's reference, newest first.
pub(super) fn reference_rows(
    db: &Connection,
    waypoint_id: i64,
) -> Result<Vec<ReferenceRow>, StoreError> {
    let mut query = db.prepare(
        "SELECT r.version, r.taken_at, s.points, r.components
         FROM reference r JOIN sweep s ON s.id = r.sweep_id
         WHERE r.waypoint_id = ?1 ORDER BY r.version DESC",
    )?;
    let rows = query.query_map([waypoint_id], |row| {
        Ok(ReferenceRow {
            version: row.get(0)?,
            taken_at: row.get(1)?,
            points: row.get(2)?,
            components: row.get(3)?,
        })
    })?;
    Ok(rows.collect::<Result<_, _>>()?)
}
