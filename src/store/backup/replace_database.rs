//! Puts a new database in the place of an old one, which is kept under another name.

use super::super::connection::{RecordTime, database_path};
use super::super::disk::Disk;
use super::super::error::StoreError;
use std::io;
use std::path::{Path, PathBuf};

/// The files of a database beside its own.
const SUFFIXES: [&str; 2] = ["-wal", "-shm"];

/// Deletes a database with its files, such as an interrupted replacement left.
pub(in crate::store) fn remove_database(disk: &dyn Disk, path: &Path) {
    let _ = disk.remove(path);
    remove_log(disk, path);
}

/// Deletes what belongs to a database that is about to be replaced.
pub(in crate::store) fn remove_log(disk: &dyn Disk, path: &Path) {
    for suffix in SUFFIXES {
        let _ = disk.remove(&beside(path, suffix));
    }
}

/// Puts the database at `new` in the place of that of the store in `dir`; `before` is what replaced it. Returns where the old one
/// is, also where the disk fails: then what is done by then is to be undone.
pub(in crate::store) fn put_in_place(
    disk: &dyn Disk,
    dir: &Path,
    new: &Path,
    before: &str,
    stamp: &RecordTime,
) -> (OldDatabase, Result<(), StoreError>) {
    let path = database_path(dir);
    let mut old = OldDatabase {
        kept: path.exists().then(|| aside(&path, before, stamp)),
        path,
        is_replaced: false,
    };
    let replace = || -> Result<(), StoreError> {
        let Some(kept) = &old.kept else {
            return rename(disk, new, &old.path);
        };
        keep_as(disk, &old.path, kept)?;
        // Its log must not be applied to the new one. A stop right here sets the old one back to its last checkpoint, which the
        // next start notices by the journal.
        for suffix in SUFFIXES {
            let from = beside(&old.path, suffix);
            if from.exists() {
                rename(disk, &from, &beside(kept, suffix))?;
            }
        }
        rename(disk, new, &old.path)
    };
    let done = replace();
    old.is_replaced = done.is_ok();
    (old, done)
}

/// A database that was replaced, or nearly.
#[derive(Debug)]
pub(in crate::store) struct OldDatabase {
    path: PathBuf,
    /// Its other name; `None`: there was none.
    pub(in crate::store) kept: Option<PathBuf>,
    is_replaced: bool,
}

impl OldDatabase {
    /// Undoes [`put_in_place`]: it is that of the store again, with its log, or there is none. May be called again where it
    /// fails.
    ///
    /// # Errors
    /// The disk fails.
    pub(in crate::store) fn undo(&mut self, disk: &dyn Disk) -> Result<(), StoreError> {
        if self.is_replaced {
            // That of the new one.
            remove_log(disk, &self.path);
        }
        let Some(kept) = &self.kept else {
            return remove_if_there(disk, &self.path);
        };
        if self.is_replaced {
            rename(disk, kept, &self.path)?;
            self.is_replaced = false;
        }
        // After it: a log must never lie beside the other database.
        for suffix in SUFFIXES {
            let moved = beside(kept, suffix);
            if moved.exists() {
                rename(disk, &moved, &beside(&self.path, suffix))?;
            }
        }
        // The second name of one that was not replaced.
        remove_if_there(disk, kept)
    }
}

pub(in crate::store) fn remove_if_there(disk: &dyn Disk, path: &Path) -> Result<(), StoreError> {
    match disk.remove(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(StoreError::File {
            path: path.to_owned(),
            source: error,
        }),
        _ => Ok(()),
    }
}

/// Gives a file a second name, so that replacing it under the first one is a single step.
pub(in crate::store) fn keep_as(
    disk: &dyn Disk,
    path: &Path,
    kept: &Path,
) -> Result<(), StoreError> {
    // Of an attempt in the same second.
    let _ = disk.remove(kept);
    disk.link(path, kept).map_err(|source| StoreError::File {
        path: path.to_owned(),
        source,
    })
}

/// Another name for a file that something replaces at that time.
pub(in crate::store) fn aside(path: &Path, before: &str, stamp: &RecordTime) -> PathBuf {
    beside(path, &format!(".before-{before}-{}", stamp.at.as_second()))
}

pub(in crate::store) fn rename(disk: &dyn Disk, from: &Path, to: &Path) -> Result<(), StoreError> {
    disk.rename(from, to).map_err(|source| StoreError::File {
        path: from.to_owned(),
        source,
    })
}

fn beside(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    PathBuf::from(name)
}
