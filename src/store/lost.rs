//! Whether the database was lost: files or a journal are there that it does not know.

use super::connection::Store;
use super::error::StoreError;
use rusqlite::OptionalExtension;

impl Store {
    /// Changes that the journal knows and the database does not.
    ///
    /// # Errors
    /// The database fails.
    pub fn changes_lost(&self) -> Result<i64, StoreError> {
        self.query(|db| {
            let ahead = db.query_row("SELECT changes FROM journal_ahead", [], |row| row.get(0));
            Ok(ahead.optional()?.unwrap_or(0))
        })
    }

    /// Whether what the database does not know may be in the files: it has lost changes, or it has no reference at all
    /// though there are evidence files.
    ///
    /// # Errors
    /// The disk or the database fails.
    pub fn is_lost(&self) -> Result<bool, StoreError> {
        if self.changes_lost()? > 0 {
            return Ok(true);
        }
        let has_reference: bool = self.query(|db| {
            let sql = "SELECT EXISTS (SELECT 1 FROM reference)";
            Ok(db.query_row(sql, [], |row| row.get(0))?)
        })?;
        Ok(!has_reference && self.count_files()? > 0)
    }

    /// Evidence files, whether or not a row names them.
    ///
    /// # Errors
    /// The folder cannot be read.
    pub fn count_files(&self) -> Result<usize, StoreError> {
        Ok(self.files.names()?.len())
    }
}
