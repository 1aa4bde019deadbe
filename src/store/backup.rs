//! Backup: the database by SQLite's online backup, then the evidence files that the other side does not have, then the journal
//! as far as that database knows it. Run again it continues.

pub(super) mod replace_database;
pub(super) mod swapped_store;

use super::blob_files::BlobFiles;
use super::check::StoreCheck;
use super::connection::{Store, database_path};
use super::disk::{Disk, TransactionStep};
use super::error::StoreError;
use super::journal::line::{JournalLine, read_lines};
use super::journal::tables::journal_path;
use replace_database::{remove_database, remove_log, rename};
use rusqlite::backup::{Backup, StepResult};
use rusqlite::{Connection, OptionalExtension, ffi};
use serde::{Deserialize, Serialize};
use std::fs;
use std::io::{self, BufReader, Read};
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What a backup or a restore copied.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct BackupResult {
    /// Evidence files copied.
    pub copied_files: usize,
    /// Bytes of these.
    pub copied_bytes: u64,
    /// Evidence files that were there already.
    pub present_files: usize,
    /// Evidence files that are damaged at their source; they are not copied.
    pub damaged_files: usize,
    /// Where the replaced database is now; null: there was none, or for a backup.
    pub old_database: Option<PathBuf>,
    /// What a check of the result found.
    pub check: StoreCheck,
}

impl Store {
    /// Copies the store to the folder `to`, which is created, or is an older backup. The service may run. `progress` is called
    /// with the number of evidence files done and of all.
    ///
    /// # Errors
    /// The disk or the database fails; a part may be copied, and a backup that was there is as it was or newer.
    pub fn back_up(
        &self,
        to: &Path,
        mut progress: impl FnMut(usize, usize),
    ) -> Result<BackupResult, StoreError> {
        if let Some(dir) = self.database_path().parent() {
            refuse_own_folder(dir, to)?;
        }
        let disk = Arc::clone(&self.disk);
        let files = BlobFiles::create(to, Arc::clone(&disk))?;
        let new = to.join("patrold.db.new");
        remove_database(&*disk, &new);
        let journal = self.journal_path();
        // Where the journal is compacted before the end, lines that this copy of the database needs are in the old one alone.
        let inode = inode_of(journal);
        let mut journals = open_journal(&*disk, journal)?;
        self.copy_database(&new)?;
        let database = database_path(to);
        remove_log(&*disk, &database);
        rename(&*disk, &new, &database)?;
        sync_folder(&*disk, to)?;
        // After the database: every file that it names is there.
        let mut result = self.copy_files(&files, &mut progress)?;
        if inode_of(journal) != inode {
            journals.extend(open_journal(&*disk, journal)?);
        }
        copy_journal(journals, &database, &journal_path(to), &*disk)?;
        result.check = Self::open_for_reading(to)?.check(|_, _| ())?;
        Ok(result)
    }

    pub(super) fn copy_database(&self, to: &Path) -> Result<(), StoreError> {
        self.transaction_step(TransactionStep::Begin, to)?;
        self.query(|db| {
            let mut copy = Connection::open(to)?;
            // All pages at once: one snapshot, whatever is written meanwhile.
            if Backup::new(db, &mut copy)?.step(-1)? != StepResult::Done {
                let busy = ffi::Error::new(ffi::SQLITE_BUSY);
                return Err(rusqlite::Error::SqliteFailure(busy, None).into());
            }
            copy.pragma_update(None, "journal_mode", "DELETE")?;
            copy.close().map_err(|(_, error)| error)?;
            Ok(())
        })?;
        self.transaction_step(TransactionStep::Commit, to)?;
        self.disk.sync_file(to).map_err(|source| StoreError::File {
            path: to.to_owned(),
            source,
        })
    }

    /// What a disk of a test has the database at `path` fail with.
    fn transaction_step(&self, step: TransactionStep, path: &Path) -> Result<(), StoreError> {
        let failed = |code| {
            let error = rusqlite::Error::SqliteFailure(ffi::Error::new(code), None);
            StoreError::from(error).with_path(path)
        };
        self.disk.transaction_step(step).map_err(failed)
    }

    pub(super) fn copy_files(
        &self,
        to: &BlobFiles,
        progress: &mut impl FnMut(usize, usize),
    ) -> Result<BackupResult, StoreError> {
        let names = self.files.names()?;
        let mut result = BackupResult::default();
        for (done, name) in names.iter().enumerate() {
            progress(done, names.len());
            if to.get(name).is_ok() {
                result.present_files += 1;
                continue;
            }
            match self.files.get(name) {
                Ok(bytes) => {
                    to.put(&bytes)?;
                    result.copied_files += 1;
                    result.copied_bytes += bytes.len() as u64;
                }
                Err(StoreError::Changed { .. }) => result.damaged_files += 1,
                // Retention deleted it meanwhile.
                Err(StoreError::File { source, .. })
                    if source.kind() == io::ErrorKind::NotFound => {}
                Err(error) => return Err(error),
            }
        }
        Ok(result)
    }
}

/// A folder that is not there yet is another one.
pub(super) fn refuse_own_folder(own: &Path, other: &Path) -> Result<(), StoreError> {
    match (own.canonicalize(), other.canonicalize()) {
        (Ok(own), Ok(other)) if own == other => Err(StoreError::OwnBackup { path: own }),
        _ => Ok(()),
    }
}

/// The journal at `path`, where there is one.
pub(super) fn open_journal(disk: &dyn Disk, path: &Path) -> Result<Vec<Box<dyn Read>>, StoreError> {
    match disk.open_at(path, 0) {
        Ok(file) => Ok(vec![file]),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Vec::new()),
        Err(source) => Err(StoreError::File {
            path: path.to_owned(),
            source,
        }),
    }
}

fn inode_of(path: &Path) -> Option<u64> {
    fs::metadata(path).ok().map(|file| file.ino())
}

/// Copies the lines of journals that the database at `database` knows: those after its last change belong to a later state.
pub(super) fn copy_journal(
    from: Vec<Box<dyn Read>>,
    database: &Path,
    to: &Path,
    disk: &dyn Disk,
) -> Result<(), StoreError> {
    let known = || -> rusqlite::Result<i64> {
        let db = Connection::open(database)?;
        let sql = "SELECT seq FROM sqlite_sequence WHERE name = 'unjournaled'";
        let known = db.query_row(sql, [], |row| row.get(0)).optional()?;
        Ok(known.unwrap_or(0))
    };
    let known = known().map_err(|error| StoreError::from(error).with_path(database))?;
    let copy = || -> io::Result<()> {
        let temp = to.with_extension("tmp");
        let mut copy = disk.create(&temp)?;
        for file in from {
            let each = |line: JournalLine| -> io::Result<()> {
                if line.number > known {
                    return Ok(());
                }
                let text = line.to_text().map_err(io::Error::other)?;
                copy.write(text.as_bytes())
            };
            read_lines(BufReader::new(file), each)?;
        }
        copy.sync()?;
        disk.rename(&temp, to)
    };
    copy().map_err(|source| StoreError::File {
        path: to.to_owned(),
        source,
    })
}

pub(super) fn sync_folder(disk: &dyn Disk, dir: &Path) -> Result<(), StoreError> {
    disk.sync_folder(dir).map_err(|source| StoreError::File {
        path: dir.to_owned(),
        source,
    })
}

#[cfg(test)]
mod tests {
    use super::{JournalLine, copy_journal, open_journal, read_lines};
    use crate::store::{Store, StoreError, SystemDisk};
    use std::fs;
    use std::io;

    fn line(number: i64) -> String {
        let line = JournalLine {
            number,
            table: "visit".to_owned(),
            id: number,
            row: None,
        };
        line.to_text().expect("text")
    }

    #[test]
    fn the_lines_that_the_database_knows_are_copied_and_no_later_ones() {
        let dir = tempfile::tempdir().expect("temp dir");
        let mut store = Store::open(dir.path()).expect("store");
        for name in ["hall", "yard"] {
            let insert = "INSERT INTO waypoint (name, created_at) VALUES (?1, '')";
            let written = store.transaction(|change| Ok(change.execute(insert, [name])?));
            written.expect("written");
        }
        store.close();
        let database = dir.path().join("patrold.db");
        let (from, to) = (dir.path().join("from"), dir.path().join("to"));
        let copied = || {
            let journal = open_journal(&SystemDisk, &from)?;
            copy_journal(journal, &database, &to, &SystemDisk)
        };
        // The database knows changes 1 and 2; a damaged line is of nobody.
        let lines = [line(1), "torn\n".to_owned(), line(3), line(2)];
        fs::write(&from, lines.concat()).expect("written");
        copied().expect("copied");
        let mut numbers = Vec::new();
        let text = fs::read(&to).expect("read");
        let damaged = read_lines(text.as_slice(), |line| -> io::Result<()> {
            numbers.push(line.number);
            Ok(())
        });
        assert_eq!((numbers, damaged.expect("read")), (vec![1, 2], 0));
        // A store without a journal has an empty one; one that cannot be read is an error.
        fs::remove_file(&from).expect("removed");
        copied().expect("copied");
        assert_eq!(fs::read(&to).expect("read"), b"");
        fs::create_dir(&from).expect("a folder");
        let error = copied().expect_err("no file");
        assert!(matches!(error, StoreError::File { .. }), "{error}");
    }
}
