//! Retention: old sweeps go by age and by size, never those that are evidence of an alarm or a reference in use.
//!
//! Evidence is every sweep whose visit belongs to an alarm, and the reference it was compared with. References of
//! a known waypoint stay, all versions; those of a forgotten one go by age unless they are evidence. The size
//! limit counts what may go by size alone: evidence never pushes out the rest.

use super::error::StoreError;
use super::handle::{Store, time_text};
use rusqlite::params;
use std::collections::{BTreeMap, BTreeSet};

/// How long and how much.
#[derive(Debug, Clone, Copy)]
pub struct Retention {
    /// Sweeps taken before this may go.
    pub older_than: Option<jiff::Timestamp>,
    /// Bytes of those sweeps that may go above which the oldest of them go.
    pub most_bytes: Option<u64>,
}

/// What went.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Swept {
    /// Sweeps whose files were deleted; with orphans, files.
    pub sweeps: usize,
    /// Their bytes.
    pub bytes: u64,
}

/// What may become of a sweep.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Hold {
    /// Nothing needs it.
    Spare,
    /// A reference of a forgotten waypoint: goes by age alone.
    Age,
    /// Evidence, or a reference of a known waypoint.
    Fast,
}

struct KeptSweep {
    id: i64,
    old: bool,
    hold: Hold,
    files: Vec<String>,
}

impl Store {
    /// Deletes the files of sweeps that retention lets go; their rows stay.
    ///
    /// # Errors
    /// The disk or the database refuses.
    pub fn retain(&mut self, retention: &Retention) -> Result<Swept, StoreError> {
        let sweeps = self.kept_sweeps(retention)?;
        let held = |s: &&KeptSweep| s.hold != Hold::Spare;
        let held: BTreeSet<&String> = sweeps.iter().filter(held).flat_map(|s| &s.files).collect();
        let spare: BTreeMap<&String, u64> = sweeps
            .iter()
            .flat_map(|s| &s.files)
            .filter(|file| !held.contains(file))
            .map(|file| (file, self.files.size(file)))
            .collect();
        let mut total: u64 = spare.values().sum();
        let mut swept = Swept::default();
        for sweep in &sweeps {
            let too_much = retention.most_bytes.is_some_and(|most| total > most);
            let goes = match sweep.hold {
                Hold::Spare => sweep.old || too_much,
                Hold::Age => sweep.old,
                Hold::Fast => false,
            };
            if !goes {
                continue;
            }
            // The row first: a row never speaks of a file that is gone.
            let free = self.change(|change| {
                change.execute(
                    "UPDATE sweep SET view_file = NULL, raw_file = NULL WHERE id = ?1",
                    [sweep.id],
                )?;
                let mut named = change.prepare(
                    "SELECT EXISTS (SELECT 1 FROM sweep WHERE view_file = ?1)
                     OR EXISTS (SELECT 1 FROM sweep WHERE raw_file = ?1)",
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
                swept.bytes += self.files.delete(file)?;
                total = total.saturating_sub(spare.get(file).copied().unwrap_or_default());
            }
            swept.sweeps += 1;
        }
        Ok(swept)
    }

    /// Deletes what a stop in the middle of writing left behind: half-written files and files that no row names.
    /// Only for the one that holds the service's lock, before it writes.
    ///
    /// # Errors
    /// The disk or the database refuses.
    pub fn sweep_orphans(&mut self) -> Result<Swept, StoreError> {
        let named: BTreeSet<String> = self.read(|db| {
            let mut query = db.prepare(
                "SELECT view_file FROM sweep WHERE view_file IS NOT NULL
                 UNION SELECT raw_file FROM sweep WHERE raw_file IS NOT NULL",
            )?;
            let rows = query.query_map([], |row| row.get(0))?;
            Ok(rows.collect::<Result<_, _>>()?)
        })?;
        let mut swept = Swept::default();
        for name in self.files.names()? {
            if !named.contains(&name) {
                swept.bytes += self.files.delete(&name)?;
                swept.sweeps += 1;
            }
        }
        Ok(swept)
    }

    fn kept_sweeps(&self, retention: &Retention) -> Result<Vec<KeptSweep>, StoreError> {
        let older_than = retention.older_than.map(time_text).unwrap_or_default();
        self.read(|db| {
            let mut query = db.prepare(
                "SELECT s.id, s.taken_at < ?1, s.view_file, s.raw_file,
                        EXISTS (SELECT 1 FROM visit v WHERE v.sweep_id = s.id AND v.alarm_id IS NOT NULL)
                        OR EXISTS (SELECT 1 FROM reference r JOIN visit v ON v.reference_id = r.id
                                   WHERE r.sweep_id = s.id AND v.alarm_id IS NOT NULL)
                        OR EXISTS (SELECT 1 FROM reference r JOIN waypoint w ON w.id = r.waypoint_id
                                   WHERE r.sweep_id = s.id AND w.forgotten_at IS NULL),
                        EXISTS (SELECT 1 FROM reference r WHERE r.sweep_id = s.id)
                 FROM sweep s WHERE s.view_file IS NOT NULL OR s.raw_file IS NOT NULL ORDER BY s.id",
            )?;
            let rows = query.query_map(params![older_than], |row| {
                let files: [Option<String>; 2] = [row.get(2)?, row.get(3)?];
                let hold = match (row.get(4)?, row.get(5)?) {
                    (true, _) => Hold::Fast,
                    (false, true) => Hold::Age,
                    (false, false) => Hold::Spare,
                };
                Ok(KeptSweep {
                    id: row.get(0)?,
                    old: row.get(1)?,
                    hold,
                    files: files.into_iter().flatten().collect(),
                })
            })?;
            Ok(rows.collect::<Result<_, _>>()?)
        })
    }
}
