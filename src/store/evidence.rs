//! The evidence of a visit: the files of its sweep, written after its row. The row says whether they are there, and why not.

use super::connection::Store;
use super::error::StoreError;
use super::sweeps::SweepFiles;
use rusqlite::{OptionalExtension, params};

impl Store {
    /// Writes the files of a sweep whose row is on disk, and then that they are there, or why they are not.
    ///
    /// # Errors
    /// The disk fails, or what is left of it is kept for alarms.
    pub(super) fn write_evidence(
        &mut self,
        sweep_id: i64,
        files: &SweepFiles,
    ) -> Result<(), StoreError> {
        let written = self
            .check_space(files.bytes())
            .and_then(|()| files.write(&self.files));
        let (state, why) = match &written {
            Ok(()) => ("stored", None),
            Err(error) => ("missing", Some(error.to_string())),
        };
        // Where this fails the row says `pending`, which the next start settles.
        let marked = self.mark_evidence(sweep_id, state, why.as_deref());
        written.and(marked)
    }

    /// As [`write_evidence`](Self::write_evidence), for a sweep that an earlier attempt left without its files. Nothing is
    /// written if retention dropped the sweep meanwhile.
    pub(super) fn write_evidence_again(
        &mut self,
        sweep_id: i64,
        files: &SweepFiles,
    ) -> Result<(), StoreError> {
        let wanted = self.query(|db| {
            let row = db.query_row(
                "SELECT view_file IS NOT NULL OR raw_file IS NOT NULL FROM sweep WHERE id = ?1",
                [sweep_id],
                |row| row.get(0),
            );
            Ok(row.optional()?.unwrap_or(false))
        })?;
        if !wanted {
            return Ok(());
        }
        self.write_evidence(sweep_id, files)
    }

    /// Settles the sweeps whose files were being written when the last writer stopped. Only for the holder of the service's
    /// lock, before it writes. Returns how many have no files.
    ///
    /// # Errors
    /// The database fails.
    pub fn settle_evidence(&mut self) -> Result<usize, StoreError> {
        let pending = self.query(|db| {
            let mut query = db.prepare(
                "SELECT id, view_file, raw_file FROM sweep WHERE evidence = 'pending' ORDER BY id",
            )?;
            let rows = query.query_map([], |row| {
                let files: [Option<String>; 2] = [row.get(1)?, row.get(2)?];
                Ok((row.get::<_, i64>(0)?, files))
            })?;
            Ok(rows.collect::<Result<Vec<_>, _>>()?)
        })?;
        let mut missing = 0;
        for (id, files) in pending {
            let unread = files
                .iter()
                .flatten()
                .find_map(|file| self.files.get(file).err());
            let (state, why) = match &unread {
                None => ("stored", None),
                // The disk did not let it be read now: the next start settles it.
                Some(error) if !error.is_of_the_file() => continue,
                Some(_) => ("missing", Some("patrold was stopped before it was written")),
            };
            self.mark_evidence(id, state, why)?;
            missing += usize::from(unread.is_some());
        }
        Ok(missing)
    }

    pub(super) fn mark_evidence(
        &mut self,
        sweep_id: i64,
        state: &str,
        why: Option<&str>,
    ) -> Result<(), StoreError> {
        self.check_space(0)?;
        self.write(|change| {
            change.execute(
                "UPDATE sweep SET evidence = ?2, evidence_why = ?3 WHERE id = ?1",
                params![sweep_id, state, why],
            )?;
            Ok(())
        })
    }
}
