//! Waypoints: listing and forgetting.

use super::alarms::incidents::clear_all;
use super::connection::{RecordTime, Store};
use super::error::StoreError;
use super::lookup::waypoint_id;
use super::references::{ReferenceRow, reference_rows};
use rusqlite::params;
use serde::Serialize;

/// A waypoint in the list.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WaypointRow {
    /// Unique in the store.
    pub name: String,
    /// When it was first taught, RFC 3339.
    pub created_at: String,
    /// Version of the reference in use.
    pub reference_version: Option<i64>,
    /// When that reference was taken, RFC 3339.
    pub reference_taken_at: Option<String>,
    /// Verdict of the last visit.
    pub last_verdict: Option<String>,
    /// When that visit was, RFC 3339.
    pub last_visit_at: Option<String>,
    /// d_GMM of that visit, in the unit of its ground distance.
    pub last_d_gmm: Option<f64>,
    /// Alarms that are not cleared.
    pub standing_alarms: i64,
}

/// A waypoint with all its reference versions.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WaypointDetail {
    /// As in the list.
    #[serde(flatten)]
    pub row: WaypointRow,
    /// Every version, newest first.
    pub references: Vec<ReferenceRow>,
}

const LIST: &str = "
    SELECT w.name, w.created_at,
           (SELECT version  FROM reference r WHERE r.waypoint_id = w.id ORDER BY version DESC LIMIT 1),
           (SELECT taken_at FROM reference r WHERE r.waypoint_id = w.id ORDER BY version DESC LIMIT 1),
           (SELECT verdict  FROM visit v WHERE v.waypoint_id = w.id ORDER BY id DESC LIMIT 1),
           (SELECT at       FROM visit v WHERE v.waypoint_id = w.id ORDER BY id DESC LIMIT 1),
           (SELECT d_gmm    FROM visit v WHERE v.waypoint_id = w.id ORDER BY id DESC LIMIT 1),
           (SELECT count(*) FROM alarm a WHERE a.waypoint_id = w.id AND a.state <> 'cleared')
    FROM waypoint w WHERE w.forgotten_at IS NULL";

impl Store {
    /// All waypoints that are not forgotten, by name.
    ///
    /// # Errors
    /// The database fails.
    pub fn waypoints(&self) -> Result<Vec<WaypointRow>, StoreError> {
        self.query(|db| {
            let mut query = db.prepare(&format!("{LIST} ORDER BY w.name"))?;
            let rows = query.query_map([], read_row)?;
            Ok(rows.collect::<Result<_, _>>()?)
        })
    }

    /// One waypoint with its reference versions.
    ///
    /// # Errors
    /// No such waypoint.
    pub fn waypoint(&self, name: &str) -> Result<WaypointDetail, StoreError> {
        self.query(|db| {
            let id = waypoint_id(db, name)?;
            let row = db.query_row(&format!("{LIST} AND w.id = ?1"), [id], read_row)?;
            let references = reference_rows(db, id)?;
            Ok(WaypointDetail { row, references })
        })
    }

    /// Forgets a waypoint and clears its alarms. Its visits and alarms stay in the log.
    ///
    /// # Errors
    /// No such waypoint.
    pub fn forget_waypoint(&mut self, name: &str, stamp: &RecordTime) -> Result<(), StoreError> {
        self.transaction(|change| {
            let id = waypoint_id(change, name)?;
            let at = stamp.to_rfc3339();
            change.execute(
                "UPDATE waypoint SET forgotten_at = ?2 WHERE id = ?1",
                params![id, at],
            )?;
            clear_all(change, id, &at, "waypoint forgotten")
        })
    }
}

fn read_row(row: &rusqlite::Row<'_>) -> rusqlite::Result<WaypointRow> {
    Ok(WaypointRow {
        name: row.get(0)?,
        created_at: row.get(1)?,
        reference_version: row.get(2)?,
        reference_taken_at: row.get(3)?,
        last_verdict: row.get(4)?,
        last_visit_at: row.get(5)?,
        last_d_gmm: row.get(6)?,
        standing_alarms: row.get(7)?,
    })
}
