//! Waypoints: places with a name.

use super::error::StoreError;
use super::handle::{Stamp, Store};
use super::references::{ReferenceRow, references_of};
use rusqlite::{Connection, OptionalExtension, params};
use serde::Serialize;

/// One line of the list of waypoints.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WaypointRow {
    /// Its name.
    pub name: String,
    /// When it was first taught.
    pub created_at: String,
    /// Version of the reference in use.
    pub reference_version: Option<i64>,
    /// When that was taken.
    pub reference_taken_at: Option<String>,
    /// Verdict of the last visit.
    pub last_verdict: Option<String>,
    /// When that was.
    pub last_visit_at: Option<String>,
    /// Its distance, metres.
    pub last_d_gmm: Option<f64>,
    /// Alarms that are not cleared.
    pub standing_alarms: i64,
}

/// A waypoint with all its reference versions.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WaypointDetail {
    /// The line of the list.
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
    /// All waypoints by name.
    ///
    /// # Errors
    /// The database refuses.
    pub fn waypoints(&self) -> Result<Vec<WaypointRow>, StoreError> {
        self.read(|db| {
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
        self.read(|db| {
            let id = known_waypoint(db, name)?;
            let row = db.query_row(&format!("{LIST} AND w.id = ?1"), [id], read_row)?;
            let references = references_of(db, id)?;
            Ok(WaypointDetail { row, references })
        })
    }

    /// Forgets a waypoint: it is unknown from now on and its standing alarms are cleared; the log keeps what
    /// happened there.
    ///
    /// # Errors
    /// No such waypoint.
    pub fn forget_waypoint(&mut self, name: &str, stamp: &Stamp) -> Result<(), StoreError> {
        self.change(|change| {
            let id = known_waypoint(change, name)?;
            let at = stamp.text();
            change.execute(
                "UPDATE waypoint SET forgotten_at = ?2 WHERE id = ?1",
                params![id, at],
            )?;
            super::alarms::clear_standing(change, id, &at, "waypoint forgotten")
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

/// Id of a waypoint that is known.
pub(super) fn known_waypoint(db: &Connection, name: &str) -> Result<i64, StoreError> {
    if let Some(id) = find_waypoint(db, name)? {
        return Ok(id);
    }
    let known = names(db, "WHERE forgotten_at IS NULL")?;
    let name = name.to_owned();
    Err(StoreError::UnknownWaypoint { name, known })
}

/// Refuses a name that never was a waypoint's; a forgotten one is still in the log.
pub(super) fn named_in_log(db: &Connection, name: &str) -> Result<(), StoreError> {
    let sql = "SELECT EXISTS (SELECT 1 FROM waypoint WHERE name = ?1)";
    if db.query_row(sql, [name], |row| row.get(0))? {
        return Ok(());
    }
    let known = names(db, "")?;
    let name = name.to_owned();
    Err(StoreError::NotInLog { name, known })
}

/// Names of waypoints, for a message.
fn names(db: &Connection, which: &str) -> Result<String, StoreError> {
    let sql = format!("SELECT DISTINCT name FROM waypoint {which} ORDER BY name");
    let mut query = db.prepare(&sql)?;
    let names: Vec<String> = query
        .query_map([], |row| row.get(0))?
        .collect::<Result<_, _>>()?;
    Ok(if names.is_empty() {
        "none yet".to_owned()
    } else {
        names.join(", ")
    })
}

/// Id of a waypoint, if it is known.
pub(super) fn find_waypoint(db: &Connection, name: &str) -> rusqlite::Result<Option<i64>> {
    db.query_row(
        "SELECT id FROM waypoint WHERE name = ?1 AND forgotten_at IS NULL",
        [name],
        |row| row.get(0),
    )
    .optional()
}
