//! Restore: the files of a backup first, because that takes long and changes nothing; then its database and journal in one
//! short step that is undone where it fails; then the check. The service may run in between.

use super::backup::replace_database::remove_database;
use super::backup::swapped_store::SwappedStore;
use super::backup::{BackupResult, copy_journal, open_journal, refuse_own_folder};
use super::blob_files::BlobFiles;
use super::connection::{RecordTime, Store};
use super::disk::{Disk, SystemDisk};
use super::error::StoreError;
use super::ledger::Ledger;
use super::upkeep::StoreStart;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A restore whose files are in the store, and whose database waits beside the old one.
#[derive(Debug)]
pub struct PreparedRestore {
    dir: PathBuf,
    from: PathBuf,
    disk: Arc<dyn Disk>,
    new: PathBuf,
    new_journal: PathBuf,
    result: BackupResult,
}

impl Store {
    /// Makes the store in `dir` what the backup in `from` is. The old database and its journal are kept under other names,
    /// and so are evidence files that the backup does not have. Only for the holder of the service's lock.
    ///
    /// # Errors
    /// The backup is none or is damaged, or the disk fails; the store is as it was then.
    pub fn restore(
        dir: &Path,
        from: &Path,
        stamp: &RecordTime,
        progress: impl FnMut(usize, usize),
    ) -> Result<BackupResult, StoreError> {
        Self::restore_on(dir, from, Arc::new(SystemDisk), stamp, progress)
    }

    /// As [`Store::restore`], on this disk.
    ///
    /// # Errors
    /// As [`Store::restore`].
    pub fn restore_on(
        dir: &Path,
        from: &Path,
        disk: Arc<dyn Disk>,
        stamp: &RecordTime,
        progress: impl FnMut(usize, usize),
    ) -> Result<BackupResult, StoreError> {
        let mut prepared = PreparedRestore::new(dir, from, Arc::clone(&disk), progress)?;
        // Where undoing fails, nothing is there to do it later: the next start sees by the journal what the database has not.
        let (mut swapped, done) = prepared.put_in_place(stamp);
        done.inspect_err(|_| {
            let _ = swapped.undo();
        })?;
        match Self::open_on(dir, disk) {
            Ok(restored) => restored.close(),
            Err(error) => {
                let _ = swapped.undo();
                return Err(error);
            }
        }
        prepared.finish()
    }
}

impl PreparedRestore {
    /// Copies what the backup in `from` has and the store in `dir` has not. `progress` is called with the number of evidence files
    /// done and of all.
    ///
    /// # Errors
    /// The backup is none or is damaged, or the disk fails.
    pub fn new(
        dir: &Path,
        from: &Path,
        disk: Arc<dyn Disk>,
        mut progress: impl FnMut(usize, usize),
    ) -> Result<Self, StoreError> {
        refuse_own_folder(dir, from)?;
        let backup = Store::open_for_reading_on(from, Arc::clone(&disk))?;
        if let Some(error) = backup.check(|_, _| ())?.database_errors.first() {
            return Err(StoreError::BadBackup {
                path: from.to_owned(),
                why: error.clone(),
            });
        }
        let files = BlobFiles::create(dir, Arc::clone(&disk))?;
        let result = backup.copy_files(&files, &mut progress)?;
        let new = dir.join("patrold.db.restore");
        remove_database(&*disk, &new);
        backup.copy_database(&new)?;
        let new_journal = dir.join("journal.restore");
        let journal = open_journal(&*disk, backup.journal_path())?;
        copy_journal(journal, &new, &new_journal, &*disk)?;
        Ok(Self {
            dir: dir.to_owned(),
            from: from.to_owned(),
            disk,
            new,
            new_journal,
            result,
        })
    }

    /// The database first: after a stop between both the journal is ahead, which is noticed and loses nothing.
    /// Where the disk fails, what is in place by then is to be undone.
    fn put_in_place(&mut self, stamp: &RecordTime) -> (SwappedStore, Result<(), StoreError>) {
        let mut swapped = SwappedStore::new(&self.dir, Arc::clone(&self.disk));
        let done = swapped
            .replace_database(&self.new, stamp)
            .and_then(|()| swapped.replace_journal(&self.new_journal, stamp));
        self.result.old_database = swapped.kept_database().map(Path::to_owned);
        (swapped, done)
    }

    /// Copies what was deleted meanwhile, and checks the store.
    ///
    /// # Errors
    /// The disk or the database fails.
    pub fn finish(mut self) -> Result<BackupResult, StoreError> {
        let files = BlobFiles::new(&self.dir, Arc::clone(&self.disk));
        let backup = Store::open_for_reading_on(&self.from, Arc::clone(&self.disk))?;
        let again = backup.copy_files(&files, &mut |_, _| ())?;
        self.result.copied_files += again.copied_files;
        self.result.copied_bytes += again.copied_bytes;
        let restored = Store::open_for_reading_on(&self.dir, self.disk)?;
        self.result.check = restored.check(|_, _| ())?;
        Ok(self.result)
    }
}

impl Ledger {
    /// Goes on with the store that was prepared. What is held in memory belongs to the old one, so it is written first; where it
    /// cannot be, nothing is restored.
    ///
    /// # Errors
    /// The disk or the database fails, or something is still held; the store is as it was then. Where the disk does not even let
    /// that be, the ledger goes on with the old database under its other name, and the upkeep tries again.
    pub fn restore(
        &mut self,
        mut prepared: PreparedRestore,
        stamp: &RecordTime,
    ) -> Result<(PreparedRestore, StoreStart), StoreError> {
        self.undo_restore()?;
        if self.is_behind()
            && let Some(why) = self.retry().why
        {
            return Err(why);
        }
        self.store.append_to_journal();
        self.store.fold_log();
        let (swapped, done) = prepared.put_in_place(stamp);
        if let Err(error) = done {
            return Err(self.give_up(error, swapped));
        }
        match Store::open_on(&prepared.dir, Arc::clone(&self.store.disk)) {
            Ok(restored) => {
                std::mem::replace(&mut self.store, restored).close();
                self.compactor.reset(&self.store);
                Ok((prepared, self.start()))
            }
            Err(error) => Err(self.give_up(error, swapped)),
        }
    }

    fn give_up(&mut self, error: StoreError, swapped: SwappedStore) -> StoreError {
        self.half_restored = Some(swapped);
        // The first error counts; the upkeep tries again.
        let _ = self.undo_restore();
        error
    }

    /// Undoes a restore that failed half way and could not be undone at once.
    pub(super) fn undo_restore(&mut self) -> Result<(), StoreError> {
        if let Some(swapped) = &mut self.half_restored {
            swapped.undo()?;
            self.half_restored = None;
        }
        Ok(())
    }
}
