//! Large data in files named by the SHA-256 of their content. A file is written under a temporary name, synced and
//! renamed, and its folder synced; a file with its own name is therefore whole, or damaged later.

use super::checksum::{HASH_DIGITS, sha256_hex};
use super::disk::Disk;
use super::error::StoreError;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Suffix of a file that is still being written.
const TEMP_SUFFIX: &str = ".tmp";
/// Makes temporary names unique within this process.
static TEMP_FILE_COUNT: AtomicU64 = AtomicU64::new(0);

/// The folder of these files.
#[derive(Debug, Clone)]
pub(super) struct BlobFiles {
    dir: PathBuf,
    disk: Arc<dyn Disk>,
}

impl BlobFiles {
    /// In the store's folder `dir`; need not exist.
    pub(super) fn new(dir: &Path, disk: Arc<dyn Disk>) -> Self {
        let dir = dir.join("blobs");
        Self { dir, disk }
    }

    /// As [`new`](Self::new); creates the folder if it is missing.
    ///
    /// # Errors
    /// It cannot be created.
    pub(super) fn create(dir: &Path, disk: Arc<dyn Disk>) -> Result<Self, StoreError> {
        let files = Self::new(dir, disk);
        files
            .disk
            .create_folder(&files.dir)
            .map_err(|e| files.error(&files.dir, e))?;
        Ok(files)
    }

    /// Stores `bytes`, on disk when this returns. Returns the file name.
    ///
    /// # Errors
    /// The disk fails; nothing is left of the file then.
    pub(super) fn put(&self, bytes: &[u8]) -> Result<String, StoreError> {
        let name = sha256_hex(bytes);
        let path = self.dir.join(&name);
        let write = || -> io::Result<()> {
            // A damaged file of that name is replaced.
            let is_there = fs::read(&path).is_ok_and(|found| found == bytes);
            if !is_there {
                // Two writers may store the same content at once.
                let nth = TEMP_FILE_COUNT.fetch_add(1, Ordering::Relaxed);
                let own = format!("{name}.{}.{nth}{TEMP_SUFFIX}", process::id());
                let temp = self.dir.join(own);
                let written = self
                    .write_aside(&temp, bytes)
                    .and_then(|()| self.disk.rename(&temp, &path));
                if written.is_err() {
                    // The room is needed now. Where even this fails, the next start deletes it.
                    let _ = self.disk.remove(&temp);
                }
                written?;
            }
            // Also if the file exists: an earlier run may have stopped between the rename and this.
            self.disk.sync_folder(&self.dir)
        };
        write().map_err(|e| self.error(&path, e))?;
        Ok(name)
    }

    fn write_aside(&self, temp: &Path, bytes: &[u8]) -> io::Result<()> {
        let mut file = self.disk.create(temp)?;
        file.write(bytes)?;
        file.sync()
    }

    /// Reads the file `name` and checks its hash.
    ///
    /// # Errors
    /// It is missing or was changed.
    pub(super) fn get(&self, name: &str) -> Result<Vec<u8>, StoreError> {
        let path = self.dir.join(name);
        let bytes = self.disk.read(&path).map_err(|e| self.error(&path, e))?;
        let got = sha256_hex(&bytes);
        if got == name {
            return Ok(bytes);
        }
        Err(StoreError::Changed {
            what: path.display().to_string(),
            expected: format!("content with hash {name}"),
            got,
        })
    }

    /// Deletes the file `name`. Returns its size in bytes, 0 if it did not exist.
    ///
    /// # Errors
    /// The disk fails.
    pub(super) fn delete(&self, name: &str) -> Result<u64, StoreError> {
        let path = self.dir.join(name);
        let size = self.size(name);
        match self.disk.remove(&path) {
            Ok(()) => Ok(size),
            Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(0),
            Err(e) => Err(self.error(&path, e)),
        }
    }

    /// Names of all whole files of the store.
    ///
    /// # Errors
    /// The folder cannot be read.
    pub(super) fn names(&self) -> Result<Vec<String>, StoreError> {
        let mut names = self.entries()?;
        names.retain(|name| name.len() == HASH_DIGITS);
        Ok(names)
    }

    /// Names of half-written files, left by a stop in the middle of writing.
    ///
    /// # Errors
    /// The folder cannot be read.
    pub(super) fn half_written(&self) -> Result<Vec<String>, StoreError> {
        let mut names = self.entries()?;
        names.retain(|name| name.len() > HASH_DIGITS);
        Ok(names)
    }

    fn entries(&self) -> Result<Vec<String>, StoreError> {
        let read = || -> io::Result<Vec<String>> {
            let mut names = Vec::new();
            for entry in fs::read_dir(&self.dir)? {
                let name = entry?.file_name().to_string_lossy().into_owned();
                let (hash, rest) = name.split_at_checked(HASH_DIGITS).unwrap_or((&name, ""));
                let is_ours = rest.is_empty() || rest.ends_with(TEMP_SUFFIX);
                if is_ours
                    && hash.len() == HASH_DIGITS
                    && hash.bytes().all(|b| b.is_ascii_hexdigit())
                {
                    names.push(name);
                }
            }
            names.sort();
            Ok(names)
        };
        read().map_err(|e| self.error(&self.dir, e))
    }

    /// When the file `name` was written; `None`: it does not exist, or the system does not know.
    pub(super) fn written_at(&self, name: &str) -> Option<jiff::Timestamp> {
        let written = fs::metadata(self.dir.join(name)).ok()?.modified().ok()?;
        jiff::Timestamp::try_from(written).ok()
    }

    /// Size of the file `name` in bytes, 0 if it does not exist.
    pub(super) fn size(&self, name: &str) -> u64 {
        fs::metadata(self.dir.join(name)).map_or(0, |m| m.len())
    }

    fn error(&self, path: &Path, source: io::Error) -> StoreError {
        let path = path.to_owned();
        StoreError::File { path, source }
    }
}

#[cfg(test)]
mod tests {
    use super::BlobFiles;
    use crate::store::SystemDisk;
    use std::sync::Arc;

    #[test]
    fn content_is_read_back_and_damage_is_detected() {
        let dir = tempfile::tempdir().expect("temp dir");
        let files = BlobFiles::create(dir.path(), Arc::new(SystemDisk)).expect("folder");
        let name = files.put(b"abc").expect("kept");
        assert_eq!(files.get(&name).expect("read"), b"abc");
        assert_eq!(files.put(b"abc").expect("kept once"), name);
        std::fs::write(dir.path().join("blobs").join(&name), b"abd").expect("damaged");
        assert!(files.get(&name).is_err());
        assert_eq!(files.put(b"abc").expect("kept anew"), name);
        assert_eq!(files.get(&name).expect("whole again"), b"abc");
        assert_eq!(files.delete(&name).expect("deleted"), 3);
        assert_eq!(files.delete(&name).expect("gone already"), 0);
    }

    #[test]
    fn what_cannot_be_deleted_is_reported_and_what_is_gone_is_not() {
        let dir = tempfile::tempdir().expect("temp dir");
        let files = BlobFiles::create(dir.path(), Arc::new(SystemDisk)).expect("folder");
        std::fs::create_dir(dir.path().join("blobs/folder")).expect("in the way");
        assert!(files.delete("folder").is_err());
        assert_eq!(files.delete("none").expect("gone"), 0);
    }
}
