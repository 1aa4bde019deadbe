//! Puts a new database in the place of an old one, which is kept under another name.

use super::super::connection::{RecordTime, database_path};
use super::super::error::StoreError;
use std::fs;
use std::path::{Path, PathBuf};

/// The files of a database beside its own.
const SUFFIXES: [&str; 2] = ["-wal", "-shm"];

/// Deletes a database with its files, such as an interrupted replacement left.
pub(in crate::store) fn remove_database(path: &Path) {
    let _ = fs::remove_file(path);
    remove_log(path);
}

/// Deletes what belongs to a database that is about to be replaced.
pub(in crate::store) fn remove_log(path: &Path) {
    for suffix in SUFFIXES {
        let _ = fs::remove_file(beside(path, suffix));
    }
}

/// Puts the database at `new` in the place of that of the store in `dir`. Returns where the old one is, if there was one;
/// `before` is what replaced it.
pub(in crate::store) fn put_in_place(
    dir: &Path,
    new: &Path,
    before: &str,
    stamp: &RecordTime,
) -> Result<Option<PathBuf>, StoreError> {
    let old = database_path(dir);
    let kept = aside(&old, before, stamp);
    let is_there = old.exists();
    if is_there {
        keep_as(&old, &kept)?;
    }
    // Its log must not be applied to the new one. A stop right here sets the old one back to its last checkpoint, which the
    // next start notices by the journal.
    let replace = || {
        for suffix in SUFFIXES {
            let from = beside(&old, suffix);
            if from.exists() {
                rename(&from, &beside(&kept, suffix))?;
            }
        }
        rename(new, &old)
    };
    if let Err(error) = replace() {
        take_back(&old, &kept);
        return Err(error);
    }
    Ok(is_there.then_some(kept))
}

/// Undoes [`put_in_place`]: the database at `kept` is that of the store in `dir` again, or there is none.
pub(in crate::store) fn undo(dir: &Path, kept: Option<&Path>) {
    let path = database_path(dir);
    // That of the new one.
    remove_log(&path);
    match kept {
        Some(kept) => take_back(&path, kept),
        None => drop(fs::remove_file(&path)),
    }
}

/// What was moved goes back; what was not is where it was.
fn take_back(path: &Path, kept: &Path) {
    for suffix in SUFFIXES {
        let _ = fs::rename(beside(kept, suffix), beside(path, suffix));
    }
    let _ = fs::rename(kept, path);
}

/// Gives a file a second name, so that replacing it under the first one is a single step.
pub(in crate::store) fn keep_as(path: &Path, kept: &Path) -> Result<(), StoreError> {
    // Of an attempt in the same second.
    let _ = fs::remove_file(kept);
    fs::hard_link(path, kept).map_err(|source| StoreError::File {
        path: path.to_owned(),
        source,
    })
}

/// Another name for a file that something replaces at that time.
pub(in crate::store) fn aside(path: &Path, before: &str, stamp: &RecordTime) -> PathBuf {
    beside(path, &format!(".before-{before}-{}", stamp.at.as_second()))
}

pub(in crate::store) fn rename(from: &Path, to: &Path) -> Result<(), StoreError> {
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
