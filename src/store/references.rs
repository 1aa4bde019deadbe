//! References have a life: each teaching makes a version, the newest is in use, the others stay.

use super::error::StoreError;
use super::handle::{Stamp, Store};
use super::visits::{SweepRecord, insert_sweep};
use super::waypoints::{find_waypoint, known_waypoint};
use super::{cloud_blob, mixture_blob};
use crate::geometry::View;
use crate::mixture::Mixture;
use rusqlite::{OptionalExtension, params};
use serde::Serialize;

/// A reference to be kept.
#[derive(Debug)]
pub struct NewReference<'a> {
    /// The waypoint's name; made where it is new.
    pub waypoint: &'a str,
    /// The sweep it was made from.
    pub sweep: SweepRecord<'a>,
    /// Its mixture.
    pub mixture: &'a Mixture,
}

/// One version of a waypoint's reference.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReferenceRow {
    /// Version, from 1.
    pub version: i64,
    /// When it was taken.
    pub taken_at: String,
    /// Points of its sweep.
    pub points: i64,
    /// Components of its mixture.
    pub components: i64,
}

/// A reference read back.
#[derive(Debug, Clone)]
pub struct StoredReference {
    /// Its row's sequence number.
    pub id: i64,
    /// Version, from 1.
    pub version: i64,
    /// What was seen.
    pub view: View,
    /// Its mixture.
    pub mixture: Mixture,
}

impl Store {
    /// Keeps a reference as the waypoint's new version; its standing alarms are cleared, for they speak of the
    /// old one. Gives the version.
    ///
    /// # Errors
    /// The disk or the database refuses; nothing was changed then.
    pub fn teach(&mut self, new: &NewReference<'_>, stamp: &Stamp) -> Result<i64, StoreError> {
        let files = new.sweep.write_files(&self.files)?;
        let at = stamp.text();
        let change = self.db.transaction()?;
        let waypoint = match find_waypoint(&change, new.waypoint)? {
            Some(id) => id,
            None => {
                change.execute(
                    "INSERT INTO waypoint (name, created_at) VALUES (?1, ?2)",
                    params![new.waypoint, at],
                )?;
                change.last_insert_rowid()
            }
        };
        let sweep = insert_sweep(&change, waypoint, &new.sweep, &files, stamp)?;
        let version: i64 = change.query_row(
            "SELECT coalesce(max(version), 0) + 1 FROM reference WHERE waypoint_id = ?1",
            [waypoint],
            |row| row.get(0),
        )?;
        change.execute(
            "INSERT INTO reference (waypoint_id, version, sweep_id, taken_at, boot_id, components, mixture)
             VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)",
            params![
                waypoint,
                version,
                sweep,
                at,
                stamp.boot_id,
                new.mixture.len() as i64,
                mixture_blob::encode(new.mixture)
            ],
        )?;
        super::alarms::clear_standing(&change, waypoint, &at, "reference taught anew")?;
        change.commit()?;
        Ok(version)
    }

    /// The reference in use at a waypoint.
    ///
    /// # Errors
    /// Unknown waypoint, no reference, or a damaged file.
    pub fn reference(&self, waypoint: &str) -> Result<StoredReference, StoreError> {
        let id = known_waypoint(&self.db, waypoint)?;
        let newest: Option<i64> = self
            .db
            .query_row(
                "SELECT id FROM reference WHERE waypoint_id = ?1 ORDER BY version DESC LIMIT 1",
                [id],
                |row| row.get(0),
            )
            .optional()?;
        let missing = || StoreError::NoReference {
            name: waypoint.to_owned(),
        };
        self.reference_by_id(newest.ok_or_else(missing)?)
    }

    /// The reference with this sequence number, in use or not.
    ///
    /// # Errors
    /// No such row, or a damaged file.
    pub fn reference_by_id(&self, id: i64) -> Result<StoredReference, StoreError> {
        let (version, mixture, file): (i64, Vec<u8>, String) = self.db.query_row(
            "SELECT r.version, r.mixture, s.view_file
             FROM reference r JOIN sweep s ON s.id = r.sweep_id WHERE r.id = ?1",
            [id],
            |row| Ok((row.get(0)?, row.get(1)?, row.get(2)?)),
        )?;
        Ok(StoredReference {
            id,
            version,
            view: cloud_blob::decode(&file, &self.files.get(&file)?)?,
            mixture: mixture_blob::decode(&mixture)?,
        })
    }

    pub(super) fn references(&self, waypoint_id: i64) -> Result<Vec<ReferenceRow>, StoreError> {
        let mut query = self.db.prepare(
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
}
