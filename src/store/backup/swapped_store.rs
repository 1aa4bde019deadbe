//! A store whose database and journal were replaced by others, or nearly: until it is known that they serve, it can be undone.

use super::super::connection::RecordTime;
use super::super::disk::Disk;
use super::super::error::StoreError;
use super::super::journal::tables::journal_path;
use super::replace_database::{OldDatabase, aside, keep_as, put_in_place, remove_if_there, rename};
use super::sync_folder;
use std::path::{Path, PathBuf};
use std::sync::Arc;

#[derive(Debug)]
pub(in crate::store) struct SwappedStore {
    dir: PathBuf,
    disk: Arc<dyn Disk>,
    old_database: Option<OldDatabase>,
    /// `None`: not replaced; the inner one: there was none.
    old_journal: Option<Option<PathBuf>>,
}

impl SwappedStore {
    /// Nothing of the store in `dir` is replaced yet.
    pub(in crate::store) fn new(dir: &Path, disk: Arc<dyn Disk>) -> Self {
        Self {
            dir: dir.to_owned(),
            disk,
            old_database: None,
            old_journal: None,
        }
    }

    /// Where the old database is, if there was one.
    pub(in crate::store) fn kept_database(&self) -> Option<&Path> {
        self.old_database.as_ref()?.kept.as_deref()
    }

    /// # Errors
    /// The disk fails; what is done by then is to be undone.
    pub(in crate::store) fn replace_database(
        &mut self,
        new: &Path,
        stamp: &RecordTime,
    ) -> Result<(), StoreError> {
        let (old, done) = put_in_place(&*self.disk, &self.dir, new, "restore", stamp);
        self.old_database = Some(old);
        done
    }

    /// # Errors
    /// The disk fails; what is done by then is to be undone.
    pub(in crate::store) fn replace_journal(
        &mut self,
        new: &Path,
        stamp: &RecordTime,
    ) -> Result<(), StoreError> {
        let (disk, journal) = (&*self.disk, journal_path(&self.dir));
        let kept = journal.exists().then(|| aside(&journal, "restore", stamp));
        if let Some(kept) = &kept {
            keep_as(disk, &journal, kept)?;
        }
        rename(disk, new, &journal).inspect_err(|_| {
            // Its second name.
            let _ = kept.iter().try_for_each(|kept| disk.remove(kept));
        })?;
        self.old_journal = Some(kept);
        sync_folder(disk, &self.dir)?;
        sync_folder(disk, &self.dir.join("blobs"))
    }

    /// Database and journal are the old ones again, or there are none. May be called again where it fails.
    ///
    /// # Errors
    /// The disk fails.
    pub(in crate::store) fn undo(&mut self) -> Result<(), StoreError> {
        if let Some(old) = &mut self.old_database {
            old.undo(&*self.disk)?;
            self.old_database = None;
        }
        let journal = journal_path(&self.dir);
        match &self.old_journal {
            None => return Ok(()),
            Some(Some(kept)) => rename(&*self.disk, kept, &journal)?,
            Some(None) => remove_if_there(&*self.disk, &journal)?,
        }
        self.old_journal = None;
        Ok(())
    }
}
