//! What can go wrong with the store, told with the file and what to do.

use patrold_engine::blob::BlobError;
use rusqlite::ErrorCode;
use std::path::{Path, PathBuf};

/// A failure of the store.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// A file or folder of the store cannot be used.
    #[error("{}: {source}; check that the folder exists and that this user may write to it", path.display())]
    File {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// There is no database yet.
    #[error("{}: no database here; start `patrold run` once, or set store.dir", path.display())]
    NoDatabase {
        /// Where it was looked for.
        path: PathBuf,
    },
    /// The database belongs to another program.
    #[error("{}: not a patrold database (application id {got:#x}); set store.dir to another folder", path.display())]
    Foreign {
        /// The database.
        path: PathBuf,
        /// The application id that it carries.
        got: i32,
    },
    /// The database was written by a newer program.
    #[error("{}: written by a newer patrold; install that version, this one would lose data", path.display())]
    Newer {
        /// The database.
        path: PathBuf,
    },
    /// The database was written by an older program, and a reader must not change it.
    #[error("{}: written by an older patrold; start `patrold run` once, which brings it up to date", path.display())]
    Older {
        /// The database.
        path: PathBuf,
    },
    /// SQLite refused.
    #[error("{}: {}", path.display(), told(source))]
    Sqlite {
        /// The database.
        path: PathBuf,
        /// What SQLite said.
        source: rusqlite::Error,
    },
    /// A migration failed; the database is as it was.
    #[error("{}: cannot be brought up to date: {source}; it is as it was: use the patrold that wrote it", path.display())]
    Migration {
        /// The database.
        path: PathBuf,
        /// What went wrong.
        source: rusqlite_migration::Error,
    },
    /// No waypoint of that name.
    #[error("unknown waypoint {name:?}; known: {known}; teach it first: patrold teach {name}")]
    UnknownWaypoint {
        /// The name asked for.
        name: String,
        /// The names there are.
        known: String,
    },
    /// The waypoint has no reference.
    #[error("waypoint {name:?} has no reference; take one: patrold teach {name}")]
    NoReference {
        /// Its name.
        name: String,
    },
    /// No alarm of that number.
    #[error("no alarm {0}; `patrold alarms list` shows those there are")]
    UnknownAlarm(i64),
    /// A name that the log has never heard of.
    #[error("unknown waypoint {name:?}; the log knows: {known}")]
    NotInLog {
        /// The name asked for.
        name: String,
        /// The names there are, forgotten ones too.
        known: String,
    },
    /// No visit of that number.
    #[error("no visit {0}; `patrold alarms list --json` names the visit of each alarm")]
    UnknownVisit(i64),
    /// What a row spoke of is not kept, or never was.
    #[error("{what} is not kept: {why}")]
    NotKept {
        /// What was asked for.
        what: String,
        /// Why it is not there.
        why: &'static str,
    },
    /// A stored file is not what its name says.
    #[error("{what}: expected {expected}, got {got}")]
    Changed {
        /// Which file.
        what: String,
        /// What was expected.
        expected: String,
        /// What was found.
        got: String,
    },
    /// A stored view or mixture does not read.
    #[error(transparent)]
    Blob(#[from] BlobError),
    /// A stored text does not read.
    #[error("stored {what}: {source}")]
    Record {
        /// Which text.
        what: &'static str,
        /// Why.
        source: serde_json::Error,
    },
}

impl From<rusqlite::Error> for StoreError {
    /// Not yet with its file: [`StoreError::in_database`] names it, at the border of the room.
    fn from(source: rusqlite::Error) -> Self {
        let path = PathBuf::new();
        Self::Sqlite { path, source }
    }
}

impl StoreError {
    /// The same failure, naming the database in which it happened.
    pub(super) fn in_database(self, path: &Path) -> Self {
        let path = path.to_owned();
        match self {
            Self::Sqlite { source, .. } => Self::Sqlite { path, source },
            Self::Migration { source, .. } => Self::Migration { path, source },
            other => other,
        }
    }
}

/// What SQLite said, and what to do about it.
fn told(source: &rusqlite::Error) -> String {
    let advice = match source.sqlite_error_code() {
        Some(ErrorCode::NotADatabase | ErrorCode::DatabaseCorrupt) => {
            return format!(
                "not a patrold database, or damaged ({source}); set store.dir to another folder or restore a backup"
            );
        }
        Some(ErrorCode::CannotOpen) => "check that this user may read and write it and its folder",
        Some(ErrorCode::ReadOnly | ErrorCode::PermissionDenied) => {
            "this user may not write it: readers too need to write to its folder; join the folder's group"
        }
        Some(ErrorCode::DatabaseBusy | ErrorCode::DatabaseLocked) => {
            "another program is writing to it; try again, and look for one that hangs"
        }
        Some(ErrorCode::DiskFull) => "the disk is full; make room or lower store.keep_gib",
        Some(ErrorCode::SystemIoFailure) => "the disk fails; check it and the system's log",
        _ => return source.to_string(),
    };
    format!("{source}; {advice}")
}

#[cfg(test)]
mod tests {
    use super::StoreError;
    use rusqlite::ffi;
    use std::path::Path;

    #[test]
    fn each_refusal_names_the_file_and_what_to_do() {
        for (code, advice) in [
            (ffi::SQLITE_NOTADB, "restore a backup"),
            (ffi::SQLITE_CANTOPEN, "may read and write it"),
            (ffi::SQLITE_READONLY, "folder's group"),
            (ffi::SQLITE_BUSY, "another program"),
            (ffi::SQLITE_FULL, "store.keep_gib"),
        ] {
            let source = rusqlite::Error::SqliteFailure(ffi::Error::new(code), None);
            let told = StoreError::from(source)
                .in_database(Path::new("s/patrold.db"))
                .to_string();
            assert!(told.starts_with("s/patrold.db: "), "{told}");
            assert!(told.contains(advice), "{told}");
        }
    }
}
