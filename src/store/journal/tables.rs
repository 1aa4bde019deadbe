//! Which tables the journal has rows of: triggers write down every row that changes, in the transaction that changes it,
//! whichever program runs it.

use super::super::error::StoreError;
use rusqlite::Connection;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// What the journal leaves out: notes of devices, which no verdict depends on, and what serves the journal itself.
const LEFT_OUT: &str = "('event', 'unjournaled', 'journal_ahead')";

/// Where the journal of the store in `dir` is.
pub(in crate::store) fn journal_path(dir: &Path) -> PathBuf {
    dir.join("blobs").join("journal.txt")
}

/// Makes every table write down its changes. Rows of a table that did not so far are written down as new.
pub(in crate::store) fn watch_tables(db: &mut Connection) -> Result<(), StoreError> {
    if unwatched_tables(db)?.is_empty() {
        return Ok(());
    }
    let change = db.transaction()?;
    for table in unwatched_tables(&change)? {
        change.execute_batch(&watching_sql(&table))?;
        change.execute(
            &format!("INSERT INTO unjournaled (table_name, row_id) SELECT ?1, id FROM \"{table}\" ORDER BY id"),
            [&table],
        )?;
    }
    change.commit()?;
    Ok(())
}

/// As [`watch_tables`], without writing down the rows that are there.
pub(in crate::store) fn watch_tables_from_now_on(db: &Connection) -> Result<(), StoreError> {
    for table in unwatched_tables(db)? {
        db.execute_batch(&watching_sql(&table))?;
    }
    Ok(())
}

/// The tables that the journal has rows of.
pub(in crate::store) fn journaled_tables(db: &Connection) -> Result<Vec<String>, StoreError> {
    names(
        db,
        &format!(
            "SELECT name FROM sqlite_schema
             WHERE type = 'table' AND name NOT LIKE 'sqlite_%' AND name NOT IN {LEFT_OUT} ORDER BY name"
        ),
    )
}

fn unwatched_tables(db: &Connection) -> Result<Vec<String>, StoreError> {
    let mut tables = journaled_tables(db)?;
    let watched = names(
        db,
        "SELECT tbl_name FROM sqlite_schema WHERE type = 'trigger' AND name = 'journal_delete_' || tbl_name",
    )?;
    let watched: BTreeSet<String> = watched.into_iter().collect();
    tables.retain(|table| !watched.contains(table));
    Ok(tables)
}

fn names(db: &Connection, sql: &str) -> Result<Vec<String>, StoreError> {
    let mut query = db.prepare(sql)?;
    let rows = query.query_map([], |row| row.get(0))?;
    Ok(rows.collect::<Result<_, _>>()?)
}

fn watching_sql(table: &str) -> String {
    let trigger = |event: &str, row: &str| {
        format!(
            "CREATE TRIGGER \"journal_{event}_{table}\" AFTER {event} ON \"{table}\" BEGIN
                INSERT INTO unjournaled (table_name, row_id) VALUES ('{table}', {row}.id);
             END;\n"
        )
    };
    trigger("insert", "new") + &trigger("update", "new") + &trigger("delete", "old")
}
