//! Retention: old sweeps go by age and by size, never those that are alarm evidence or a reference.

use super::error::StoreError;
use super::handle::{Store, time_text};
use rusqlite::params;

/// How long and how much.
#[derive(Debug, Clone, Copy)]
pub struct Retention {
    /// Sweeps taken before this may go.
    pub older_than: Option<jiff::Timestamp>,
    /// Bytes of sweeps above which the oldest go.
    pub most_bytes: Option<u64>,
}

/// What went.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Swept {
    /// Sweeps whose files were deleted.
    pub sweeps: usize,
    /// Their bytes.
    pub bytes: u64,
}

struct Candidate {
    id: i64,
    old: bool,
    spare: bool,
    files: Vec<String>,
}

impl Store {
    /// Deletes the files of sweeps that retention lets go; their rows stay.
    ///
    /// # Errors
    /// The disk or the database refuses.
    pub fn retain(&mut self, retention: &Retention) -> Result<Swept, StoreError> {
        let candidates = self.kept_sweeps(retention)?;
        let size_of = |c: &Candidate| c.files.iter().map(|f| self.files.size(f)).sum::<u64>();
        let mut total: u64 = candidates.iter().map(size_of).sum();
        let mut swept = Swept::default();
        for candidate in &candidates {
            let too_much = retention.most_bytes.is_some_and(|most| total > most);
            if !candidate.spare || !(candidate.old || too_much) {
                continue;
            }
            // The row first: a row never speaks of a file that is gone.
            self.db.execute(
                "UPDATE sweep SET view_file = NULL, raw_file = NULL WHERE id = ?1",
                [candidate.id],
            )?;
            for file in &candidate.files {
                if !self.still_named(file)? {
                    let bytes = self.files.delete(file)?;
                    total = total.saturating_sub(bytes);
                    swept.bytes += bytes;
                }
            }
            swept.sweeps += 1;
        }
        Ok(swept)
    }

    fn kept_sweeps(&self, retention: &Retention) -> Result<Vec<Candidate>, StoreError> {
        let older_than = retention.older_than.map(time_text).unwrap_or_default();
        let mut query = self.db.prepare(
            "SELECT s.id, s.taken_at < ?1, s.view_file, s.raw_file,
                    NOT EXISTS (SELECT 1 FROM reference r WHERE r.sweep_id = s.id)
                    AND NOT EXISTS (SELECT 1 FROM visit v JOIN alarm a
                                    ON v.id IN (a.first_visit_id, a.last_visit_id) WHERE v.sweep_id = s.id)
             FROM sweep s WHERE s.view_file IS NOT NULL ORDER BY s.id",
        )?;
        let rows = query.query_map(params![older_than], |row| {
            let files: [Option<String>; 2] = [row.get(2)?, row.get(3)?];
            Ok(Candidate {
                id: row.get(0)?,
                old: row.get(1)?,
                spare: row.get(4)?,
                files: files.into_iter().flatten().collect(),
            })
        })?;
        Ok(rows.collect::<Result<_, _>>()?)
    }

    fn still_named(&self, file: &str) -> Result<bool, StoreError> {
        Ok(self.db.query_row(
            "SELECT EXISTS (SELECT 1 FROM sweep WHERE view_file = ?1 OR raw_file = ?1)",
            [file],
            |row| row.get(0),
        )?)
    }
}
