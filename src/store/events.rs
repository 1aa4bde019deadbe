//! The event log: devices lost and found, sweeps refused, restarts.

use super::connection::{RecordTime, Store};
use super::error::StoreError;
use super::newest::{Conditions, newest_ids};
use super::time_range::{TimeRange, is_clock_unset};
use crate::patrol::severity::Severity;
use rusqlite::{Transaction, params};
use serde::Serialize;

/// Which events to list; `None`: any. A number is the newest so many.
#[derive(Debug, Clone)]
pub struct EventFilter {
    /// When they were.
    pub range: TimeRange,
    /// How bad.
    pub severity: Option<Severity>,
    /// laser, ptu, devices, service, store or health.
    pub device: Option<String>,
    /// The newest N.
    pub limit: u32,
}

impl From<u32> for EventFilter {
    fn from(limit: u32) -> Self {
        Self {
            range: TimeRange::default(),
            severity: None,
            device: None,
            limit,
        }
    }
}

/// An event as stored.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EventRow {
    /// Sequence number.
    pub id: i64,
    /// RFC 3339.
    pub at: String,
    /// Whether that stamp comes from a clock that was not set.
    pub clock_unset: bool,
    /// info, warning or error.
    pub level: String,
    /// laser, ptu, devices, service, store or health.
    pub device: String,
    /// What happened.
    pub text: String,
}

impl Store {
    /// Stores an event.
    ///
    /// # Errors
    /// The database fails.
    pub fn note_event(
        &mut self,
        severity: Severity,
        device: &str,
        text: &str,
        stamp: &RecordTime,
    ) -> Result<(), StoreError> {
        self.transaction(|change| insert_event(change, severity, device, text, stamp))
    }

    /// Events that match, newest first.
    ///
    /// # Errors
    /// The database fails.
    pub fn events(&self, filter: impl Into<EventFilter>) -> Result<Vec<EventRow>, StoreError> {
        let filter = filter.into();
        let mut conditions = Conditions::default();
        let level = filter.severity.map(|severity| severity.as_str().to_owned());
        conditions.require_some("level = ?", level);
        conditions.require_some("device = ?", filter.device);
        self.query(|db| {
            let ids = newest_ids(db, "event", &[conditions], &filter.range, filter.limit)?;
            let mut query =
                db.prepare_cached("SELECT id, at, level, device, text FROM event WHERE id = ?1")?;
            let rows = ids.iter().map(|id| query.query_row([id], read_row));
            Ok(rows.collect::<Result<_, _>>()?)
        })
    }
}

fn read_row(row: &rusqlite::Row<'_>) -> rusqlite::Result<EventRow> {
    let at: String = row.get(1)?;
    Ok(EventRow {
        id: row.get(0)?,
        clock_unset: is_clock_unset(&at),
        at,
        level: row.get(2)?,
        device: row.get(3)?,
        text: row.get(4)?,
    })
}

pub(super) fn insert_event(
    change: &Transaction<'_>,
    severity: Severity,
    device: &str,
    text: &str,
    stamp: &RecordTime,
) -> Result<(), StoreError> {
    change.execute(
        "INSERT INTO event (at, boot_id, level, device, text) VALUES (?1, ?2, ?3, ?4, ?5)",
        params![
            stamp.to_rfc3339(),
            stamp.boot_id,
            severity.as_str(),
            device,
            text
        ],
    )?;
    Ok(())
}
