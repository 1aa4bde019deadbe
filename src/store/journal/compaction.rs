//! Compaction of the journal: the newest line of each row in a fresh file, which takes the place of the old one in one step.
//!
//! It goes on in slices between other writes, so that no visit waits long. Whatever fails, the old journal is as it was; what is
//! appended meanwhile goes to it, and is copied at the end. Damaged lines are kept: a check still reports them.

use super::super::connection::Store;
use super::super::disk::Disk;
use super::super::error::StoreError;
use super::line::JournalLine;
use super::newest_lines::NewestLines;
use std::io::{self, BufRead as _, BufReader, Read as _};
use std::path::{Path, PathBuf};

/// When the journal is compacted, and how much of it at a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CompactionLimits {
    /// A journal below this is left as it is.
    pub min_bytes: u64,
    /// Read in one step.
    pub slice_bytes: u64,
}

impl Default for CompactionLimits {
    /// A journal of 64 MiB has the rows of 10,000 visits (`patrold demo --state DIR`). A slice takes 0.1 s, and one is done
    /// every ten seconds: a gigabyte in an hour.
    fn default() -> Self {
        Self {
            min_bytes: 64 << 20,
            slice_bytes: 8 << 20,
        }
    }
}

/// Lengths of a journal that was compacted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CompactedJournal {
    /// Bytes before.
    pub before: u64,
    /// Bytes now.
    pub after: u64,
}

/// Compacts a journal step by step.
#[derive(Debug)]
pub(in crate::store) struct Compactor {
    limits: CompactionLimits,
    /// Length from which on it begins.
    begin_at: u64,
    running: Option<Compaction>,
    /// The new name is not on the medium yet.
    is_unsynced: bool,
}

#[derive(Debug)]
struct Compaction {
    phase: CompactionPhase,
    /// Bytes that are done.
    read: u64,
    /// Length of the journal when it began.
    end: u64,
}

#[derive(Debug)]
enum CompactionPhase {
    /// Which lines are the newest of their rows; offsets of damaged ones.
    Reading(NewestLines, Vec<u64>),
    /// Offsets of the lines to copy, the last first.
    Copying(Vec<u64>),
    /// What was appended since it began.
    CatchingUp,
}

impl Compactor {
    pub(in crate::store) fn new(limits: CompactionLimits) -> Self {
        Self {
            limits,
            begin_at: limits.min_bytes,
            running: None,
            is_unsynced: false,
        }
    }

    /// Gives up what is under way: its journal is another one now, or a half file is left of an earlier run.
    pub(in crate::store) fn reset(&mut self, store: &Store) {
        *self = Self::new(self.limits);
        let _ = store.disk.remove(&fresh_path(store));
    }

    /// The next step, where there is one. Returns what was compacted, once.
    ///
    /// # Errors
    /// The disk or the database fails; the journal is as it was, and it begins anew when the journal is longer.
    pub(in crate::store) fn step(
        &mut self,
        store: &mut Store,
    ) -> Result<Option<CompactedJournal>, StoreError> {
        let path = store.journal_path().to_owned();
        let disk = store.disk();
        if self.is_unsynced {
            sync_name(&*disk, &path)?;
            self.is_unsynced = false;
        }
        let length = std::fs::metadata(&path).map_or(0, |file| file.len());
        let Some(compaction) = &mut self.running else {
            // The fresh file is at most as long, and leaves to alarms what is kept for them.
            if length >= self.begin_at && store.check_space(length).is_ok() {
                self.running = Some(Compaction {
                    phase: CompactionPhase::Reading(NewestLines::default(), Vec::new()),
                    read: 0,
                    end: length,
                });
            }
            return Ok(None);
        };
        let fresh = fresh_path(store);
        let slice = self.limits.slice_bytes;
        let is_last = matches!(compaction.phase, CompactionPhase::CatchingUp)
            && length.saturating_sub(compaction.read) <= slice;
        let done = if is_last {
            compaction.finish(store, &fresh, &path).map(|()| true)
        } else {
            let done = compaction.slice(&*disk, &fresh, &path, length, slice);
            let error = |source| StoreError::File {
                path: path.clone(),
                source,
            };
            done.map(|()| false).map_err(error)
        };
        match done {
            Ok(false) => {
                if let CompactionPhase::Reading(newest, _) = &compaction.phase
                    && compaction.read >= compaction.end
                {
                    let kept = newest.bytes();
                    self.begin_at = self.limits.min_bytes.max(2 * kept);
                    if self.begin_at > compaction.end {
                        // Less than half of it would go.
                        self.running = None;
                    } else {
                        compaction.begin_to_copy();
                    }
                }
                Ok(None)
            }
            Ok(true) => {
                self.running = None;
                self.is_unsynced = true;
                let after = std::fs::metadata(&path).map_or(0, |file| file.len());
                sync_name(&*disk, &path)?;
                self.is_unsynced = false;
                Ok(Some(CompactedJournal {
                    before: length,
                    after,
                }))
            }
            Err(error) => {
                self.running = None;
                self.begin_at = length + self.limits.min_bytes / 4;
                // The room is needed now.
                let _ = disk.remove(&fresh);
                Err(error)
            }
        }
    }
}

impl Compaction {
    fn begin_to_copy(&mut self) {
        let phase = std::mem::replace(&mut self.phase, CompactionPhase::CatchingUp);
        if let CompactionPhase::Reading(newest, damaged) = phase {
            let mut offsets = damaged;
            offsets.extend(newest.offsets());
            offsets.sort_unstable_by(|a, b| b.cmp(a));
            self.phase = CompactionPhase::Copying(offsets);
            self.read = 0;
        }
    }

    /// Reads on, and copies what is to be copied.
    fn slice(
        &mut self,
        disk: &dyn Disk,
        fresh: &Path,
        path: &Path,
        length: u64,
        slice: u64,
    ) -> io::Result<()> {
        let is_first = self.read == 0;
        let end = match self.phase {
            CompactionPhase::CatchingUp => length,
            _ => self.end,
        };
        let mut journal = BufReader::new(disk.open_at(path, self.read)?.take(end - self.read));
        let begun_at = self.read;
        let (mut line, mut copied) = (Vec::new(), Vec::new());
        while self.read - begun_at < slice {
            line.clear();
            let count = journal.read_until(b'\n', &mut line)? as u64;
            if count == 0 {
                break;
            }
            let offset = self.read;
            self.read += count;
            match &mut self.phase {
                CompactionPhase::Reading(newest, damaged) => {
                    let text = std::str::from_utf8(&line).ok();
                    match text.and_then(JournalLine::from_text) {
                        Some(row) => newest.note(&row.table, row.id, offset, count),
                        None => damaged.push(offset),
                    }
                }
                CompactionPhase::Copying(offsets) => {
                    if offsets.pop_if(|next| *next == offset).is_some() {
                        copied.extend_from_slice(&line);
                    }
                }
                CompactionPhase::CatchingUp => copied.extend_from_slice(&line),
            }
        }
        let is_copying = matches!(self.phase, CompactionPhase::Copying(_));
        if is_copying && is_first {
            disk.create(fresh)?.write(&copied)?;
        } else if !copied.is_empty() {
            disk.append(fresh)?.write(&copied)?;
        }
        if is_copying && self.read >= self.end {
            self.phase = CompactionPhase::CatchingUp;
        }
        Ok(())
    }

    /// Copies the rest and puts the fresh file in the place of the journal. In a transaction: no other program appends.
    fn finish(&self, store: &mut Store, fresh: &Path, path: &Path) -> Result<(), StoreError> {
        let disk = store.disk();
        store.write(|_| {
            let replace = || -> io::Result<()> {
                let mut rest = Vec::new();
                disk.open_at(path, self.read)?.read_to_end(&mut rest)?;
                let mut file = disk.append(fresh)?;
                file.write(&rest)?;
                file.sync()?;
                disk.rename(fresh, path)
            };
            replace().map_err(|source| StoreError::File {
                path: path.to_owned(),
                source,
            })
        })
    }
}

/// Beside the folder of the journal, on the same file system.
fn fresh_path(store: &Store) -> PathBuf {
    store.dir().join("journal.compact")
}

fn sync_name(disk: &dyn Disk, path: &Path) -> Result<(), StoreError> {
    let folder = path.parent().unwrap_or(path);
    disk.sync_folder(folder).map_err(|source| StoreError::File {
        path: folder.to_owned(),
        source,
    })
}
