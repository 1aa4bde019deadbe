//! Puts a new database in the place of an old one, which is kept under another name.

use super::connection::{RecordTime, database_path};
use super::error::StoreError;
use std::fs;
use std::path::{Path, PathBuf};

/// The files of a database beside its own.
const SUFFIXES: [&str; 3] = ["-wal", "-shm", ""];

/// Deletes a database with its files, such as an interrupted replacement left.
pub(super) fn remove_database(path: &Path) {
    for suffix in SUFFIXES {
        let _ = fs::remove_file(beside(path, suffix));
    }
}

/// Puts the database at `new` in the place of that of the store in `dir`. Returns where the old one is, if there was one;
/// `before` is what replaced it.
pub(super) fn put_in_place(
    dir: &Path,
    new: &Path,
    before: &str,
    stamp: &RecordTime,
) -> Result<Option<PathBuf>, StoreError> {
    let old = database_path(dir);
    let kept = aside(&old, before, stamp);
    let mut moved = None;
    for suffix in SUFFIXES {
        let from = beside(&old, suffix);
        if from.exists() {
            rename(&from, &beside(&kept, suffix))?;
            moved = Some(kept.clone());
        }
    }
    rename(new, &old)?;
    Ok(moved)
}

/// Another name for a file that something replaces at that time.
pub(super) fn aside(path: &Path, before: &str, stamp: &RecordTime) -> PathBuf {
    beside(path, &format!(".before-{before}-{}", stamp.at.as_second()))
}

pub(super) fn rename(from: &Path, to: &Path) -> Result<(), StoreError> {
    fs::rename(from, to).map_err(|source| StoreError::File {
        path: from.to_owned(),
        source,
    })
}

fn beside(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    PathBuf::from(name)
}
