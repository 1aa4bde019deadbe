//! Health events: devices lost and found, sweeps refused, restarts.

use super::error::StoreError;
use super::handle::{Stamp, Store};
use rusqlite::params;
use serde::Serialize;

/// How bad.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// Good to know.
    Info,
    /// Worked around.
    Warning,
    /// Something was lost.
    Error,
}

impl Level {
    fn word(self) -> &'static str {
        match self {
            Self::Info => "info",
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }
}

/// One event.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EventRow {
    /// Its sequence number.
    pub id: i64,
    /// When.
    pub at: String,
    /// info, warning or error.
    pub level: String,
    /// laser, ptu or service.
    pub device: String,
    /// What happened.
    pub text: String,
}

impl Store {
    /// Notes an event.
    ///
    /// # Errors
    /// The database refuses.
    pub fn note_event(
        &mut self,
        level: Level,
        device: &str,
        text: &str,
        stamp: &Stamp,
    ) -> Result<(), StoreError> {
        self.change(|change| {
            change.execute(
                "INSERT INTO event (at, boot_id, level, device, text) VALUES (?1, ?2, ?3, ?4, ?5)",
                params![stamp.text(), stamp.boot_id, level.word(), device, text],
            )?;
            Ok(())
        })
    }

    /// The newest events, newest first.
    ///
    /// # Errors
    /// The database refuses.
    pub fn events(&self, limit: u32) -> Result<Vec<EventRow>, StoreError> {
        self.read(|db| {
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
