//! The alarm log: alarms are listed, acknowledged and answered; what visits do to them is in `incidents`.

mod answers;
mod filter;
pub(super) mod health;
pub(super) mod incidents;

pub use filter::{AlarmFilter, FloorPlace, NearFilter, ThingFilter};

use super::connection::{RecordTime, Store};
use super::error::StoreError;
use super::lookup::frame_name;
use super::novelties::read_novelty;
use super::time_range::is_clock_unset;
use super::visit_log::ground_of;
use crate::alarm::{AlarmAnswer, AlarmState};
use answers::{insert_answer, newest_answer};
use patrold_engine::report::NoveltyRecord;
use rusqlite::{Connection, OptionalExtension, params};
use serde::Serialize;

/// What one visit was to an alarm.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SightingRow {
    /// Sequence number of the visit.
    pub visit_id: i64,
    /// When it was, RFC 3339.
    pub at: String,
    /// raised, seen, moved, changed, gone or back.
    pub relation: String,
    /// Distance of the thing from where it was, metres.
    pub distance_m: Option<f64>,
    /// The thing's own part of that visit's d_GMM.
    pub contribution: Option<f64>,
}

/// The last visit that saw the thing of an alarm.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LastSighting {
    /// Sequence number of the visit.
    pub visit_id: i64,
    /// When it was, RFC 3339.
    pub at: String,
    /// raised, seen, moved, changed or back.
    pub relation: String,
    /// Distance of the thing from where it was, metres.
    pub distance_m: Option<f64>,
    /// d_GMM of that visit.
    pub d_gmm: Option<f64>,
    /// Frame of the novelties: NAME/VERSION of the reference.
    pub frame: String,
    /// The thing as that visit saw it; several in alarms of earlier versions.
    pub novelties: Vec<NoveltyRecord>,
}

/// An alarm: one thing, as the first and the last visit saw it.
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
    /// The thing as that visit saw it; several in alarms of earlier versions.
    pub novelties: Vec<NoveltyRecord>,
    /// Its own part of d_GMM when it was last seen.
    pub score: Option<f64>,
    /// The last visit that saw it.
    pub last_sighting: Option<LastSighting>,
    /// Since when no visit could see its place, RFC 3339; `None` where the last one could.
    pub unobserved_since: Option<String>,
    /// Every visit's part in it, the first first; in one alarm's details alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sightings: Option<Vec<SightingRow>>,
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
           v.id, coalesce(r.frame_version, r.version), a.acknowledged_at, a.acknowledged_by, a.note, a.cleared_at, a.cleared_because, v.engine,
           a.unobserved_since
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
        self.query(|db| find_with_sightings(db, id))
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
        self.acknowledge_and_answer(id, by, note, None, stamp)
    }

    /// As [`acknowledge`](Self::acknowledge), and keeps what a guard says about the alarm: both or nothing. The newest answer
    /// counts.
    ///
    /// # Errors
    /// No such alarm.
    pub fn acknowledge_and_answer(
        &mut self,
        id: i64,
        by: &str,
        note: Option<&str>,
        answer: Option<AlarmAnswer>,
        stamp: &RecordTime,
    ) -> Result<AlarmRow, StoreError> {
        self.transaction_with_reserve(|change| {
            let before = find_alarm(change, id)?;
            let is_first = before.acknowledged_at.is_none();
            // Open again since it was acknowledged: who does so now counts, who did is noted.
            let again = !is_first && before.state == AlarmState::Open.as_str();
            let earlier = before.acknowledged_at.zip(before.acknowledged_by);
            let earlier = earlier
                .filter(|_| again)
                .map(|(at, by)| format!("acknowledged {at} by {by}, open again later"));
            let added = note.map(|text| {
                if is_first || again {
                    text.to_owned()
                } else {
                    format!("{by}: {text}")
                }
            });
            let notes: Vec<String> = before.note.into_iter().chain(earlier).chain(added).collect();
            let note = (!notes.is_empty()).then(|| notes.join("\n"));
            change.execute(
                "UPDATE alarm SET state = CASE state WHEN 'open' THEN 'acknowledged' ELSE state END,
                                  acknowledged_at = iif(?5, ?2, coalesce(acknowledged_at, ?2)),
                                  acknowledged_by = iif(?5, ?3, coalesce(acknowledged_by, ?3)), note = ?4
                 WHERE id = ?1",
                params![id, stamp.to_rfc3339(), by, note, again],
            )?;
            if let Some(answer) = answer {
                insert_answer(change, id, answer, by, stamp)?;
            }
            find_with_sightings(change, id)
        })
    }
}

fn find_alarm(db: &Connection, id: i64) -> Result<AlarmRow, StoreError> {
    let mut query = db.prepare_cached(&format!("{SELECT} WHERE a.id = ?1"))?;
    let row = query.query_row([id], read_row).optional()?;
    with_things(db, row.ok_or(StoreError::UnknownAlarm(id))?)
}

fn find_with_sightings(db: &Connection, id: i64) -> Result<AlarmRow, StoreError> {
    let mut alarm = find_alarm(db, id)?;
    alarm.sightings = Some(sighting_rows(db, id)?);
    Ok(alarm)
}

/// Adds the thing as its first and its last visit saw it.
fn with_things(db: &Connection, mut alarm: AlarmRow) -> Result<AlarmRow, StoreError> {
    alarm.novelties = things(db, alarm.id, alarm.visit_id)?;
    alarm.answer = newest_answer(db, alarm.id)?;
    let mut query = db.prepare_cached(
        "SELECT v.id, v.at, s.relation, s.distance_m, v.d_gmm, w.name, coalesce(r.frame_version, r.version)
             FROM sighting s JOIN visit v ON v.id = s.visit_id JOIN waypoint w ON w.id = v.waypoint_id
             LEFT JOIN reference r ON r.id = v.reference_id
             WHERE s.alarm_id = ?1 AND s.position IS NOT NULL ORDER BY s.id DESC LIMIT 1",
    )?;
    let last = query.query_row([alarm.id], |row| {
        Ok(LastSighting {
            visit_id: row.get(0)?,
            at: row.get(1)?,
            relation: row.get(2)?,
            distance_m: row.get(3)?,
            d_gmm: row.get(4)?,
            frame: frame_name(&row.get::<_, String>(5)?, row.get(6)?),
            novelties: Vec::new(),
        })
    });
    if let Some(mut last) = last.optional()? {
        last.novelties = things(db, alarm.id, last.visit_id)?;
        let score: f64 = last.novelties.iter().map(|n| n.contribution).sum();
        alarm.score = score.is_finite().then_some(score);
        alarm.last_sighting = Some(last);
    }
    Ok(alarm)
}

/// The things of an alarm as one visit saw them.
fn things(db: &Connection, alarm_id: i64, visit_id: i64) -> Result<Vec<NoveltyRecord>, StoreError> {
    let mut query = db.prepare_cached(
        "SELECT n.record, n.kind, n.x_m, n.y_m, n.z_m, n.points, n.mass, n.contribution
         FROM sighting s JOIN novelty n ON n.visit_id = s.visit_id AND n.position = s.position
         WHERE s.alarm_id = ?1 AND s.visit_id = ?2 ORDER BY n.position",
    )?;
    let rows = query.query_map([alarm_id, visit_id], read_novelty)?;
    Ok(rows.collect::<Result<_, _>>()?)
}

fn sighting_rows(db: &Connection, alarm_id: i64) -> Result<Vec<SightingRow>, StoreError> {
    let mut query = db.prepare(
        "SELECT v.id, v.at, s.relation, s.distance_m, n.contribution
         FROM sighting s JOIN visit v ON v.id = s.visit_id
         LEFT JOIN novelty n ON n.visit_id = s.visit_id AND n.position = s.position
         WHERE s.alarm_id = ?1 ORDER BY s.id",
    )?;
    let rows = query.query_map([alarm_id], |row| {
        Ok(SightingRow {
            visit_id: row.get(0)?,
            at: row.get(1)?,
            relation: row.get(2)?,
            distance_m: row.get(3)?,
            contribution: row.get(4)?,
        })
    })?;
    Ok(rows.collect::<Result<_, _>>()?)
}

fn read_row(row: &rusqlite::Row<'_>) -> rusqlite::Result<AlarmRow> {
    let waypoint: String = row.get(1)?;
    let frame = frame_name(&waypoint, row.get(11)?);
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
        score: None,
        last_sighting: None,
        unobserved_since: row.get(18)?,
        sightings: None,
        acknowledged_at: row.get(12)?,
        acknowledged_by: row.get(13)?,
        note: row.get(14)?,
        answer: None,
        cleared_at: row.get(15)?,
        cleared_because: row.get(16)?,
    })
}
