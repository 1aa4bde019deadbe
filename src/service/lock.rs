//! One service per store: a lock file, held as long as the service lives, however it dies.

use super::error::ServiceError;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read as _, Seek as _, Write as _};
use std::path::Path;

/// The lock on a store's folder; dropping it lets go.
#[derive(Debug)]
pub struct StoreLock {
    /// The system's lock lives as long as this is open.
    _file: File,
}

impl StoreLock {
    /// Takes the lock of `dir`, making the folder where it is missing.
    ///
    /// # Errors
    /// Another service has it, or the folder cannot be written.
    pub fn take(dir: &Path) -> Result<Self, ServiceError> {
        let path = dir.join("patrold.lock");
        let unusable = |source| ServiceError::Folder {
            path: path.clone(),
            source,
        };
        std::fs::create_dir_all(dir).map_err(unusable)?;
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(&path)
            .map_err(unusable)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut pid = String::new();
                // Without its number the message is poorer, no more.
                let _ = file.read_to_string(&mut pid);
                return Err(ServiceError::Taken {
                    pid: pid.trim().to_owned(),
                    dir: dir.to_owned(),
                });
            }
            Err(TryLockError::Error(error)) => return Err(unusable(error)),
        }
        let written = file
            .set_len(0)
            .and_then(|()| file.rewind())
            .and_then(|()| writeln!(file, "{}", std::process::id()));
        written.map_err(unusable)?;
        Ok(Self { _file: file })
    }
}

#[cfg(test)]
mod tests {
    use super::StoreLock;

    #[test]
    fn the_second_is_told_who_the_first_is() {
        let dir = tempfile::tempdir().expect("temp dir");
        let first = StoreLock::take(dir.path()).expect("free");
        let told = StoreLock::take(dir.path()).expect_err("taken").to_string();
        let pid = std::process::id();
        assert!(
            told.starts_with(&format!("another patrold (pid {pid}) already uses ")),
            "{told}"
        );
        drop(first);
        StoreLock::take(dir.path()).expect("free again");
    }
}
