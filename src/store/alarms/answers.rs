//! What guards say about alarms: the labels that thresholds are tuned by. Every answer is kept; the newest counts.

use crate::alarm::AlarmAnswer;
use crate::store::connection::RecordTime;
use crate::store::error::StoreError;
use rusqlite::{Connection, OptionalExtension, Transaction, params};

pub(super) fn insert_answer(
    change: &Transaction<'_>,
    alarm_id: i64,
    answer: AlarmAnswer,
    by: &str,
    stamp: &RecordTime,
) -> Result<(), StoreError> {
    change.execute(
        "INSERT INTO alarm_answer (alarm_id, at, boot_id, answer, answered_by) VALUES (?1, ?2, ?3, ?4, ?5)",
        params![alarm_id, stamp.to_rfc3339(), stamp.boot_id, answer.as_str(), by],
    )?;
    Ok(())
}

/// The answer that counts.
pub(super) fn newest_answer(db: &Connection, alarm_id: i64) -> Result<Option<String>, StoreError> {
    let mut query = db.prepare_cached(
        "SELECT answer FROM alarm_answer WHERE alarm_id = ?1 ORDER BY id DESC LIMIT 1",
    )?;
    Ok(query.query_row([alarm_id], |row| row.get(0)).optional()?)
}
