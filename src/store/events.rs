//! The event log: devices lost and found, sweeps refused, restarts.

use super::connection::{RecordTime, Store};
use super::error::StoreError;
use crate::patrol::severity::Severity;
use rusqlite::{Transaction, params};
use serde::Serialize;

/// An event as stored.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EventRow {
    /// Sequence number.
    pub id: i64,
    /// RFC 3339.
    pub at: String,
    /// info, warning or error.
    pub level: String,
    /// laser, ptu or service.
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

    /// The newest events, newest first.
    ///
    /// # Errors
    /// The database fails.
    pub fn events(&self, limit: u32) -> Result<Vec<EventRow>, StoreError> {
        self.query(|db| {
            let mut query = db.prepare(
                "SELECT id, at, level, device, text FROM event ORDER BY id DESC LIMIT ?1",
            )?;
            let rows = query.query_map([limit], |row| {
                Ok(EventRow {
                    id: row.get(0)?,
                    at: row.get(1)?,
                    level: row.get(2)?,
                    device: row.get(3)?,
                    text: row.get(4)?,
                })
            })?;
            Ok(rows.collect::<Result<_, _>>()?)
        })
    }
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
