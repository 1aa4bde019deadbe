//! The newest rows of a long table, by index: numbers first, whole rows afterwards.
//!
//! Rows are ordered by number, because the clock may be wrong. A stretch of time takes the newest by their stamps, and all of a
//! clock that was not set count as inside; both are found without reading the rows that are passed over.

use super::error::StoreError;
use super::time_range::{CLOCK_SET_FROM, TimeRange};
use rusqlite::types::Value;
use rusqlite::{Connection, params_from_iter};

/// Conditions that hold together, in SQL with `?`, and their values in order.
#[derive(Debug, Clone, Default)]
pub(super) struct Conditions {
    sql: Vec<String>,
    values: Vec<Value>,
}

impl Conditions {
    pub(super) fn require(
        &mut self,
        sql: impl Into<String>,
        values: impl IntoIterator<Item = Value>,
    ) {
        self.sql.push(sql.into());
        self.values.extend(values);
    }

    /// All of `more` too.
    pub(super) fn extend(&mut self, more: &Self) {
        self.sql.extend(more.sql.iter().cloned());
        self.values.extend(more.values.iter().cloned());
    }

    pub(super) fn require_some<T: Into<Value>>(&mut self, sql: &str, value: Option<T>) {
        if let Some(value) = value {
            self.require(sql, [value.into()]);
        }
    }

    /// The stamp in `column` is in `range`, or of a clock that was not set.
    pub(super) fn require_range(&mut self, column: &str, range: &TimeRange) {
        if !range.is_all() {
            let sql = format!("({column} BETWEEN ? AND ? OR {column} < '{CLOCK_SET_FROM}')");
            self.require(sql, range.bounds().map(Value::from));
        }
    }

    /// `WHERE ...`, or nothing.
    pub(super) fn to_where(&self) -> String {
        if self.sql.is_empty() {
            String::new()
        } else {
            format!("WHERE {}", self.sql.join(" AND "))
        }
    }

    pub(super) fn values(&self) -> &[Value] {
        &self.values
    }
}

/// Numbers of the newest `limit` rows of `table` that meet one of `branches` and lie in `range`, newest first. Each branch is
/// one walk along an index, so it holds equalities only.
pub(super) fn newest_ids(
    db: &Connection,
    table: &str,
    branches: &[Conditions],
    range: &TimeRange,
    limit: u32,
) -> Result<Vec<i64>, StoreError> {
    let mut ids = Vec::new();
    for branch in branches {
        if range.is_all() {
            read_ids(db, table, branch, "id DESC", limit, &mut ids)?;
            continue;
        }
        let mut known = branch.clone();
        known.require("at >= ? AND at <= ?", range.bounds().map(Value::from));
        read_ids(db, table, &known, "at DESC, id DESC", limit, &mut ids)?;
        // A literal, so that the partial index is found.
        let mut unset = branch.clone();
        unset.require(format!("at < '{CLOCK_SET_FROM}'"), []);
        read_ids(db, table, &unset, "id DESC", limit, &mut ids)?;
    }
    ids.sort_unstable_by(|a, b| b.cmp(a));
    ids.dedup();
    ids.truncate(limit as usize);
    Ok(ids)
}

fn read_ids(
    db: &Connection,
    table: &str,
    conditions: &Conditions,
    order: &str,
    limit: u32,
    ids: &mut Vec<i64>,
) -> Result<(), StoreError> {
    let condition = conditions.to_where();
    let sql = format!("SELECT id FROM {table} {condition} ORDER BY {order} LIMIT {limit}");
    let mut query = db.prepare_cached(&sql)?;
    let found = query.query_map(params_from_iter(conditions.values()), |row| row.get(0))?;
    for id in found {
        ids.push(id?);
    }
    Ok(())
}
