//! The evidence of a visit: the files of its sweep, written after its row. The row says whether they are there, and why not.

use super::connection::Store;
use super::error::StoreError;
use super::sweeps::SweepFiles;
use rusqlite::{OptionalExtension, params};

/// Why files of a sweep are not there; `None`: they are.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct EvidenceGaps {
    pub(super) view_and_raw: Option<String>,
    pub(super) dialogue: Option<String>,
}

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
        // By itself: a sweep is judged again without it.
        let kept = self
            .check_space(files.dialogue_bytes())
            .and_then(|()| files.write_dialogue(&self.files));
        let text = |done: &Result<(), StoreError>| done.as_ref().err().map(ToString::to_string);
        let evidence = EvidenceGaps {
            view_and_raw: text(&written),
            dialogue: text(&kept),
        };
        // Where this fails the row says `pending`, which the next start settles.
        let marked = self.mark_evidence(sweep_id, &evidence);
        written.and(kept).and(marked)
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
                "SELECT view_file IS NOT NULL OR raw_file IS NOT NULL OR dialogue_file IS NOT NULL
                 FROM sweep WHERE id = ?1",
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
                "SELECT id, view_file, raw_file, dialogue_file FROM sweep WHERE evidence = 'pending' ORDER BY id",
            )?;
            let rows = query.query_map([], |row| {
                let files: [Option<String>; 2] = [row.get(1)?, row.get(2)?];
                Ok((row.get::<_, i64>(0)?, files, row.get(3)?))
            })?;
            Ok(rows.collect::<Result<Vec<_>, _>>()?)
        })?;
        let mut missing = 0;
        for (id, files, dialogue) in pending {
            let dialogue: Option<String> = dialogue;
            let unread = |file: &String| self.files.get(file).err();
            let errors = [
                files.iter().flatten().find_map(unread),
                dialogue.iter().find_map(unread),
            ];
            // The disk did not let it be read now: the next start settles it.
            if errors.iter().flatten().any(|error| !error.is_of_the_file()) {
                continue;
            }
            let stopped = "patrold was stopped before it was written".to_owned();
            let [view_and_raw, dialogue] = errors.map(|error| error.map(|_| stopped.clone()));
            missing += usize::from(view_and_raw.is_some() || dialogue.is_some());
            let evidence = EvidenceGaps {
                view_and_raw,
                dialogue,
            };
            self.mark_evidence(id, &evidence)?;
        }
        Ok(missing)
    }

    pub(super) fn mark_evidence(
        &mut self,
        sweep_id: i64,
        evidence: &EvidenceGaps,
    ) -> Result<(), StoreError> {
        let state = match evidence.view_and_raw {
            None => "stored",
            Some(_) => "missing",
        };
        self.check_space(0)?;
        self.write(|change| {
            change.execute(
                "UPDATE sweep SET evidence = ?2, evidence_why = ?3,
                                  dialogue_why = iif(dialogue_file IS NULL, dialogue_why, ?4)
                 WHERE id = ?1",
                params![sweep_id, state, evidence.view_and_raw, evidence.dialogue],
            )?;
            Ok(())
        })
    }
}
