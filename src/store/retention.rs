//! Retention: deletes old sweeps by age and by total size.
//!
//! Evidence is a sweep whose visit belongs to an alarm, and the reference it was compared with; it is never deleted.
//! References of a known waypoint are kept, all versions; those of a forgotten one are deleted by age unless they are
//! evidence. Only sweeps that may be deleted by size count against the size limit.

use super::connection::{Store, time_text};
use super::error::StoreError;
use rusqlite::params;
use std::collections::{BTreeMap, BTreeSet};

/// Why the bytes of the devices are not there.
const DELETED: &str = "retention deleted them (store.keep_days, store.keep_gib)";

/// What is kept.
#[derive(Debug, Clone, Copy)]
pub struct Retention {
    /// Sweeps taken before this may be deleted.
    pub older_than: Option<jiff::Timestamp>,
    /// Total bytes of the deletable sweeps above which the oldest are deleted.
    pub max_bytes: Option<u64>,
    /// Files that no row names, written before this, are deleted.
    pub unnamed_older_than: Option<jiff::Timestamp>,
}

/// What was deleted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RetentionResult {
    /// Sweeps whose files were deleted; else files.
    pub sweeps: usize,
    /// Bytes freed.
    pub bytes: u64,
}

/// Whether a sweep may be deleted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Protection {
    /// By age and by size.
    None,
    /// By age only: a reference of a forgotten waypoint.
    UntilOld,
    /// Never: evidence, or a reference of a known waypoint.
    Always,
}

struct SweepEntry {
    id: i64,
    old: bool,
    protection: Protection,
    files: Vec<String>,
}

impl Store {
    /// Deletes the files of the sweeps that `retention` does not keep; their rows stay.
    ///
    /// # Errors
    /// The disk or the database fails.
    pub fn apply_retention(
        &mut self,
        retention: &Retention,
    ) -> Result<RetentionResult, StoreError> {
        let sweeps = self.sweep_entries(retention)?;
        let is_protected = |s: &&SweepEntry| s.protection != Protection::None;
        let protected: BTreeSet<&String> = sweeps
            .iter()
            .filter(is_protected)
            .flat_map(|s| &s.files)
            .collect();
        let deletable: BTreeMap<&String, u64> = sweeps
            .iter()
            .flat_map(|s| &s.files)
            .filter(|file| !protected.contains(file))
            .map(|file| (file, self.files.size(file)))
            .collect();
        let mut total: u64 = deletable.values().sum();
        let mut result = RetentionResult::default();
        for sweep in &sweeps {
            let too_much = retention.max_bytes.is_some_and(|max| total > max);
            let delete = match sweep.protection {
                Protection::None => sweep.old || too_much,
                Protection::UntilOld => sweep.old,
                Protection::Always => false,
            };
            if !delete {
                continue;
            }
            // The row first: no row names a file that is gone.
            let free = self.transaction(|change| {
                change.execute(
                    "UPDATE sweep SET view_file = NULL, raw_file = NULL, dialogue_file = NULL,
                                      dialogue_why = coalesce(dialogue_why, iif(dialogue_file IS NULL, NULL, ?2))
                     WHERE id = ?1",
                    params![sweep.id, DELETED],
                )?;
                let mut named = change.prepare(
                    "SELECT EXISTS (SELECT 1 FROM sweep WHERE view_file = ?1)
                     OR EXISTS (SELECT 1 FROM sweep WHERE raw_file = ?1)
                     OR EXISTS (SELECT 1 FROM sweep WHERE dialogue_file = ?1)",
                )?;
                let mut free = Vec::new();
                for file in &sweep.files {
                    if !named.query_row([file], |row| row.get(0))? {
                        free.push(file);
                    }
                }
                Ok(free)
            })?;
            for file in free {
                result.bytes += self.files.delete(file)?;
                total = total.saturating_sub(deletable.get(file).copied().unwrap_or_default());
            }
            result.sweeps += 1;
        }
        if let Some(time) = retention.unnamed_older_than {
            result.bytes += self.delete_unnamed(time)?;
        }
        Ok(result)
    }

    /// Not while the database is lost: its rows may name them again.
    fn delete_unnamed(&self, older_than: jiff::Timestamp) -> Result<u64, StoreError> {
        let mut bytes = 0;
        if self.is_lost()? {
            return Ok(bytes);
        }
        for name in self.unnamed_files()? {
            if self
                .files
                .written_at(&name)
                .is_some_and(|at| at < older_than)
            {
                bytes += self.files.delete(&name)?;
            }
        }
        Ok(bytes)
    }

    /// Deletes half-written files, left by a stop in the middle of writing. Only for the holder of the service's lock,
    /// before it writes. Returns how many, and their bytes.
    ///
    /// # Errors
    /// The disk fails.
    pub fn delete_half_written(&mut self) -> Result<RetentionResult, StoreError> {
        let mut result = RetentionResult::default();
        for name in self.files.half_written()? {
            result.bytes += self.files.delete(&name)?;
            result.sweeps += 1;
        }
        Ok(result)
    }

    /// Whole files that no row names: left by a stop before their row was written, or by a database that was lost. They
    /// are kept.
    ///
    /// # Errors
    /// The disk or the database fails.
    pub fn unnamed_files(&self) -> Result<Vec<String>, StoreError> {
        let named: BTreeSet<String> = self.query(|db| {
            let mut query = db.prepare(
                "SELECT view_file FROM sweep WHERE view_file IS NOT NULL
                 UNION SELECT raw_file FROM sweep WHERE raw_file IS NOT NULL
                 UNION SELECT dialogue_file FROM sweep WHERE dialogue_file IS NOT NULL",
            )?;
            let rows = query.query_map([], |row| row.get(0))?;
            Ok(rows.collect::<Result<_, _>>()?)
        })?;
        let mut files = self.files.names()?;
        files.retain(|name| !named.contains(name));
        Ok(files)
    }

    fn sweep_entries(&self, retention: &Retention) -> Result<Vec<SweepEntry>, StoreError> {
        let older_than = retention.older_than.map(time_text).unwrap_or_default();
        self.query(|db| {
            let mut query = db.prepare(
                "SELECT s.id, s.taken_at < ?1, s.view_file, s.raw_file, s.dialogue_file,
                        EXISTS (SELECT 1 FROM visit v WHERE v.sweep_id = s.id AND v.alarm_id IS NOT NULL)
                        OR EXISTS (SELECT 1 FROM reference r JOIN visit v ON v.reference_id = r.id
                                   WHERE r.sweep_id = s.id AND v.alarm_id IS NOT NULL)
                        OR EXISTS (SELECT 1 FROM reference r JOIN waypoint w ON w.id = r.waypoint_id
                                   WHERE r.sweep_id = s.id AND w.forgotten_at IS NULL),
                        EXISTS (SELECT 1 FROM reference r WHERE r.sweep_id = s.id)
                 FROM sweep s WHERE s.view_file IS NOT NULL OR s.raw_file IS NOT NULL OR s.dialogue_file IS NOT NULL
                 ORDER BY s.id",
            )?;
            let rows = query.query_map(params![older_than], |row| {
                let files: [Option<String>; 3] = [row.get(2)?, row.get(3)?, row.get(4)?];
                let hold = match (row.get(5)?, row.get(6)?) {
                    (true, _) => Protection::Always,
                    (false, true) => Protection::UntilOld,
                    (false, false) => Protection::None,
                };
                Ok(SweepEntry {
                    id: row.get(0)?,
                    old: row.get(1)?,
                    protection: hold,
                    files: files.into_iter().flatten().collect(),
                })
            })?;
            Ok(rows.collect::<Result<_, _>>()?)
        })
    }
}
