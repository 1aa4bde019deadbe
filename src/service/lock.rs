//! One service per store: a lock on a file, released by the system when the process ends.

use super::error::ServiceError;
use crate::store::{StoreError, share_with_folder};
use rustix::fs::OFlags;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read as _, Seek as _, Write as _};
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::Path;

/// Held by whoever may change a store as a whole.
#[derive(Debug)]
pub struct StoreLock {
    /// Locked as long as it is open.
    _file: File,
}

impl StoreLock {
    /// Creates `dir` where it is missing.
    ///
    /// # Errors
    /// Another process holds it, or the file cannot be used.
    pub fn acquire(dir: &Path) -> Result<Self, ServiceError> {
        let path = dir.join("patrold.lock");
        let unusable = |source: io::Error| match source.kind() {
            io::ErrorKind::PermissionDenied => StoreError::forbidden(&path).into(),
            _ => ServiceError::LockFile {
                path: path.clone(),
                source,
            },
        };
        std::fs::create_dir_all(dir).map_err(unusable)?;
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .custom_flags(OFlags::NOFOLLOW.bits().cast_signed())
            .open(&path)
            .map_err(unusable)?;
        share_with_folder(&path).map_err(unusable)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut pid = String::new();
                // Without it only the message lacks the process id.
                let _ = file.read_to_string(&mut pid);
                return Err(ServiceError::StoreInUse {
                    pid: pid.trim().to_owned(),
                    dir: dir.to_owned(),
                });
            }
            Err(TryLockError::Error(error)) => return Err(unusable(error)),
        }
        // On a full disk only the message of a second service lacks it.
        let _ = file
            .set_len(0)
            .and_then(|()| file.rewind())
            .and_then(|()| writeln!(file, "{}", std::process::id()));
        Ok(Self { _file: file })
    }
}

#[cfg(test)]
mod tests {
    use super::StoreLock;

    #[test]
    fn a_link_is_not_followed() {
        let dir = tempfile::tempdir().expect("temp dir");
        let victim = dir.path().join("victim");
        std::fs::write(&victim, b"kept").expect("written");
        std::os::unix::fs::symlink(&victim, dir.path().join("patrold.lock")).expect("a link");
        assert!(StoreLock::acquire(dir.path()).is_err());
        assert_eq!(std::fs::read(&victim).expect("there"), b"kept");
    }

    #[test]
    fn the_error_names_the_process_that_holds_the_lock() {
        let dir = tempfile::tempdir().expect("temp dir");
        let first = StoreLock::acquire(dir.path()).expect("free");
        let error = StoreLock::acquire(dir.path())
            .expect_err("locked")
            .to_string();
        let pid = std::process::id();
        assert!(
            error.starts_with(&format!("another patrold (pid {pid}) already uses ")),
            "{error}"
        );
        drop(first);
        StoreLock::acquire(dir.path()).expect("free again");
    }
}
