//! The control socket: who may speak to the service is a matter of the file's mode.

use super::error::ServiceError;
use std::fs::{self, Permissions};
use std::io;
use std::os::unix::fs::{FileTypeExt as _, MetadataExt as _, PermissionsExt as _};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use tokio::net::UnixListener;

/// The file of the control socket; dropping it removes the file if it is still ours.
#[derive(Debug)]
pub struct SocketFile {
    path: PathBuf,
    inode: u64,
}

/// Listens at `path` with the file mode `mode`. A socket that nobody answers at is replaced; the new one appears
/// at its place with its mode set.
///
/// # Errors
/// Somebody answers there, something else than a socket is there, or the folder cannot be written.
pub fn listen(path: &Path, mode: u32) -> Result<(UnixListener, SocketFile), ServiceError> {
    let unusable = |source| ServiceError::Socket {
        path: path.to_owned(),
        source,
    };
    if let Ok(found) = fs::symlink_metadata(path) {
        if !found.file_type().is_socket() {
            let what = "there is something else than a socket";
            return Err(unusable(io::Error::other(what)));
        }
        if UnixStream::connect(path).is_ok() {
            return Err(ServiceError::SocketTaken {
                path: path.to_owned(),
            });
        }
    }
    let aside = aside(path);
    match fs::remove_file(&aside) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(unusable(error)),
        _ => {}
    }
    let listener = UnixListener::bind(&aside).map_err(unusable)?;
    let settled = fs::set_permissions(&aside, Permissions::from_mode(mode))
        .and_then(|()| fs::rename(&aside, path))
        .and_then(|()| fs::metadata(path));
    let inode = settled.map_err(unusable)?.ino();
    let path = path.to_owned();
    Ok((listener, SocketFile { path, inode }))
}

fn aside(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".new");
    PathBuf::from(name)
}

impl Drop for SocketFile {
    fn drop(&mut self) {
        let ours = fs::metadata(&self.path).is_ok_and(|m| m.ino() == self.inode);
        if ours {
            // A file that stays is recognised as stale next time.
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
    async fn a_stale_socket_is_replaced_a_live_one_and_a_file_are_not() {
        let dir = tempfile::tempdir().expect("temp dir");
        let path = dir.path().join("p.sock");
        drop(std::os::unix::net::UnixListener::bind(&path).expect("a stale socket"));
        let (listener, file) = listen(&path, 0o600).expect("replaced");
        let mode = std::fs::metadata(&path).expect("there").permissions();
        assert_eq!(mode.mode() & 0o777, 0o600);
        let again = listen(&path, 0o600);
        assert!(matches!(again, Err(ServiceError::SocketTaken { .. })));
        drop((listener, file));
        assert!(!path.exists());
        std::fs::write(&path, "notes").expect("a file");
        assert!(listen(&path, 0o600).is_err());
        assert!(path.exists());
    }
}
