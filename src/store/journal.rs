//! The journal: each row that changed, as one line of a file beside the evidence, appended and synced after its
//! transaction. It says which visit a file belongs to and what people did; a lost database is rebuilt from it.
//!
//! Triggers write down which rows changed, in the transaction that changes them, whoever runs it; so a line that could not be
//! appended is appended later. A row may be there several times; the last one counts.

pub(super) mod compaction;
pub(super) mod line;
mod newest_lines;
pub(super) mod position;
pub(super) mod tables;

use super::connection::Store;
use super::error::StoreError;
use line::{JournalLine, row_values};
use rusqlite::{OptionalExtension, Transaction};
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, Read as _, Seek as _, SeekFrom};
use std::path::Path;

/// Rows appended at a time: bounds the memory after a migration, when all of them are new.
const ROWS_AT_A_TIME: u32 = 500;

impl Store {
    /// Appends the rows that changed to the journal. Returns how many.
    ///
    /// # Errors
    /// The disk or the database fails, or what is left of the disk is kept for alarms; nothing is lost then.
    pub fn write_journal(&mut self) -> Result<usize, StoreError> {
        let mut written = 0;
        loop {
            let is_empty = self.query(|db| {
                let sql = "SELECT NOT EXISTS (SELECT 1 FROM unjournaled)";
                Ok(db.query_row(sql, [], |row| row.get::<_, bool>(0))?)
            })?;
            if is_empty {
                return Ok(written);
            }
            self.check_space(0)?;
            let (disk, path) = (self.disk.clone(), self.journal_path().to_owned());
            // In a transaction: two programs never append at the same time, so that the last line of a row is its newest.
            written += self.write(|change| {
                let (lines, rows, last) = changed_rows(change)?;
                let append = || -> io::Result<()> {
                    let torn = ends_torn(&path)?;
                    let mut file = disk.append(&path)?;
                    if torn {
                        file.write(b"\n")?;
                    }
                    file.write(lines.as_bytes())?;
                    file.sync()
                };
                append().map_err(|source| StoreError::File {
                    path: path.clone(),
                    source,
                })?;
                change.execute("DELETE FROM unjournaled WHERE id <= ?1", [last])?;
                Ok(rows)
            })?;
        }
    }
}

/// The lines of the next changed rows, how many there are, and the last entry of the list that they cover.
fn changed_rows(change: &Transaction<'_>) -> Result<(String, usize, i64), StoreError> {
    let mut query =
        change.prepare("SELECT id, table_name, row_id FROM unjournaled ORDER BY id LIMIT ?1")?;
    let entries: Vec<(i64, String, i64)> = query
        .query_map([ROWS_AT_A_TIME], |row| row.try_into())?
        .collect::<Result<_, _>>()?;
    let mut seen = BTreeSet::new();
    let mut lines = String::new();
    for (number, table, id) in &entries {
        if !seen.insert((table, id)) {
            continue;
        }
        let sql = format!("SELECT * FROM \"{table}\" WHERE id = ?1");
        let row = change
            .prepare_cached(&sql)?
            .query_row([id], row_values)
            .optional()?;
        let line = JournalLine {
            number: *number,
            table: table.clone(),
            id: *id,
            row,
        };
        lines.push_str(&line.to_text()?);
    }
    let last = entries.last().map_or(0, |(number, ..)| *number);
    Ok((lines, seen.len(), last))
}

/// Whether the last line was cut off by a stop or a full disk.
fn ends_torn(path: &Path) -> io::Result<bool> {
    let mut file = match File::open(path) {
        Ok(file) => file,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(false),
        Err(error) => return Err(error),
    };
    if file.metadata()?.len() == 0 {
        return Ok(false);
    }
    file.seek(SeekFrom::End(-1))?;
    let mut last = [0];
    file.read_exact(&mut last)?;
    Ok(last != *b"\n")
}
