//! The open database: one writer, many readers, every change in one transaction.

use super::blob_files::BlobFiles;
use super::disk::rights::{forbidden, share_database};
use super::disk::{Disk, SystemDisk, TransactionStep};
use super::error::StoreError;
use super::journal::position::note_journal_ahead;
use super::journal::tables::{journal_path, watch_tables};
use super::reserve::{RESERVE_BYTES, Reserve};
use rusqlite::{Connection, ErrorCode, OpenFlags, Transaction, TransactionBehavior, ffi};
use rusqlite_migration::{M, MigrationDefinitionError, Migrations};
use std::cmp::Ordering;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

mod record_time;

pub use record_time::RecordTime;
pub(super) use record_time::time_text;

/// "PTRD" in the header of the database file.
const APPLICATION_ID: i32 = 0x5054_5244;
/// How long a writer waits for another one, such as `patrold alarms ack`.
const BUSY_TIMEOUT: Duration = Duration::from_secs(5);

/// The store: database and files.
#[derive(Debug)]
pub struct Store {
    db: Connection,
    path: PathBuf,
    journal_path: PathBuf,
    /// Why the last changes are not in the journal yet.
    journal_error: Option<StoreError>,
    pub(super) disk: Arc<dyn Disk>,
    pub(super) files: BlobFiles,
    pub(super) reserve: Reserve,
}

impl Store {
    /// Opens the store in `dir` for reading and writing; creates it if there is none and migrates an older schema.
    ///
    /// # Errors
    /// The folder cannot be written, or the database is another program's, newer or damaged.
    pub fn open(dir: &Path) -> Result<Self, StoreError> {
        Self::open_on(dir, Arc::new(SystemDisk))
    }

    /// As [`Store::open`], on this disk.
    ///
    /// # Errors
    /// As [`Store::open`].
    pub fn open_on(dir: &Path, disk: Arc<dyn Disk>) -> Result<Self, StoreError> {
        let files = BlobFiles::create(dir, Arc::clone(&disk))?;
        let path = database_path(dir);
        let opened = || -> Result<Connection, StoreError> {
            let mut db = open_database(&path)?;
            watch_tables(&mut db)?;
            note_journal_ahead(&db, &journal_path(dir))?;
            Ok(db)
        };
        let db = match opened() {
            // SQLite needs some room even to open: what is kept for alarms is of no use to a store that does not.
            Err(error) if error.is_lack_of_space() => {
                Reserve::new(dir, Arc::clone(&disk)).release();
                opened()
            }
            done => done,
        };
        let db = db.map_err(|error| error.with_path(&path).or_forbidden(&path))?;
        Ok(Self::from_parts(dir, db, files, disk))
    }

    fn from_parts(dir: &Path, db: Connection, files: BlobFiles, disk: Arc<dyn Disk>) -> Self {
        Self {
            db,
            path: database_path(dir),
            journal_path: journal_path(dir),
            journal_error: None,
            files,
            reserve: Reserve::new(dir, Arc::clone(&disk)),
            disk,
        }
    }

    /// Opens an existing store for reading; the service may be running.
    ///
    /// # Errors
    /// There is none, or it is another program's, newer, or older (a reader does not migrate).
    pub fn open_for_reading(dir: &Path) -> Result<Self, StoreError> {
        Self::open_for_reading_on(dir, Arc::new(SystemDisk))
    }

    /// As [`Store::open_for_reading`], on this disk.
    ///
    /// # Errors
    /// As [`Store::open_for_reading`].
    pub fn open_for_reading_on(dir: &Path, disk: Arc<dyn Disk>) -> Result<Self, StoreError> {
        let path = Self::existing_database(dir)?;
        let db = match open_to_read(&path) {
            // On a read-only file system the -shm cannot be made, which is not needed where nobody writes.
            Err(error) if error.is_of_the_folder() && !has_log(&path) => {
                open_unchanging(&path).map_err(|_| error)
            }
            opened => opened,
        };
        let db = db.map_err(|error| error.with_path(&path).or_forbidden(&path))?;
        let files = BlobFiles::new(dir, Arc::clone(&disk));
        Ok(Self::from_parts(dir, db, files, disk))
    }

    /// Opens an existing store for reading and writing.
    ///
    /// # Errors
    /// As [`Store::open`], or there is none.
    pub fn open_existing(dir: &Path) -> Result<Self, StoreError> {
        Self::existing_database(dir)?;
        Self::open(dir)
    }

    fn existing_database(dir: &Path) -> Result<PathBuf, StoreError> {
        let path = database_path(dir);
        match std::fs::metadata(&path) {
            Ok(file) if file.is_file() => Ok(path),
            Err(error) if error.kind() == io::ErrorKind::PermissionDenied => {
                Err(StoreError::forbidden(dir))
            }
            _ => Err(StoreError::NoDatabase { path }),
        }
    }

    /// Runs a query; an error names the database.
    pub(super) fn query<T>(
        &self,
        run: impl FnOnce(&Connection) -> Result<T, StoreError>,
    ) -> Result<T, StoreError> {
        run(&self.db).map_err(|error| error.with_path(&self.path))
    }

    /// Runs one write transaction. It takes the write lock at once: a transaction that reads first fails when another
    /// writer gets in between. What is left of a full disk is not for it.
    pub(super) fn transaction<T>(
        &mut self,
        run: impl FnOnce(&Transaction<'_>) -> Result<T, StoreError>,
    ) -> Result<T, StoreError> {
        self.check_space(0)?;
        let done = self.write(run)?;
        self.append_to_journal();
        Ok(done)
    }

    /// As [`transaction`](Self::transaction), for an alarm and what people do with it: it may use the reserve. `run` is
    /// called again where that was needed.
    pub(super) fn transaction_with_reserve<T>(
        &mut self,
        run: impl Fn(&Transaction<'_>) -> Result<T, StoreError>,
    ) -> Result<T, StoreError> {
        let done = self.write_with_reserve(run)?;
        self.append_to_journal();
        Ok(done)
    }

    /// As [`transaction_with_reserve`](Self::transaction_with_reserve); the journal follows with the next change.
    pub(super) fn write_with_reserve<T>(
        &mut self,
        run: impl Fn(&Transaction<'_>) -> Result<T, StoreError>,
    ) -> Result<T, StoreError> {
        match self.write(&run) {
            Err(error) if error.is_lack_of_space() && self.reserve.release() => self.write(&run),
            done => done,
        }
    }

    /// Appends what changed to the journal. A failure is no failure of the change: the rows stay noted in the database, and
    /// the next change or the upkeep appends them.
    pub(super) fn append_to_journal(&mut self) {
        self.journal_error = self.write_journal().err();
    }

    /// Why the last changes are not in the journal yet; `None`: they are.
    pub fn journal_error(&self) -> Option<&StoreError> {
        self.journal_error.as_ref()
    }

    pub(super) fn database_path(&self) -> &Path {
        &self.path
    }

    /// The disk under it.
    pub fn disk(&self) -> Arc<dyn Disk> {
        Arc::clone(&self.disk)
    }

    /// Its folder.
    pub fn dir(&self) -> &Path {
        self.path.parent().unwrap_or(&self.path)
    }

    pub(super) fn journal_path(&self) -> &Path {
        &self.journal_path
    }

    /// Fails where `bytes` more would need the space that is kept for alarms.
    pub(super) fn check_space(&self, bytes: u64) -> Result<(), StoreError> {
        if !self.reserve.is_released() {
            return Ok(());
        }
        // Where the free space is unknown, the write is tried.
        let free_bytes = self.disk.free_bytes(&self.path).unwrap_or(u64::MAX);
        if free_bytes >= RESERVE_BYTES.saturating_add(bytes) {
            return Ok(());
        }
        let path = self.path.clone();
        Err(StoreError::LowSpace { path, free_bytes })
    }

    /// Bytes that this user may still write.
    pub(super) fn free_bytes(&self) -> Result<u64, StoreError> {
        self.disk
            .free_bytes(&self.path)
            .map_err(|source| StoreError::File {
                path: self.path.clone(),
                source,
            })
    }

    /// Takes the space that is kept for alarms, where there is room for it; from then on nothing else may use the last
    /// bytes of the disk. For the service alone.
    ///
    /// # Errors
    /// The disk fails.
    pub fn hold_reserve(&mut self) -> Result<(), StoreError> {
        self.reserve.hold().map_err(|source| StoreError::File {
            path: self.reserve.path().to_owned(),
            source,
        })
    }

    /// Writes the write-ahead log back into the database, as far as no reader needs it.
    pub(super) fn fold_log(&self) {
        let _ = write_back(&self.db);
    }

    /// Closes the database; where nobody else has it open, its file is whole by itself then. A failure leaves the
    /// write-ahead log, which is as good.
    pub fn close(self) {
        // Fails, without harm, while another program reads.
        let _ = write_back(&self.db);
        let _ = self.db.close();
    }

    /// Runs one write transaction, whatever is left of the disk; the journal follows with the next change.
    pub(super) fn write<T>(
        &mut self,
        run: impl FnOnce(&Transaction<'_>) -> Result<T, StoreError>,
    ) -> Result<T, StoreError> {
        let disk = &self.disk;
        let step = |step| {
            let failure = |code| rusqlite::Error::SqliteFailure(ffi::Error::new(code), None);
            disk.transaction_step(step).map_err(failure)
        };
        let run_and_commit = || {
            step(TransactionStep::Begin)?;
            let change = self
                .db
                .transaction_with_behavior(TransactionBehavior::Immediate)?;
            let done = run(&change)?;
            step(TransactionStep::Commit)?;
            change.commit()?;
            Ok(done)
        };
        run_and_commit().map_err(|error: StoreError| error.with_path(&self.path))
    }
}

pub(super) fn database_path(dir: &Path) -> PathBuf {
    dir.join("patrold.db")
}

fn open_to_read(path: &Path) -> Result<Connection, StoreError> {
    let db = Connection::open_with_flags(path, OpenFlags::SQLITE_OPEN_READ_ONLY)?;
    db.busy_timeout(BUSY_TIMEOUT)?;
    check_readable(db, path)
}

/// For a database that nobody can write to: SQLite makes and locks nothing beside it.
fn open_unchanging(path: &Path) -> Result<Connection, StoreError> {
    let mut uri = "file:".to_owned();
    for byte in path.as_os_str().as_encoded_bytes() {
        // What a URI gives another meaning, and what is not ASCII; the rest may stand in it as it is.
        match byte {
            b'%' | b'?' | b'#' | 0x80.. => uri.push_str(&format!("%{byte:02x}")),
            byte => uri.push(char::from(*byte)),
        }
    }
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_URI;
    check_readable(
        Connection::open_with_flags(uri + "?immutable=1", flags)?,
        path,
    )
}

/// Whether changes are in the write-ahead log alone.
fn has_log(path: &Path) -> bool {
    let mut log = path.as_os_str().to_owned();
    log.push("-wal");
    std::fs::metadata(log).is_ok_and(|file| file.len() > 0)
}

fn check_readable(db: Connection, path: &Path) -> Result<Connection, StoreError> {
    check_owner(&db, path)?;
    let version: i64 = db.pragma_query_value(None, "user_version", |row| row.get(0))?;
    let path = path.to_owned();
    match version.cmp(&(MIGRATIONS.len() as i64)) {
        Ordering::Less => Err(StoreError::Older { path }),
        Ordering::Equal => Ok(db),
        Ordering::Greater => Err(StoreError::Newer { path }),
    }
}

/// Writes the write-ahead log back into the database and empties it.
pub(super) fn write_back(db: &Connection) -> rusqlite::Result<()> {
    db.query_row("PRAGMA wal_checkpoint(TRUNCATE)", [], |_| Ok(()))
}

/// Opens or creates the database at `path` and migrates it.
pub(super) fn open_database(path: &Path) -> Result<Connection, StoreError> {
    share_database(path).map_err(|source| StoreError::File {
        path: path.to_owned(),
        source,
    })?;
    // SQLite would open it all the same, and refuse the first write.
    if let Some(file) = forbidden(path) {
        return Err(StoreError::forbidden(&file));
    }
    let mut db = Connection::open(path)?;
    db.busy_timeout(BUSY_TIMEOUT)?;
    check_owner(&db, path)?;
    db.pragma_update(None, "journal_mode", "WAL")?;
    db.pragma_update(None, "synchronous", "FULL")?;
    db.pragma_update(None, "foreign_keys", "ON")?;
    migrations()
        .to_latest(&mut db)
        .map_err(|e| migration_error(e, path))?;
    Ok(db)
}

/// Each is one transaction: it is applied as a whole or not at all.
const MIGRATIONS: &[M<'static>] = &[
    M::up(include_str!("../../migrations/0001_patrol.sql")),
    M::up(include_str!("../../migrations/0002_reference_mixture.sql")),
    M::up(include_str!("../../migrations/0003_evidence.sql")),
    M::up(include_str!("../../migrations/0004_sighting.sql")),
    M::up(include_str!("../../migrations/0005_log_queries.sql")),
    M::up(include_str!("../../migrations/0006_dialogue.sql")),
];

fn migrations() -> Migrations<'static> {
    Migrations::from_slice(MIGRATIONS)
}

fn migration_error(error: rusqlite_migration::Error, path: &Path) -> StoreError {
    let path = path.to_owned();
    match error {
        rusqlite_migration::Error::MigrationDefinition(
            MigrationDefinitionError::DatabaseTooFarAhead,
        ) => StoreError::Newer { path },
        // The disk, not the migration: with what to do about it.
        rusqlite_migration::Error::RusqliteError { err, .. }
            if matches!(
                err.sqlite_error_code(),
                Some(ErrorCode::DiskFull | ErrorCode::SystemIoFailure | ErrorCode::ReadOnly)
            ) =>
        {
            StoreError::Sqlite { path, source: err }
        }
        source => StoreError::Migration { path, source },
    }
}

/// Refuses a database of another program; an empty one is accepted. One statement, so that no other process changes the
/// database between two reads.
fn check_owner(db: &Connection, path: &Path) -> Result<(), StoreError> {
    let (got, tables): (i32, i64) = db.query_row(
        "SELECT application_id, (SELECT count(*) FROM sqlite_schema) FROM pragma_application_id",
        [],
        |row| Ok((row.get(0)?, row.get(1)?)),
    )?;
    if got == APPLICATION_ID || (got == 0 && tables == 0) {
        return Ok(());
    }
    let path = path.to_owned();
    Err(StoreError::Foreign { path, got })
}

#[cfg(test)]
mod tests {
    use super::{
        APPLICATION_ID, BlobFiles, MIGRATIONS, Store, has_log, migration_error, migrations,
        open_unchanging,
    };
    use crate::store::{StoreError, StoredMixture, SystemDisk};
    use nalgebra::Point3;
    use patrold_engine::blob::encode_view;
    use patrold_engine::geometry::View;
    use rusqlite::Connection;
    use rusqlite_migration::Migrations;
    use std::path::Path;
    use std::sync::Arc;

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

    /// A database of the first version with one reference, whose view the store can read.
    fn first_version(dir: &Path) -> Connection {
        let mut db = Connection::open(dir.join("patrold.db")).expect("database");
        Migrations::from_slice(&MIGRATIONS[..1])
            .to_latest(&mut db)
            .expect("the first version");
        let view = View::from_points(vec![Point3::new(1.0, 0.0, 0.0)], Point3::origin());
        let files = BlobFiles::create(dir, Arc::new(SystemDisk)).expect("folder");
        let file = files.put(&encode_view(&view)).expect("stored");
        db.execute_batch(&format!(
            "INSERT INTO waypoint (name, created_at) VALUES ('hall', '');
             INSERT INTO sweep (waypoint_id, taken_at, boot_id, points, view_file, quality)
             VALUES (1, '', '', 1, '{file}', '{{}}');
             INSERT INTO reference (waypoint_id, version, sweep_id, taken_at, boot_id, components, seed, engine, mixture)
             VALUES (1, 1, 1, '', '', 30, 7, '{{}}', x'0101');"
        ))
        .expect("rows");
        db
    }

    #[test]
    fn a_reference_of_the_first_version_is_outdated() {
        let dir = tempfile::tempdir().expect("temp dir");
        drop(first_version(dir.path()));
        let reading = Store::open_for_reading(dir.path()).expect_err("older");
        assert!(matches!(reading, StoreError::Older { .. }), "{reading}");
        let store = Store::open(dir.path()).expect("migrated");
        let reference = store.reference("hall").expect("its reference");
        assert_eq!(reference.mixture, StoredMixture::Outdated);
        assert_eq!((reference.checksum, reference.components), (None, 30));
        drop(Store::open_for_reading(dir.path()).expect("reader"));
    }

    #[test]
    fn a_migration_is_applied_as_a_whole_or_not_at_all() {
        let dir = tempfile::tempdir().expect("temp dir");
        let db = first_version(dir.path());
        // The last statement of the second migration fails.
        db.execute_batch("ALTER TABLE reference ADD COLUMN model TEXT")
            .expect("added");
        let failed = Store::open(dir.path()).expect_err("not migrated");
        assert!(matches!(failed, StoreError::Migration { .. }), "{failed}");
        let columns =
            "SELECT count(*) FROM pragma_table_info('reference') WHERE name = 'mixture_sha256'";
        let added: i64 = db.query_row(columns, [], |row| row.get(0)).expect("asked");
        let version: i64 = db
            .pragma_query_value(None, "user_version", |row| row.get(0))
            .expect("version");
        assert_eq!((added, version), (0, 1));
        db.execute_batch("ALTER TABLE reference DROP COLUMN model")
            .expect("dropped");
        drop(Store::open(dir.path()).expect("migrated now"));
    }

    #[test]
    fn a_stop_right_after_the_migration_leaves_our_database() {
        let dir = tempfile::tempdir().expect("temp dir");
        let mut db = Connection::open(dir.path().join("patrold.db")).expect("database");
        migrations().to_latest(&mut db).expect("migrated");
        let id: i32 = db
            .pragma_query_value(None, "application_id", |row| row.get(0))
            .expect("id");
        assert_eq!(id, APPLICATION_ID);
        drop(db);
        drop(Store::open(dir.path()).expect("ours"));
    }

    #[test]
    fn a_reader_refuses_an_older_database() {
        let dir = tempfile::tempdir().expect("temp dir");
        drop(Store::open(dir.path()).expect("store"));
        let db = Connection::open(dir.path().join("patrold.db")).expect("opens");
        db.pragma_update(None, "user_version", 0).expect("set");
        let reading = Store::open_for_reading(dir.path()).expect_err("older");
        assert!(matches!(reading, StoreError::Older { .. }), "{reading}");
        assert!(
            reading.to_string().contains("systemctl start patrold"),
            "{reading}"
        );
    }

    #[test]
    fn a_change_waits_for_another_writer_and_builds_on_what_it_wrote() {
        let dir = tempfile::tempdir().expect("temp dir");
        let mut store = Store::open(dir.path()).expect("store");
        let other = Connection::open(dir.path().join("patrold.db")).expect("another");
        let rows = "SELECT count(*) FROM waypoint";
        store
            .transaction(|change| {
                let before: i64 = change.query_row(rows, [], |row| row.get(0))?;
                other.busy_timeout(std::time::Duration::ZERO)?;
                let refused = other.execute(
                    "INSERT INTO waypoint (name, created_at) VALUES ('b', '')",
                    [],
                );
                assert!(
                    refused.is_err(),
                    "no one writes between reading and writing"
                );
                change.execute(
                    "INSERT INTO waypoint (name, created_at) VALUES ('a', '')",
                    [],
                )?;
                assert_eq!(before, 0);
                Ok(())
            })
            .expect("changed");
    }

    #[test]
    fn a_database_that_nobody_can_write_to_is_read_whatever_its_folder_is_called() {
        let dir = tempfile::tempdir().expect("temp dir");
        for name in ["plain", "a b", "what?x=1", "50%", "#7", "küche", "%41"] {
            let folder = dir.path().join(name);
            std::fs::create_dir(&folder).expect("folder");
            let mut store = Store::open(&folder).expect("store");
            let insert = "INSERT INTO waypoint (name, created_at) VALUES (?1, '')";
            let written = store.transaction(|change| Ok(change.execute(insert, [name])?));
            written.expect("written");
            store.close();
            let before = std::fs::read_dir(&folder).expect("listed").count();
            let path = folder.join("patrold.db");
            let db = open_unchanging(&path).unwrap_or_else(|error| panic!("{name}: {error}"));
            let found: String = db
                .query_row("SELECT name FROM waypoint", [], |row| row.get(0))
                .expect("read");
            assert_eq!(found, name);
            assert!(db.execute(insert, ["another"]).is_err(), "{name}");
            assert!(!has_log(&path), "{name}");
            let after = std::fs::read_dir(&folder).expect("listed").count();
            assert_eq!(after, before, "{name}: nothing is made beside it");
        }
        let missing = open_unchanging(&dir.path().join("none/patrold.db"));
        assert!(missing.is_err());
    }

    /// SQLite makes the -shm beside the database; where it cannot, a reader needs it only if changes are in the log alone.
    #[test]
    fn a_folder_that_takes_no_file_is_read_where_nothing_is_in_the_log() {
        let dir = tempfile::tempdir().expect("temp dir");
        let mut store = Store::open(dir.path()).expect("store");
        let insert = "INSERT INTO waypoint (name, created_at) VALUES ('hall', '')";
        let written = store.transaction(|change| Ok(change.execute(insert, [])?));
        written.expect("written");
        let copy = tempfile::tempdir().expect("temp dir");
        for name in ["patrold.db", "patrold.db-wal"] {
            std::fs::copy(dir.path().join(name), copy.path().join(name)).expect("copied");
        }
        store.close();
        for (place, has_log) in [(&dir, false), (&copy, true)] {
            let place = place.path();
            // A link of that name, which SQLite does not follow: root may write where nobody may.
            let shared = place.join("patrold.db-shm");
            let _ = std::fs::remove_file(&shared);
            std::os::unix::fs::symlink("nowhere", &shared).expect("in the way");
            let read = Store::open_for_reading(place).and_then(|store| store.waypoints());
            match read {
                // Never without what is in the log.
                Ok(waypoints) => assert_eq!(waypoints.len(), 1, "{has_log}"),
                Err(error) => assert!(has_log, "{error}"),
            }
        }
    }

    #[test]
    fn a_disk_that_fails_during_a_migration_is_no_fault_of_the_migration() {
        let path = Path::new("s/patrold.db");
        let failed = |code| {
            let err = rusqlite::Error::SqliteFailure(rusqlite::ffi::Error::new(code), None);
            let query = "ALTER TABLE".to_owned();
            migration_error(
                rusqlite_migration::Error::RusqliteError { query, err },
                path,
            )
        };
        use rusqlite::ffi;
        for code in [ffi::SQLITE_FULL, ffi::SQLITE_IOERR, ffi::SQLITE_READONLY] {
            let error = failed(code);
            assert!(matches!(error, StoreError::Sqlite { .. }), "{error}");
            assert!(error.to_string().starts_with("s/patrold.db: "), "{error}");
        }
        for code in [ffi::SQLITE_ERROR, ffi::SQLITE_CONSTRAINT] {
            let error = failed(code);
            assert!(matches!(error, StoreError::Migration { .. }), "{error}");
        }
    }
}
