//! The control socket. The file's mode controls who may connect.

use super::error::ServiceError;
use std::fs::{self, Permissions};
use std::io;
use std::os::unix::fs::{FileTypeExt as _, MetadataExt as _, PermissionsExt as _};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use tokio::net::UnixListener;

/// Dropping it removes the file if it is still ours.
#[derive(Debug)]
pub(super) struct SocketFile {
    path: PathBuf,
    inode: u64,
}

/// Replaces a stale socket at `path`; the new one appears there with its mode set. An error where another program answers,
/// another kind of file is there, or the folder is not writable.
pub(super) fn listen(path: &Path, mode: u32) -> Result<(UnixListener, SocketFile), ServiceError> {
    let unusable = |source| ServiceError::Socket {
        path: path.to_owned(),
        source,
    };
    if let Ok(found) = fs::symlink_metadata(path) {
        if !found.file_type().is_socket() {
            return Err(unusable(io::Error::other("not a socket")));
        }
        if UnixStream::connect(path).is_ok() {
            return Err(ServiceError::SocketInUse {
                path: path.to_owned(),
            });
        }
    }
    let temporary = temporary_path(path);
    match fs::remove_file(&temporary) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(unusable(error)),
        _ => {}
    }
    let listener = UnixListener::bind(&temporary).map_err(unusable)?;
    let moved = fs::set_permissions(&temporary, Permissions::from_mode(mode))
        .and_then(|()| fs::rename(&temporary, path))
        .and_then(|()| fs::metadata(path));
    let inode = moved.map_err(unusable)?.ino();
    let path = path.to_owned();
    Ok((listener, SocketFile { path, inode }))
}

fn temporary_path(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".new");
    PathBuf::from(name)
}

impl Drop for SocketFile {
    fn drop(&mut self) {
        let ours = fs::metadata(&self.path).is_ok_and(|m| m.ino() == self.inode);
        if ours {
            // If it stays, the next start replaces it as stale.
            let _ = fs::remove_file(&self.path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::listen;
    use crate::service::ServiceError;
    use std::os::unix::fs::PermissionsExt as _;

    #[tokio::test]
    async fn only_a_stale_socket_is_replaced() {
        let dir = tempfile::tempdir().expect("temp dir");
        let path = dir.path().join("p.sock");
        drop(std::os::unix::net::UnixListener::bind(&path).expect("a stale socket"));
        let (listener, file) = listen(&path, 0o600).expect("replaced");
        let mode = std::fs::metadata(&path).expect("there").permissions();
        assert_eq!(mode.mode() & 0o777, 0o600);
        let again = listen(&path, 0o600);
        assert!(matches!(again, Err(ServiceError::SocketInUse { .. })));
        drop((listener, file));
        assert!(!path.exists());
        std::fs::write(&path, "notes").expect("a file");
        assert!(listen(&path, 0o600).is_err());
        assert!(path.exists());
    }
}
