//! Errors of the store, each with the file and what to do.

use super::advice::{database_advice, file_advice};
use super::disk::rights::{access_remedy, forbidden};
use patrold_engine::blob::BlobError;
use rusqlite::ErrorCode;
use std::io;
use std::path::{Path, PathBuf};

/// A failure of the store.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// A file or folder of the store cannot be used.
    #[error("{}: {source}; {}", path.display(), file_advice(source))]
    File {
        /// File or folder.
        path: PathBuf,
        /// System error.
        source: std::io::Error,
    },
    /// What is left of the disk is kept for alarms.
    #[error("{}: only {free_bytes} bytes are free, which are kept for alarms; make room or lower store.keep_gib", path.display())]
    LowSpace {
        /// The store's database.
        path: PathBuf,
        /// Free bytes.
        free_bytes: u64,
    },
    /// There is no database yet.
    #[error("{}: no database here; start the service, which makes it (systemctl start patrold), or set store.dir", path.display())]
    NoDatabase {
        /// Where it was expected.
        path: PathBuf,
    },
    /// This user may not use the store.
    #[error("{}: this user may not use it; {remedy}", path.display())]
    Forbidden {
        /// The folder or file.
        path: PathBuf,
        /// What to do.
        remedy: String,
    },
    /// There is nothing to rebuild a database from.
    #[error("{}: no journal here; restore a backup: patrold restore DIR", path.display())]
    NoJournal {
        /// Where it was expected.
        path: PathBuf,
    },
    /// A backup whose database is damaged.
    #[error("{}: the database of this backup is damaged: {why}; take another one", path.display())]
    BadBackup {
        /// Its folder.
        path: PathBuf,
        /// The first error that SQLite found.
        why: String,
    },
    /// A store as the backup of itself.
    #[error("{}: this is the folder of the store itself; give another one", path.display())]
    OwnBackup {
        /// Its folder.
        path: PathBuf,
    },
    /// The database does not know what the files belong to.
    #[error("no reference, {files} evidence files; run patrold store rebuild")]
    DatabaseLost {
        /// Evidence files.
        files: usize,
    },
    /// The database belongs to another program.
    #[error("{}: not a patrold database (application id {got:#x}); set store.dir to another folder", path.display())]
    Foreign {
        /// The database.
        path: PathBuf,
        /// Its application id.
        got: i32,
    },
    /// The database was written by a newer program.
    #[error("{}: written by a newer patrold; install that version", path.display())]
    Newer {
        /// The database.
        path: PathBuf,
    },
    /// The database was written by an older program, and a reader must not change it.
    #[error("{}: written by an older patrold; start the service, which migrates it (systemctl start patrold)", path.display())]
    Older {
        /// The database.
        path: PathBuf,
    },
    /// SQLite failed.
    #[error("{}: {}", path.display(), sqlite_text(source))]
    Sqlite {
        /// The database.
        path: PathBuf,
        /// SQLite error.
        source: rusqlite::Error,
    },
    /// A migration failed; the database is unchanged.
    #[error("{}: migration failed: {source}; the database is unchanged, use the patrold that wrote it", path.display())]
    Migration {
        /// The database.
        path: PathBuf,
        /// Migration error.
        source: rusqlite_migration::Error,
    },
    /// No waypoint of that name.
    #[error("unknown waypoint {name:?}; known: {known}; teach it first: patrold teach {name}")]
    UnknownWaypoint {
        /// Name asked for.
        name: String,
        /// Known names.
        known: String,
    },
    /// The waypoint has no reference.
    #[error("waypoint {name:?} has no reference; take one: patrold teach {name}")]
    NoReference {
        /// Its name.
        name: String,
    },
    /// Alarms stand at the waypoint, and a new reference would make what they show normal.
    #[error("{name}: {} not cleared; once {} over teach it again, or make what they show normal: --accept {}", listed(.ids), if .ids.len() == 1 { "it is" } else { "they are" }, joined(.ids, " --accept "))]
    StandingAlarms {
        /// The waypoint.
        name: String,
        /// Those that were not accepted.
        ids: Vec<i64>,
    },
    /// An alarm that cannot be accepted.
    #[error("alarm {id} cannot be accepted: {why}")]
    NotAcceptable {
        /// Number of the alarm.
        id: i64,
        /// Why, and what to do.
        why: String,
    },
    /// A new name that is nearly a known one.
    #[error("no waypoint {name:?}, but {like:?}; for a new one give --new")]
    NameLike {
        /// The new name.
        name: String,
        /// The known one.
        like: String,
    },
    /// No alarm with that number.
    #[error("no alarm {0}; `patrold alarms list` lists them")]
    UnknownAlarm(i64),
    /// No waypoint, known or forgotten, had that name.
    #[error("unknown waypoint {name:?}; the log knows: {known}")]
    NotInLog {
        /// Name asked for.
        name: String,
        /// All names, forgotten ones too.
        known: String,
    },
    /// No visit with that number.
    #[error("no visit {0}; `patrold alarms list --json` names the visit of each alarm")]
    UnknownVisit(i64),
    /// The data of a row was deleted, or never stored.
    #[error("{what} is not in the store: {why}")]
    NotKept {
        /// What was asked for.
        what: String,
        /// Why there is none.
        why: &'static str,
    },
    /// The files of a row could not be written when it was.
    #[error("{what} is not in the store: {why}")]
    EvidenceMissing {
        /// What was asked for.
        what: String,
        /// Why, as the row has it.
        why: String,
    },
    /// The content of a stored file does not match its name.
    #[error(
        "{what}: expected {expected}, got {got}; it is damaged: restore a backup, or teach the waypoint again"
    )]
    Changed {
        /// File.
        what: String,
        /// Content that the name stands for.
        expected: String,
        /// Hash of the content.
        got: String,
    },
    /// A stored view or mixture cannot be decoded.
    #[error(transparent)]
    Blob(#[from] BlobError),
    /// A stored JSON text cannot be read or written.
    #[error("stored {what}: {source}")]
    Record {
        /// Kind of record.
        what: &'static str,
        /// JSON error.
        source: serde_json::Error,
    },
}

fn joined(ids: &[i64], between: &str) -> String {
    let ids: Vec<String> = ids.iter().map(ToString::to_string).collect();
    ids.join(between)
}

fn listed(ids: &[i64]) -> String {
    match ids {
        [id] => format!("alarm {id} is"),
        ids => format!("alarms {} are", joined(ids, ", ")),
    }
}

impl From<rusqlite::Error> for StoreError {
    /// Without a path; [`StoreError::with_path`] adds it.
    fn from(source: rusqlite::Error) -> Self {
        let path = PathBuf::new();
        Self::Sqlite { path, source }
    }
}

impl StoreError {
    /// Whether the disk, the database or another writer is the reason: the same call may succeed later.
    pub(super) fn is_of_storage(&self) -> bool {
        match self {
            Self::File { .. } | Self::LowSpace { .. } => true,
            Self::Sqlite { source, .. } => source
                .sqlite_error_code()
                .is_some_and(|code| code != ErrorCode::ConstraintViolation),
            _ => false,
        }
    }

    /// Whether a file is gone or damaged for good, and reading it again is of no use.
    pub(super) fn is_of_the_file(&self) -> bool {
        match self {
            Self::File { source, .. } => source.kind() == io::ErrorKind::NotFound,
            Self::Changed { .. } => true,
            _ => false,
        }
    }

    /// Whether SQLite could not make a file beside the database.
    pub(super) fn is_of_the_folder(&self) -> bool {
        let Self::Sqlite { source, .. } = self else {
            return false;
        };
        matches!(
            source.sqlite_error_code(),
            Some(ErrorCode::CannotOpen | ErrorCode::ReadOnly | ErrorCode::PermissionDenied)
        )
    }

    /// Whether giving back the reserve may help.
    pub(super) fn is_lack_of_space(&self) -> bool {
        match self {
            Self::LowSpace { .. } => true,
            Self::File { source, .. } => matches!(
                source.kind(),
                io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded
            ),
            // SQLite has no code for a quota: it is an input/output error.
            Self::Sqlite { source, .. } => matches!(
                source.sqlite_error_code(),
                Some(ErrorCode::DiskFull | ErrorCode::SystemIoFailure)
            ),
            _ => false,
        }
    }

    /// This user may not use the file or folder at `path`.
    pub(crate) fn forbidden(path: &Path) -> Self {
        Self::Forbidden {
            path: path.to_owned(),
            remedy: access_remedy(path),
        }
    }

    /// What of the database at `path` this user may not use, where that is the reason.
    pub(super) fn or_forbidden(self, path: &Path) -> Self {
        let may_be = match &self {
            Self::File { source, .. } => source.kind() == io::ErrorKind::PermissionDenied,
            other => other.is_of_the_folder(),
        };
        match forbidden(path).filter(|_| may_be) {
            Some(refused) => Self::forbidden(&refused),
            None => self,
        }
    }

    /// Adds the path of the database.
    pub(super) fn with_path(self, path: &Path) -> Self {
        let path = path.to_owned();
        match self {
            Self::Sqlite { source, .. } => Self::Sqlite { path, source },
            Self::Migration { source, .. } => Self::Migration { path, source },
            other => other,
        }
    }
}

/// The error of SQLite, with advice.
fn sqlite_text(source: &rusqlite::Error) -> String {
    let code = source.sqlite_error_code();
    if let Some(ErrorCode::NotADatabase | ErrorCode::DatabaseCorrupt) = code {
        return format!(
            "not a patrold database, or damaged ({source}); set store.dir to another folder, `patrold restore` a backup, or stop the service and `patrold store rebuild`"
        );
    }
    match code.and_then(database_advice) {
        Some(advice) => format!("{source}; {advice}"),
        None => source.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::StoreError;
    use rusqlite::ffi;
    use std::path::Path;

    #[test]
    fn each_error_names_the_file_and_what_to_do() {
        for (code, advice) in [
            (ffi::SQLITE_NOTADB, "store rebuild"),
            (ffi::SQLITE_CANTOPEN, "may read and write it"),
            (ffi::SQLITE_READONLY, "folder's group"),
            (ffi::SQLITE_BUSY, "another program"),
            (ffi::SQLITE_FULL, "store.keep_gib"),
        ] {
            let source = rusqlite::Error::SqliteFailure(ffi::Error::new(code), None);
            let text = StoreError::from(source)
                .with_path(Path::new("s/patrold.db"))
                .to_string();
            assert!(text.starts_with("s/patrold.db: "), "{text}");
            assert!(text.contains(advice), "{text}");
        }
    }

    /// What is done about an error depends on these: whether it may pass, whether room helps, whether a file is gone for good,
    /// whether a reader can do without the folder.
    #[test]
    fn each_error_is_of_its_kinds_and_of_no_other() {
        let sqlite = |code| {
            let source = rusqlite::Error::SqliteFailure(ffi::Error::new(code), None);
            StoreError::from(source)
        };
        let file = |errno| StoreError::File {
            path: "f".into(),
            source: std::io::Error::from_raw_os_error(errno),
        };
        let low_space = StoreError::LowSpace {
            path: "f".into(),
            free_bytes: 1,
        };
        let changed = StoreError::Changed {
            what: "f".to_owned(),
            expected: "a".to_owned(),
            got: "b".to_owned(),
        };
        for (error, kinds) in [
            (sqlite(ffi::SQLITE_FULL), "storage space"),
            (sqlite(ffi::SQLITE_IOERR), "storage space"),
            (sqlite(ffi::SQLITE_BUSY), "storage"),
            (sqlite(ffi::SQLITE_CORRUPT), "storage"),
            (sqlite(ffi::SQLITE_CANTOPEN), "storage folder"),
            (sqlite(ffi::SQLITE_READONLY), "storage folder"),
            (sqlite(ffi::SQLITE_PERM), "storage folder"),
            (sqlite(ffi::SQLITE_CONSTRAINT), ""),
            // ENOSPC, EDQUOT, EIO, ENOENT, EROFS.
            (file(28), "storage space"),
            (file(122), "storage space"),
            (file(5), "storage"),
            (file(2), "storage gone"),
            (file(30), "storage"),
            (low_space, "storage space"),
            (changed, "gone"),
            (StoreError::UnknownAlarm(7), ""),
        ] {
            let is = [
                ("storage", error.is_of_storage()),
                ("space", error.is_lack_of_space()),
                ("gone", error.is_of_the_file()),
                ("folder", error.is_of_the_folder()),
            ];
            let is: Vec<&str> = is
                .iter()
                .filter(|(_, is)| *is)
                .map(|(kind, _)| *kind)
                .collect();
            assert_eq!(is.join(" "), kinds, "{error}");
        }
    }
}
