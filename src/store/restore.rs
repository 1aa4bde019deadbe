//! Restore: the files of a backup first, because that takes long and changes nothing; then its database and journal in one
//! short step that is undone where it fails; then the check. The service may run in between.

use super::backup::replace_database::{
    aside, keep_as, put_in_place, remove_database, rename, undo,
};
use super::backup::{BackupResult, copy_journal, refuse_own_folder, sync_folder};
use super::blob_files::BlobFiles;
use super::connection::{RecordTime, Store};
use super::disk::{Disk, SystemDisk};
use super::error::StoreError;
use super::journal::tables::journal_path;
use super::ledger::Ledger;
use super::upkeep::StoreStart;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A restore whose files are in the store, and whose database waits beside the old one.
#[derive(Debug)]
pub struct PreparedRestore {
    dir: PathBuf,
    from: PathBuf,
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
        let mut prepared = PreparedRestore::new(dir, from, progress)?;
        let swapped = prepared.put_in_place(stamp)?;
        match Self::open(dir) {
            Ok(restored) => restored.close(),
            Err(error) => {
                swapped.undo();
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
        mut progress: impl FnMut(usize, usize),
    ) -> Result<Self, StoreError> {
        refuse_own_folder(dir, from)?;
        let backup = Store::open_for_reading(from)?;
        if let Some(error) = backup.check(|_, _| ())?.database_errors.first() {
            return Err(StoreError::BadBackup {
                path: from.to_owned(),
                why: error.clone(),
            });
        }
        let disk: Arc<dyn Disk> = Arc::new(SystemDisk);
        let files = BlobFiles::create(dir, Arc::clone(&disk))?;
        let result = backup.copy_files(&files, &mut progress)?;
        let new = dir.join("patrold.db.restore");
        remove_database(&new);
        backup.copy_database(&new)?;
        let new_journal = dir.join("journal.restore");
        copy_journal(backup.journal_path(), &new, &new_journal, &*disk)?;
        Ok(Self {
            dir: dir.to_owned(),
            from: from.to_owned(),
            new,
            new_journal,
            result,
        })
    }

    /// The database first: after a stop between both the journal is ahead, which is noticed and loses nothing.
    fn put_in_place(&mut self, stamp: &RecordTime) -> Result<SwappedDatabase, StoreError> {
        let (dir, disk) = (&self.dir, SystemDisk);
        let journal = journal_path(dir);
        let mut swapped = SwappedDatabase {
            dir: dir.clone(),
            old_database: put_in_place(dir, &self.new, "restore", stamp)?,
            old_journal: None,
        };
        let replace_journal = || -> Result<Option<PathBuf>, StoreError> {
            let kept = journal.exists().then(|| aside(&journal, "restore", stamp));
            if let Some(kept) = &kept {
                keep_as(&journal, kept)?;
            }
            rename(&self.new_journal, &journal)?;
            Ok(kept)
        };
        match replace_journal() {
            Ok(kept) => swapped.old_journal = kept,
            Err(error) => {
                swapped.undo();
                return Err(error);
            }
        }
        let synced = sync_folder(&disk, dir).and_then(|()| sync_folder(&disk, &dir.join("blobs")));
        if let Err(error) = synced {
            swapped.undo();
            return Err(error);
        }
        self.result.old_database.clone_from(&swapped.old_database);
        Ok(swapped)
    }

    /// Copies what was deleted meanwhile, and checks the store.
    ///
    /// # Errors
    /// The disk or the database fails.
    pub fn finish(mut self) -> Result<BackupResult, StoreError> {
        let files = BlobFiles::new(&self.dir, Arc::new(SystemDisk));
        let again = Store::open_for_reading(&self.from)?.copy_files(&files, &mut |_, _| ())?;
        self.result.copied_files += again.copied_files;
        self.result.copied_bytes += again.copied_bytes;
        self.result.check = Store::open_for_reading(&self.dir)?.check(|_, _| ())?;
        Ok(self.result)
    }
}

impl Ledger {
    /// Goes on with the store that was prepared. What is held in memory belongs to the old one, so it is written first; where it
    /// cannot be, nothing is restored.
    ///
    /// # Errors
    /// The disk or the database fails, or something is still held; the store is as it was then.
    pub fn restore(
        &mut self,
        mut prepared: PreparedRestore,
        stamp: &RecordTime,
    ) -> Result<(PreparedRestore, StoreStart), StoreError> {
        if self.is_behind()
            && let Some(why) = self.retry().why
        {
            return Err(why);
        }
        self.store.append_to_journal();
        self.store.fold_log();
        let swapped = prepared.put_in_place(stamp)?;
        match Store::open_on(&prepared.dir, Arc::clone(&self.store.disk)) {
            Ok(restored) => {
                std::mem::replace(&mut self.store, restored).close();
                Ok((prepared, self.start()))
            }
            Err(error) => {
                swapped.undo();
                Err(error)
            }
        }
    }
}

/// Where the old database and the old journal are.
#[derive(Debug)]
struct SwappedDatabase {
    dir: PathBuf,
    old_database: Option<PathBuf>,
    old_journal: Option<PathBuf>,
}

impl SwappedDatabase {
    /// Best effort: each is a rename, which a disk that just took others takes too.
    fn undo(self) {
        undo(&self.dir, self.old_database.as_deref());
        if let Some(kept) = &self.old_journal {
            let _ = rename(kept, &journal_path(&self.dir));
        }
    }
}
