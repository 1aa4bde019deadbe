//! The alarm log: alarms are raised, extended, acknowledged, cleared and listed.

mod answers;
mod filter;

pub use filter::{AlarmFilter, FloorPlace, NearFilter, ThingFilter};

use super::connection::{RecordTime, Store};
use super::error::StoreError;
use super::novelties::{novelties, to_sighting};
use super::time_range::is_clock_unset;
use super::visit_log::ground_of;
use crate::alarm::{AlarmAnswer, Incident};
use answers::{insert_answer, newest_answer};
use patrold_engine::report::NoveltyRecord;
use rusqlite::{Connection, OptionalExtension, Transaction, params};
use serde::Serialize;

/// An alarm with its first visit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AlarmRow {
    /// Number of the alarm.
    pub id: i64,
    /// Name of the waypoint.
    pub waypoint: String,
    /// open, acknowledged or cleared.
    pub state: String,
    /// When it was raised, RFC 3339.
    pub raised_at: String,
    /// When its change was last seen, RFC 3339.
    pub last_seen_at: String,
    /// Whether one of these stamps comes from a clock that was not set.
    pub clock_unset: bool,
    /// Number of visits that saw the change.
    pub visits: i64,
    /// The kernel's boot id when it was raised.
    pub boot_id: String,
    /// d_GMM of the visit that raised it.
    pub d_gmm: Option<f64>,
    /// U_th then in force.
    pub u_th: Option<f64>,
    /// Ground distance of both: w2 or euclid (metres), fm (no unit); `None` for visits of older versions.
    pub ground: Option<String>,
    /// Reason of that verdict.
    pub reason: String,
    /// Sequence number of that visit.
    pub visit_id: i64,
    /// Frame of the novelties: NAME/VERSION of the reference.
    pub frame: String,
    /// Novelties of that visit.
    pub novelties: Vec<NoveltyRecord>,
    /// When it was acknowledged, RFC 3339.
    pub acknowledged_at: Option<String>,
    /// Who acknowledged it.
    pub acknowledged_by: Option<String>,
    /// Notes, one line each.
    pub note: Option<String>,
    /// What a guard said: confirmed or false_alarm; `None`: nothing yet.
    pub answer: Option<String>,
    /// When it was cleared, RFC 3339.
    pub cleared_at: Option<String>,
    /// Why it was cleared.
    pub cleared_because: Option<String>,
}

const SELECT: &str = "
    SELECT a.id, w.name, a.state, a.raised_at, a.last_seen_at, a.visits, a.boot_id, v.d_gmm, v.u_th, v.reason,
           v.id, r.version, a.acknowledged_at, a.acknowledged_by, a.note, a.cleared_at, a.cleared_because, v.engine
    FROM alarm a JOIN waypoint w ON w.id = a.waypoint_id
    JOIN visit v ON v.id = a.first_visit_id
    LEFT JOIN reference r ON r.id = v.reference_id";

impl Store {
    /// Alarms that match, newest first.
    ///
    /// # Errors
    /// A waypoint name that the log does not know, or the database fails.
    pub fn alarms(&self, filter: &AlarmFilter) -> Result<Vec<AlarmRow>, StoreError> {
        self.query(|db| {
            let ids = filter.matching_ids(db)?;
            ids.into_iter().map(|id| find_alarm(db, id)).collect()
        })
    }

    /// The alarm with this number.
    ///
    /// # Errors
    /// No such alarm.
    pub fn alarm(&self, id: i64) -> Result<AlarmRow, StoreError> {
        self.query(|db| find_alarm(db, id))
    }

    /// Acknowledges an alarm. The first name stays; notes of later ones are appended with their names. A cleared alarm
    /// stays cleared.
    ///
    /// # Errors
    /// No such alarm.
    pub fn acknowledge(
        &mut self,
        id: i64,
        by: &str,
        note: Option<&str>,
        stamp: &RecordTime,
    ) -> Result<AlarmRow, StoreError> {
        self.transaction_with_reserve(|change| {
            let before = find_alarm(change, id)?;
            let is_first = before.acknowledged_at.is_none();
            let added = note.map(|text| {
                if is_first {
                    text.to_owned()
                } else {
                    format!("{by}: {text}")
                }
            });
            let notes: Vec<String> = before.note.into_iter().chain(added).collect();
            let note = (!notes.is_empty()).then(|| notes.join("\n"));
            change.execute(
                "UPDATE alarm SET state = CASE state WHEN 'open' THEN 'acknowledged' ELSE state END,
                                  acknowledged_at = coalesce(acknowledged_at, ?2),
                                  acknowledged_by = coalesce(acknowledged_by, ?3), note = ?4
                 WHERE id = ?1",
                params![id, stamp.to_rfc3339(), by, note],
            )?;
            find_alarm(change, id)
        })
    }

    /// Keeps what a guard says about an alarm. The newest answer counts.
    ///
    /// # Errors
    /// No such alarm.
    pub fn answer_alarm(
        &mut self,
        id: i64,
        answer: AlarmAnswer,
        by: &str,
        stamp: &RecordTime,
    ) -> Result<AlarmRow, StoreError> {
        self.transaction_with_reserve(|change| {
            find_alarm(change, id)?;
            insert_answer(change, id, answer, by, stamp)?;
            find_alarm(change, id)
        })
    }
}

fn find_alarm(db: &Connection, id: i64) -> Result<AlarmRow, StoreError> {
    let mut query = db.prepare_cached(&format!("{SELECT} WHERE a.id = ?1"))?;
    let row = query.query_row([id], read_row).optional()?;
    with_novelties(db, row.ok_or(StoreError::UnknownAlarm(id))?)
}

fn with_novelties(db: &Connection, mut alarm: AlarmRow) -> Result<AlarmRow, StoreError> {
    alarm.novelties = novelties(db, "visit_id = ?1", alarm.visit_id)?;
    alarm.answer = newest_answer(db, alarm.id)?;
    Ok(alarm)
}

fn read_row(row: &rusqlite::Row<'_>) -> rusqlite::Result<AlarmRow> {
    let waypoint: String = row.get(1)?;
    let version: Option<i64> = row.get(11)?;
    let frame = match version {
        Some(version) => format!("{waypoint}/{version}"),
        None => waypoint.clone(),
    };
    let [raised_at, last_seen_at]: [String; 2] = [row.get(3)?, row.get(4)?];
    Ok(AlarmRow {
        id: row.get(0)?,
        waypoint,
        state: row.get(2)?,
        clock_unset: is_clock_unset(&raised_at) || is_clock_unset(&last_seen_at),
        raised_at,
        last_seen_at,
        visits: row.get(5)?,
        boot_id: row.get(6)?,
        d_gmm: row.get(7)?,
        u_th: row.get(8)?,
        ground: ground_of(&row.get::<_, String>(17)?),
        reason: row.get(9)?,
        visit_id: row.get(10)?,
        frame,
        novelties: Vec::new(),
        acknowledged_at: row.get(12)?,
        acknowledged_by: row.get(13)?,
        note: row.get(14)?,
        answer: None,
        cleared_at: row.get(15)?,
        cleared_because: row.get(16)?,
    })
}

/// The alarms of a waypoint that are not cleared, with what their first and last visit saw.
pub(super) fn standing(db: &Connection, waypoint_id: i64) -> Result<Vec<Incident>, StoreError> {
    let mut query = db.prepare(
        "SELECT id FROM alarm WHERE waypoint_id = ?1 AND state <> 'cleared' ORDER BY id",
    )?;
    let ids: Vec<i64> = query
        .query_map([waypoint_id], |row| row.get(0))?
        .collect::<Result<_, _>>()?;
    let condition = "visit_id IN (SELECT first_visit_id FROM alarm WHERE id = ?1
                 UNION SELECT last_visit_id FROM alarm WHERE id = ?1)";
    let incident = |id: i64| {
        let seen = novelties(db, condition, id)?;
        let sightings = seen.iter().map(to_sighting).collect();
        Ok(Incident { id, sightings })
    };
    ids.into_iter().map(incident).collect()
}

pub(super) fn raise(
    change: &Transaction<'_>,
    waypoint_id: i64,
    visit_id: i64,
    stamp: &RecordTime,
) -> Result<i64, StoreError> {
    change.execute(
        "INSERT INTO alarm (waypoint_id, raised_at, boot_id, first_visit_id, last_visit_id, last_seen_at, state)
         VALUES (?1, ?2, ?3, ?4, ?4, ?2, 'open')",
        params![waypoint_id, stamp.to_rfc3339(), stamp.boot_id, visit_id],
    )?;
    let id = change.last_insert_rowid();
    link_visit(change, id, visit_id)?;
    Ok(id)
}

pub(super) fn extend(
    change: &Transaction<'_>,
    id: i64,
    visit_id: i64,
    stamp: &RecordTime,
) -> Result<(), StoreError> {
    change.execute(
        "UPDATE alarm SET last_visit_id = ?2, last_seen_at = ?3, visits = visits + 1 WHERE id = ?1",
        params![id, visit_id, stamp.to_rfc3339()],
    )?;
    link_visit(change, id, visit_id)
}

/// Makes a visit evidence of an alarm.
fn link_visit(change: &Transaction<'_>, id: i64, visit_id: i64) -> Result<(), StoreError> {
    change.execute(
        "UPDATE visit SET alarm_id = ?2 WHERE id = ?1",
        params![visit_id, id],
    )?;
    Ok(())
}

pub(super) fn clear(db: &Connection, id: i64, at: &str, because: &str) -> Result<(), StoreError> {
    db.execute(
        "UPDATE alarm SET state = 'cleared', cleared_at = ?2, cleared_because = ?3 WHERE id = ?1",
        params![id, at, because],
    )?;
    Ok(())
}

/// Clears all alarms of a waypoint.
pub(super) fn clear_all(
    db: &Connection,
    waypoint_id: i64,
    at: &str,
    because: &str,
) -> Result<(), StoreError> {
    db.execute(
        "UPDATE alarm SET state = 'cleared', cleared_at = ?2, cleared_because = ?3
         WHERE waypoint_id = ?1 AND state <> 'cleared'",
        params![waypoint_id, at, because],
    )?;
    Ok(())
}
