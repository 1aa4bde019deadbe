//! Opening the database: one writer, many readers, nothing half.

use super::error::StoreError;
use super::files::Files;
use rusqlite::{Connection, ErrorCode, OpenFlags};
use rusqlite_migration::{M, MigrationDefinitionError, Migrations};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// "PTRD" in the header of the database file.
const APPLICATION_ID: i32 = 0x5054_5244;
/// How long a writer waits for another one (an acknowledging guard, say) before it gives up.
const BUSY_TIMEOUT: Duration = Duration::from_secs(5);

/// When something happened, and in which run of the machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Stamp {
    /// Wall clock, UTC.
    pub at: jiff::Timestamp,
    /// The kernel's boot id, because the clock may be wrong.
    pub boot_id: String,
}

impl Stamp {
    /// The form that stands in the database: RFC 3339, UTC, milliseconds always, so that texts sort as times.
    pub fn text(&self) -> String {
        time_text(self.at)
    }
}

/// RFC 3339 in UTC with milliseconds.
pub(super) fn time_text(at: jiff::Timestamp) -> String {
    format!("{at:.3}")
}

/// The open store.
#[derive(Debug)]
pub struct Store {
    pub(super) db: Connection,
    pub(super) files: Files,
}

impl Store {
    /// Opens the store in `dir` for reading and writing; makes it where there is none and brings an older
    /// schema up to date.
    ///
    /// # Errors
    /// The folder cannot be written, the database is another program's, newer, or broken.
    pub fn open(dir: &Path) -> Result<Self, StoreError> {
        let files = Files::create(dir)?;
        let path = database_path(dir);
        let named = |error| opening_error(error, &path);
        let mut db = Connection::open(&path).map_err(named)?;
        db.busy_timeout(BUSY_TIMEOUT)?;
        check_owner(&db, &path)?;
        db.pragma_update(None, "journal_mode", "WAL")
            .map_err(named)?;
        db.pragma_update(None, "synchronous", "FULL")?;
        db.pragma_update(None, "foreign_keys", "ON")?;
        migrations()
            .to_latest(&mut db)
            .map_err(|e| migration_error(e, &path))?;
        db.pragma_update(None, "application_id", APPLICATION_ID)?;
        Ok(Self { db, files })
    }

    /// Opens an existing store for reading, whether or not the service runs.
    ///
    /// # Errors
    /// There is none, it is another program's or newer.
    pub fn open_for_reading(dir: &Path) -> Result<Self, StoreError> {
        let path = Self::existing(dir)?;
        let db = Connection::open_with_flags(&path, OpenFlags::SQLITE_OPEN_READ_ONLY)
            .map_err(|error| opening_error(error, &path))?;
        db.busy_timeout(BUSY_TIMEOUT)?;
        check_owner(&db, &path)?;
        let version: i64 = db.pragma_query_value(None, "user_version", |row| row.get(0))?;
        if version > MIGRATIONS.len() as i64 {
            return Err(StoreError::Newer { path });
        }
        let files = Files::at(dir);
        Ok(Self { db, files })
    }

    /// Opens an existing store for reading and writing; makes none.
    ///
    /// # Errors
    /// As [`Store::open`], and where there is none.
    pub fn open_existing(dir: &Path) -> Result<Self, StoreError> {
        Self::existing(dir)?;
        Self::open(dir)
    }

    fn existing(dir: &Path) -> Result<PathBuf, StoreError> {
        let path = database_path(dir);
        if path.is_file() {
            Ok(path)
        } else {
            Err(StoreError::NoDatabase { path })
        }
    }
}

fn database_path(dir: &Path) -> PathBuf {
    dir.join("patrold.db")
}

const MIGRATIONS: &[M<'static>] = &[M::up(include_str!("../../migrations/0001_patrol.sql"))];

fn migrations() -> Migrations<'static> {
    Migrations::from_slice(MIGRATIONS)
}

fn migration_error(error: rusqlite_migration::Error, path: &Path) -> StoreError {
    match error {
        rusqlite_migration::Error::MigrationDefinition(
            MigrationDefinitionError::DatabaseTooFarAhead,
        ) => StoreError::Newer {
            path: path.to_owned(),
        },
        other => StoreError::Migration(other),
    }
}

/// What SQLite says while it opens a file, with the file.
fn opening_error(error: rusqlite::Error, path: &Path) -> StoreError {
    let path = path.to_owned();
    match error.sqlite_error_code() {
        Some(ErrorCode::NotADatabase | ErrorCode::DatabaseCorrupt) => StoreError::Damaged {
            path,
            source: error,
        },
        Some(ErrorCode::CannotOpen | ErrorCode::ReadOnly | ErrorCode::PermissionDenied) => {
            StoreError::File {
                path,
                source: std::io::Error::other(error),
            }
        }
        _ => error.into(),
    }
}

fn check_owner(db: &Connection, path: &Path) -> Result<(), StoreError> {
    let named = |error| opening_error(error, path);
    let got: i32 = db
        .pragma_query_value(None, "application_id", |row| row.get(0))
        .map_err(named)?;
    let tables: i64 = db
        .query_row("SELECT count(*) FROM sqlite_schema", [], |row| row.get(0))
        .map_err(named)?;
    if got == APPLICATION_ID || (got == 0 && tables == 0) {
        return Ok(());
    }
    let path = path.to_owned();
    Err(StoreError::Foreign { path, got })
}

#[cfg(test)]
mod tests {
    use super::{Store, migrations};
    use crate::store::StoreError;
    use rusqlite::Connection;

    #[test]
    fn the_migrations_apply_to_an_empty_database() {
        migrations().validate().expect("valid migrations");
    }

    #[test]
    fn a_store_opens_again_and_reads_without_a_writer() {
        let dir = tempfile::tempdir().expect("temp dir");
        drop(Store::open(dir.path()).expect("new store"));
        drop(Store::open(dir.path()).expect("old store"));
        drop(Store::open_for_reading(dir.path()).expect("reader"));
    }

    #[test]
    fn missing_foreign_and_newer_databases_are_refused() {
        let dir = tempfile::tempdir().expect("temp dir");
        let missing = Store::open_for_reading(dir.path());
        assert!(matches!(missing, Err(StoreError::NoDatabase { .. })));

        let db = Connection::open(dir.path().join("patrold.db")).expect("foreign database");
        db.execute_batch("CREATE TABLE cat (name TEXT)")
            .expect("table");
        assert!(matches!(
            Store::open(dir.path()),
            Err(StoreError::Foreign { .. })
        ));
        db.execute_batch("DROP TABLE cat").expect("dropped");
        drop(db);

        drop(Store::open(dir.path()).expect("ours now"));
        let db = Connection::open(dir.path().join("patrold.db")).expect("opens");
        db.pragma_update(None, "user_version", 99).expect("set");
        drop(db);
        assert!(matches!(
            Store::open(dir.path()),
            Err(StoreError::Newer { .. })
        ));
        let reading = Store::open_for_reading(dir.path());
        assert!(matches!(reading, Err(StoreError::Newer { .. })));
    }
}
