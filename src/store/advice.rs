//! What to do about an error of the system or of SQLite.

use rusqlite::ErrorCode;
use rustix::io::Errno;
use std::io;

/// For an error of the system at a file or folder of the store.
pub(super) fn file_advice(error: &io::Error) -> &'static str {
    match error.raw_os_error().map(Errno::from_raw_os_error) {
        Some(Errno::NOSPC) => "the disk is full; make room or lower store.keep_gib",
        Some(Errno::DQUOT) => {
            "the disk quota of this user is used up; raise it or lower store.keep_gib"
        }
        Some(Errno::IO) => {
            "the disk fails; see the kernel's log (journalctl -k), replace the disk, then restore a backup"
        }
        Some(Errno::MFILE) => {
            "this process has too many open files; raise LimitNOFILE= of its unit and report what is open (ls /proc/PID/fd)"
        }
        Some(Errno::NFILE) => {
            "the system has too many open files; find who holds them (lsof) or raise fs.file-max"
        }
        Some(Errno::ROFS) => {
            "its file system is mounted read-only; see the kernel's log (journalctl -k), check it and mount it read-write"
        }
        Some(Errno::ACCESS | Errno::PERM) => {
            "this user may not; check owner and mode of the folder"
        }
        Some(Errno::NOENT) => {
            "it is gone; `patrold store check` lists what is missing, `patrold restore` brings back a backup"
        }
        _ => "check that the folder exists and that this user may write to it",
    }
}

/// For an error of SQLite; `None`: its text says enough.
pub(super) fn database_advice(code: ErrorCode) -> Option<&'static str> {
    Some(match code {
        ErrorCode::CannotOpen => {
            "check that this user may read and write it and its folder, and that LimitNOFILE= of its unit suffices"
        }
        ErrorCode::ReadOnly | ErrorCode::PermissionDenied => {
            "readers too need write access to its folder; add this user to the folder's group, or mount the file system read-write"
        }
        ErrorCode::DatabaseBusy | ErrorCode::DatabaseLocked => {
            "another program is writing to it; try again"
        }
        ErrorCode::DiskFull => "the disk is full; make room or lower store.keep_gib",
        ErrorCode::SystemIoFailure => {
            "the disk fails, or the quota of this user is used up; see the kernel's log (journalctl -k)"
        }
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::file_advice;
    use rustix::io::Errno;
    use std::collections::BTreeSet;
    use std::io;

    #[test]
    fn each_errno_has_its_own_advice() {
        let all = [
            Errno::NOSPC,
            Errno::DQUOT,
            Errno::IO,
            Errno::MFILE,
            Errno::NFILE,
            Errno::ROFS,
            Errno::ACCESS,
            Errno::NOENT,
            Errno::BADF,
        ];
        let advice = all.map(|errno| file_advice(&io::Error::from(errno)));
        assert_eq!(BTreeSet::from(advice).len(), all.len());
        let one_line = |text: &&str| !text.contains('\n') && !text.is_empty();
        assert!(advice.iter().all(one_line));
    }
}
