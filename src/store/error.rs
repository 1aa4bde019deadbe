//! What can go wrong with the store, told with the file and what to do.

use std::path::PathBuf;

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
    /// The file is no database at all, or was damaged.
    #[error("{}: not a patrold database, or damaged ({source}); set store.dir to another folder or restore a backup", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What SQLite said.
        source: rusqlite::Error,
    },
    /// SQLite refused.
    #[error("database: {0}")]
    Sqlite(#[from] rusqlite::Error),
    /// A migration failed; the database is as it was.
    #[error("database migration: {0}")]
    Migration(rusqlite_migration::Error),
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
    /// No visit of that number.
    #[error("no visit {0}")]
    UnknownVisit(i64),
    /// A stored blob does not read.
    #[error("{what}: expected {expected}, got {got}")]
    Blob {
        /// Which blob.
        what: String,
        /// What was expected.
        expected: String,
        /// What was found.
        got: String,
    },
    /// A stored text does not read.
    #[error("stored {what}: {source}")]
    Record {
        /// Which text.
        what: &'static str,
        /// Why.
        source: serde_json::Error,
    },
}
