//! Whether the journal knows changes that the database does not: then the database was lost, or set back.

use super::super::error::StoreError;
use super::line::{JournalLine, read_lines};
use rusqlite::{Connection, OptionalExtension, params};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, Read as _, Seek as _, SeekFrom};
use std::path::Path;

/// The last line is looked for in so many bytes at the end of the journal. The longest line is a reference's mixture, 400
/// components of 104 bytes in hexadecimal digits: 83 kB.
const TAIL_BYTES: u64 = 1 << 20;

/// Notes that the journal is ahead, if it is. Rows that are added from now on have numbers that no row in the journal has,
/// so that both can be joined. Returns how many changes the database does not know.
pub(in crate::store) fn note_journal_ahead(
    db: &Connection,
    journal: &Path,
) -> Result<i64, StoreError> {
    let path_error = |source| StoreError::File {
        path: journal.to_owned(),
        source,
    };
    let noted: Option<i64> = db
        .query_row("SELECT changes FROM journal_ahead", [], |row| row.get(0))
        .optional()?;
    let last = last_number(journal).map_err(path_error)?;
    let known = db
        .query_row(
            "SELECT seq FROM sqlite_sequence WHERE name = 'unjournaled'",
            [],
            |row| row.get(0),
        )
        .optional()?
        .unwrap_or(0);
    if last <= known {
        return Ok(noted.unwrap_or(0));
    }
    let file = File::open(journal).map_err(path_error)?;
    let mut numbers = BTreeMap::from([("unjournaled".to_owned(), last)]);
    read_lines(BufReader::new(file), |line| -> io::Result<()> {
        let number = numbers.entry(line.table).or_insert(0);
        *number = line.id.max(*number);
        Ok(())
    })
    .map_err(path_error)?;
    db.execute_batch("BEGIN IMMEDIATE")?;
    let note = || -> Result<(), StoreError> {
        for (table, number) in &numbers {
            set_last_number(db, table, *number)?;
        }
        db.execute(
            "INSERT INTO journal_ahead (id, changes) VALUES (1, ?1)
             ON CONFLICT (id) DO UPDATE SET changes = changes + ?1",
            params![last - known],
        )?;
        db.execute_batch("COMMIT")?;
        Ok(())
    };
    note().inspect_err(|_| {
        // The first error counts.
        let _ = db.execute_batch("ROLLBACK");
    })?;
    Ok(noted.unwrap_or(0) + last - known)
}

/// Numbers of new rows of a table begin after `last`.
pub(in crate::store) fn set_last_number(
    db: &Connection,
    table: &str,
    last: i64,
) -> Result<(), StoreError> {
    let changed = db.execute(
        "UPDATE sqlite_sequence SET seq = max(seq, ?2) WHERE name = ?1",
        params![table, last],
    )?;
    if changed == 0 {
        let sql = "INSERT INTO sqlite_sequence (name, seq) VALUES (?1, ?2)";
        db.execute(sql, params![table, last])?;
    }
    Ok(())
}

/// Number of the last readable line; 0 without any.
fn last_number(journal: &Path) -> io::Result<i64> {
    let mut file = match File::open(journal) {
        Ok(file) => file,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(0),
        Err(error) => return Err(error),
    };
    let bytes = file.metadata()?.len();
    file.seek(SeekFrom::Start(bytes.saturating_sub(TAIL_BYTES)))?;
    let mut tail = Vec::new();
    file.read_to_end(&mut tail)?;
    let mut last = 0;
    // The first line may be cut: it counts as damaged.
    read_lines(tail.as_slice(), |line: JournalLine| -> io::Result<()> {
        last = line.number.max(last);
        Ok(())
    })?;
    Ok(last)
}
