//! Rebuilds the database from the journal and the evidence files. The old database is kept under another name.

use super::backup::replace_database::{put_in_place, remove_database};
use super::connection::{RecordTime, Store, database_path, open_database, write_back};
use super::disk::{Disk, SystemDisk};
use super::error::StoreError;
use super::evidence::EvidenceGaps;
use super::journal::line::{JournalLine, read_lines};
use super::journal::position::set_last_number;
use super::journal::tables::{journal_path, journaled_tables, watch_tables_from_now_on};
use rusqlite::{Connection, params_from_iter};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What a rebuild found and made.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct RebuildResult {
    /// Rows by table.
    pub rows: BTreeMap<String, i64>,
    /// Lines of the journal that could not be read.
    pub damaged_lines: usize,
    /// Rows left out because a row that they belong to is not in the journal.
    pub incomplete_rows: usize,
    /// Sweeps whose files are not there or are damaged.
    pub evidence_missing: usize,
    /// EvidenceGaps files that still no row names.
    pub unnamed_files: usize,
    /// Where the old database is now; null: there was none.
    pub old_database: Option<PathBuf>,
}

impl Store {
    /// Rebuilds the database of the store in `dir` from its journal. What the old one knows and the journal does not yet is
    /// taken too, as far as it can be read. Only for the holder of the service's lock.
    ///
    /// # Errors
    /// There is no journal, or the disk fails; the old database is in its place then.
    pub fn rebuild(dir: &Path, stamp: &RecordTime) -> Result<RebuildResult, StoreError> {
        let (old, new) = (database_path(dir), dir.join("patrold.db.rebuild"));
        // The last changes are perhaps only in the old one. One that does not open has none that can be had.
        if let Some(mut store) = old.is_file().then(|| Self::open(dir).ok()).flatten() {
            store.write_journal()?;
            store.close();
        }
        let journal = journal_path(dir);
        let file_error = |path: &Path| {
            let path = path.to_owned();
            move |source| StoreError::File { path, source }
        };
        let file = File::open(&journal).map_err(|source| match source.kind() {
            io::ErrorKind::NotFound => StoreError::NoJournal {
                path: journal.clone(),
            },
            _ => file_error(&journal)(source),
        })?;
        let disk: Arc<dyn Disk> = Arc::new(SystemDisk);
        remove_database(&*disk, &new);
        let db = open_database(&new).map_err(|error| error.with_path(&new))?;
        let mut result = RebuildResult::default();
        let rebuild = || -> Result<(), StoreError> {
            db.pragma_update(None, "foreign_keys", "OFF")?;
            // One transaction: SQLite would sync after each row.
            db.execute_batch("BEGIN IMMEDIATE")?;
            let mut columns = BTreeMap::new();
            for table in journaled_tables(&db)? {
                let known = db.prepare(&format!("SELECT * FROM \"{table}\""))?;
                let names: BTreeSet<String> = known
                    .column_names()
                    .into_iter()
                    .map(str::to_owned)
                    .collect();
                drop(known);
                columns.insert(table, names);
            }
            let mut last = 0;
            let mut failed = None;
            let read = read_lines(BufReader::new(file), |line| -> io::Result<()> {
                last = last.max(line.number);
                put_row(&db, &columns, line).map_err(|error| {
                    failed = Some(error);
                    io::Error::other("a row was refused")
                })
            });
            result.damaged_lines =
                read.map_err(|error| failed.unwrap_or_else(|| file_error(&journal)(error)))?;
            result.incomplete_rows = remove_incomplete(&db)?;
            set_last_number(&db, "unjournaled", last)?;
            keep_events(&db, &old);
            watch_tables_from_now_on(&db)?;
            db.execute_batch("COMMIT")?;
            db.pragma_update(None, "foreign_keys", "ON")?;
            for table in columns.keys() {
                let sql = format!("SELECT count(*) FROM \"{table}\"");
                let count = db.query_row(&sql, [], |row| row.get(0))?;
                result.rows.insert(table.clone(), count);
            }
            write_back(&db)?;
            Ok(())
        };
        rebuild().map_err(|error| error.with_path(&new))?;
        drop(db);
        let (mut old, done) = put_in_place(&*disk, dir, &new, "rebuild", stamp);
        done.inspect_err(|_| {
            // The first error counts.
            let _ = old.undo(&*disk);
        })?;
        result.old_database = old.kept;
        disk.sync_folder(dir).map_err(file_error(dir))?;

        let mut store = Self::open(dir)?;
        result.evidence_missing = store.mark_missing_evidence()?;
        result.unnamed_files = store.unnamed_files()?.len();
        store.write_journal()?;
        store.close();
        Ok(result)
    }

    /// Marks the sweeps whose files are not there or are damaged. Returns how many.
    fn mark_missing_evidence(&mut self) -> Result<usize, StoreError> {
        let sweeps = self.query(|db| {
            let mut query = db.prepare(
                "SELECT id, evidence, evidence_why, dialogue_why, view_file, raw_file, dialogue_file FROM sweep
                 WHERE view_file IS NOT NULL OR raw_file IS NOT NULL OR dialogue_file IS NOT NULL ORDER BY id",
            )?;
            let rows = query.query_map([], |row| {
                let known = EvidenceGaps {
                    view_and_raw: row.get(2)?,
                    dialogue: row.get(3)?,
                };
                let is_settled = row.get::<_, String>(1)? != "pending";
                let files: [Option<String>; 3] = [row.get(4)?, row.get(5)?, row.get(6)?];
                Ok((row.get::<_, i64>(0)?, is_settled, known, files))
            })?;
            Ok(rows.collect::<Result<Vec<_>, _>>()?)
        })?;
        let mut missing = 0;
        for (id, is_settled, known, [view, raw, dialogue]) in sweeps {
            let read = |file: &String| self.files.get(file).err();
            let damage = view.iter().chain(&raw).find_map(read);
            let lost = dialogue.iter().find_map(read);
            missing += usize::from(damage.is_some() || lost.is_some());
            let mut errors = damage.iter().chain(&lost);
            // The disk did not let it be read now.
            if errors.any(|error| !error.is_of_the_file()) {
                continue;
            }
            // The first reason stays.
            let why = |error: Option<StoreError>, known: &Option<String>| {
                error.map(|error| known.clone().unwrap_or_else(|| error.to_string()))
            };
            let found = EvidenceGaps {
                view_and_raw: why(damage, &known.view_and_raw),
                dialogue: match dialogue {
                    Some(_) => why(lost, &known.dialogue),
                    None => known.dialogue.clone(),
                },
            };
            if found != known || !is_settled {
                self.mark_evidence(id, &found)?;
            }
        }
        Ok(missing)
    }
}

fn put_row(
    db: &Connection,
    columns: &BTreeMap<String, BTreeSet<String>>,
    line: JournalLine,
) -> Result<(), StoreError> {
    // A table of a newer program, or of an older one: its rows stay in the journal.
    let Some(known) = columns.get(&line.table) else {
        return Ok(());
    };
    let table = &line.table;
    let Some(mut row) = line.row else {
        let sql = format!("DELETE FROM \"{table}\" WHERE id = ?1");
        db.prepare_cached(&sql)?.execute([line.id])?;
        return Ok(());
    };
    row.retain(|(name, _)| known.contains(name));
    let names: Vec<String> = row.iter().map(|(name, _)| format!("\"{name}\"")).collect();
    let places: Vec<String> = (1..=row.len()).map(|at| format!("?{at}")).collect();
    let sql = format!(
        "INSERT OR REPLACE INTO \"{table}\" ({}) VALUES ({})",
        names.join(", "),
        places.join(", ")
    );
    let values = row.into_iter().map(|(_, value)| value);
    db.prepare_cached(&sql)?.execute(params_from_iter(values))?;
    Ok(())
}

/// Removes rows that refer to a row that is not there, until none is left.
fn remove_incomplete(db: &Connection) -> Result<usize, StoreError> {
    let mut removed = 0;
    loop {
        let mut query = db.prepare("SELECT \"table\", rowid FROM pragma_foreign_key_check")?;
        let broken: BTreeSet<(String, i64)> = query
            .query_map([], |row| row.try_into())?
            .collect::<Result<_, _>>()?;
        if broken.is_empty() {
            return Ok(removed);
        }
        for (table, id) in &broken {
            let sql = format!("DELETE FROM \"{table}\" WHERE id = ?1");
            removed += db.execute(&sql, [id])?;
        }
    }
}

/// Takes over the event log of the old database, as far as it can be read: the journal has none.
fn keep_events(db: &Connection, old: &Path) {
    let take = || -> rusqlite::Result<()> {
        let old = Connection::open_with_flags(old, rusqlite::OpenFlags::SQLITE_OPEN_READ_ONLY)?;
        let mut query =
            old.prepare("SELECT id, at, boot_id, level, device, text FROM event ORDER BY id")?;
        let mut rows = query.query([])?;
        while let Some(row) = rows.next()? {
            let values: Vec<rusqlite::types::Value> =
                (0..6).map(|at| row.get(at)).collect::<Result<_, _>>()?;
            db.execute(
                "INSERT INTO event (id, at, boot_id, level, device, text) VALUES (?1, ?2, ?3, ?4, ?5, ?6)",
                params_from_iter(values),
            )?;
        }
        Ok(())
    };
    // Without it nothing is missing that a verdict depends on.
    let _ = take();
}
