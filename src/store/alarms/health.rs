//! Health incidents: what keeps the watch from seeing, since when, and until when.

use super::super::connection::{RecordTime, Store, time_text};
use super::super::error::StoreError;
use super::super::events::insert_event;
use crate::patrol::severity::Severity;
use rusqlite::{Connection, Transaction, params};
use serde::Serialize;

/// Device under which the event log has the beginning and the end of each.
const EVENT_DEVICE: &str = "health";
/// Subjects of waypoints that were not visited begin so; their name follows.
const WAYPOINT_SUBJECT: &str = "waypoint ";

/// A health incident as stored.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HealthRow {
    /// Sequence number.
    pub id: i64,
    /// devices, sweep, clock, storage, or `waypoint NAME`.
    pub subject: String,
    /// What is wrong, as it was last reported; one line.
    pub reason: String,
    /// Since when, RFC 3339.
    pub since: String,
    /// The kernel's boot id when it began.
    pub boot_id: String,
    /// When it was over, RFC 3339.
    pub cleared_at: Option<String>,
}

/// The beginning or the end of a health incident, as the event log has it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HealthEvent {
    /// Info of the end.
    pub severity: Severity,
    /// Subject, and what is wrong or that it is over.
    pub text: String,
}

impl Store {
    /// Stores that something is wrong with `subject`, or that nothing is any more (`None`). What stands keeps its beginning and
    /// takes the new reason. The event log gets the beginning and the end, which are returned.
    ///
    /// # Errors
    /// The database fails.
    pub fn note_health(
        &mut self,
        subject: &str,
        reason: Option<&str>,
        stamp: &RecordTime,
    ) -> Result<Option<HealthEvent>, StoreError> {
        self.transaction(|change| note(change, subject, reason, stamp))
    }

    /// Notes the waypoints that nobody visited or taught since `before`; `None`: none is expected to be. Returns what began and
    /// what ended.
    ///
    /// # Errors
    /// The database fails.
    pub fn note_unseen(
        &mut self,
        before: Option<jiff::Timestamp>,
        stamp: &RecordTime,
    ) -> Result<Vec<HealthEvent>, StoreError> {
        self.transaction(|change| {
            let mut events = Vec::new();
            let unseen = match before {
                Some(before) => unseen_since(change, &time_text(before))?,
                None => Vec::new(),
            };
            let standing = rows(change, "cleared_at IS NULL", -1)?;
            let is_unseen = |subject: &str| unseen.iter().any(|(name, _)| subject == *name);
            for row in standing {
                if row.subject.starts_with(WAYPOINT_SUBJECT) && !is_unseen(&row.subject) {
                    events.extend(note(change, &row.subject, None, stamp)?);
                }
            }
            for (subject, last) in &unseen {
                let reason = format!("not visited since {last}");
                events.extend(note(change, subject, Some(&reason), stamp)?);
            }
            Ok(events)
        })
    }

    /// Health incidents, newest first; `standing`: only those that are not over.
    ///
    /// # Errors
    /// The database fails.
    pub fn health(&self, standing: bool, limit: u32) -> Result<Vec<HealthRow>, StoreError> {
        let condition = if standing {
            "cleared_at IS NULL"
        } else {
            "TRUE"
        };
        self.query(|db| rows(db, condition, i64::from(limit)))
    }
}

fn note(
    change: &Transaction<'_>,
    subject: &str,
    reason: Option<&str>,
    stamp: &RecordTime,
) -> Result<Option<HealthEvent>, StoreError> {
    let log = |severity, text: String| {
        insert_event(change, severity, EVENT_DEVICE, &text, stamp)?;
        Ok(Some(HealthEvent { severity, text }))
    };
    let Some(reason) = reason else {
        let over = change.execute(
            "UPDATE health SET cleared_at = ?2 WHERE subject = ?1 AND cleared_at IS NULL",
            params![subject, stamp.to_rfc3339()],
        )?;
        if over > 0 {
            return log(Severity::Info, format!("{subject}: over"));
        }
        return Ok(None);
    };
    let standing = change.execute(
        "UPDATE health SET reason = ?2 WHERE subject = ?1 AND cleared_at IS NULL",
        params![subject, reason],
    )?;
    if standing == 0 {
        change.execute(
            "INSERT INTO health (subject, reason, since, boot_id) VALUES (?1, ?2, ?3, ?4)",
            params![subject, reason, stamp.to_rfc3339(), stamp.boot_id],
        )?;
        return log(Severity::Warning, format!("{subject}: {reason}"));
    }
    Ok(None)
}

/// Subjects of waypoints that were last visited or taught before this, with when that was.
fn unseen_since(db: &Connection, before: &str) -> Result<Vec<(String, String)>, StoreError> {
    let mut query = db.prepare(
        "SELECT name, last FROM (
             SELECT w.name, max(coalesce((SELECT max(at) FROM visit v WHERE v.waypoint_id = w.id), ''),
                                coalesce((SELECT max(s.taken_at) FROM sweep s JOIN reference r ON r.sweep_id = s.id
                                          WHERE r.waypoint_id = w.id), ''), w.created_at) AS last
             FROM waypoint w WHERE w.forgotten_at IS NULL)
         WHERE last < ?1 ORDER BY name",
    )?;
    let rows = query.query_map([before], |row| {
        let name: String = row.get(0)?;
        Ok((format!("{WAYPOINT_SUBJECT}{name}"), row.get(1)?))
    })?;
    Ok(rows.collect::<Result<_, _>>()?)
}

fn rows(db: &Connection, condition: &str, limit: i64) -> Result<Vec<HealthRow>, StoreError> {
    let mut query = db.prepare(&format!(
        "SELECT id, subject, reason, since, boot_id, cleared_at FROM health WHERE {condition} ORDER BY id DESC LIMIT ?1"
    ))?;
    let rows = query.query_map([limit], |row| {
        Ok(HealthRow {
            id: row.get(0)?,
            subject: row.get(1)?,
            reason: row.get(2)?,
            since: row.get(3)?,
            boot_id: row.get(4)?,
            cleared_at: row.get(5)?,
        })
    })?;
    Ok(rows.collect::<Result<_, _>>()?)
}
