//! What the store asks of the disk, behind one trait: a disk of a test fails at a chosen step, counts syncs, and shows
//! what was not synced.

use std::fmt::Debug;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Seek as _, SeekFrom, Write as _};
use std::path::Path;

pub(super) mod rights;

use rights::share_folder_with_parent;
pub use rights::{access_remedy, share_with_folder};

/// The disk under a store. One step each, so that every one of them can fail by itself.
pub trait Disk: Debug + Send + Sync {
    /// Creates a folder with its parents; an existing one is no error.
    ///
    /// # Errors
    /// The system refuses it.
    fn create_folder(&self, path: &Path) -> io::Result<()>;

    /// Creates a file, or empties an existing one.
    ///
    /// # Errors
    /// The system refuses it.
    fn create(&self, path: &Path) -> io::Result<Box<dyn DiskFile>>;

    /// Opens a file for writing at its end; creates it if it is missing.
    ///
    /// # Errors
    /// The system refuses it.
    fn append(&self, path: &Path) -> io::Result<Box<dyn DiskFile>>;

    /// The content of a file.
    ///
    /// # Errors
    /// The system refuses it.
    fn read(&self, path: &Path) -> io::Result<Vec<u8>>;

    /// Opens a file to read it piece by piece from this byte on.
    ///
    /// # Errors
    /// The system refuses it.
    fn open_at(&self, path: &Path, offset: u64) -> io::Result<Box<dyn Read>>;

    /// Writes the content of a file that something else wrote to the medium.
    ///
    /// # Errors
    /// The system refuses it.
    fn sync_file(&self, path: &Path) -> io::Result<()>;

    /// Gives a file a second name.
    ///
    /// # Errors
    /// The system refuses it.
    fn link(&self, from: &Path, to: &Path) -> io::Result<()>;

    /// Gives a file another name.
    ///
    /// # Errors
    /// The system refuses it.
    fn rename(&self, from: &Path, to: &Path) -> io::Result<()>;

    /// Deletes a file.
    ///
    /// # Errors
    /// The system refuses it.
    fn remove(&self, path: &Path) -> io::Result<()>;

    /// Writes the names in a folder to the medium.
    ///
    /// # Errors
    /// The system refuses it.
    fn sync_folder(&self, path: &Path) -> io::Result<()>;

    /// Bytes that this user may still write where `path` is.
    ///
    /// # Errors
    /// The system refuses it.
    fn free_bytes(&self, path: &Path) -> io::Result<u64>;

    /// Asked before SQLite begins and commits a write. SQLite uses files of its own; what a test wants it to fail with is
    /// given here.
    ///
    /// # Errors
    /// A result code of SQLite (<https://www.sqlite.org/rescode.html>).
    fn transaction_step(&self, step: TransactionStep) -> Result<(), i32>;
}

/// A file that is being written.
pub trait DiskFile {
    /// Writes all of `bytes`.
    ///
    /// # Errors
    /// The system refuses it; a part may have been written.
    fn write(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// Writes the content to the medium.
    ///
    /// # Errors
    /// The system refuses it.
    fn sync(&mut self) -> io::Result<()>;
}

/// A step of a write transaction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TransactionStep {
    /// Taking the write lock.
    Begin,
    /// Writing and syncing the changed pages.
    Commit,
}

/// The disk of the system.
#[derive(Debug, Clone, Copy, Default)]
pub struct SystemDisk;

impl Disk for SystemDisk {
    fn create_folder(&self, path: &Path) -> io::Result<()> {
        let is_new = !path.exists();
        fs::create_dir_all(path)?;
        match is_new {
            true => share_folder_with_parent(path),
            false => Ok(()),
        }
    }

    fn create(&self, path: &Path) -> io::Result<Box<dyn DiskFile>> {
        let file = File::create(path)?;
        share_with_folder(path)?;
        Ok(Box::new(file))
    }

    fn append(&self, path: &Path) -> io::Result<Box<dyn DiskFile>> {
        let file = OpenOptions::new().append(true).create(true).open(path)?;
        share_with_folder(path)?;
        Ok(Box::new(file))
    }

    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        fs::read(path)
    }

    fn open_at(&self, path: &Path, offset: u64) -> io::Result<Box<dyn Read>> {
        let mut file = File::open(path)?;
        file.seek(SeekFrom::Start(offset))?;
        Ok(Box::new(file))
    }

    fn sync_file(&self, path: &Path) -> io::Result<()> {
        File::open(path)?.sync_all()
    }

    fn link(&self, from: &Path, to: &Path) -> io::Result<()> {
        fs::hard_link(from, to)
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        fs::rename(from, to)
    }

    fn remove(&self, path: &Path) -> io::Result<()> {
        fs::remove_file(path)
    }

    fn sync_folder(&self, path: &Path) -> io::Result<()> {
        File::open(path)?.sync_all()
    }

    fn free_bytes(&self, path: &Path) -> io::Result<u64> {
        let figures = rustix::fs::statvfs(path)?;
        Ok(figures.f_bavail.saturating_mul(figures.f_frsize))
    }

    fn transaction_step(&self, _step: TransactionStep) -> Result<(), i32> {
        Ok(())
    }
}

impl DiskFile for File {
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.write_all(bytes)
    }

    fn sync(&mut self) -> io::Result<()> {
        self.sync_all()
    }
}
