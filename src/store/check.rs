//! Looks whether the store is whole: the database, its evidence files, its journal. Changes nothing.

use super::connection::Store;
use super::error::StoreError;
use super::journal::line::{JournalLine, read_lines};
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{self, BufReader};

/// Errors of the database that are listed at most; the first ones show the kind of damage.
const MAX_DATABASE_ERRORS: u32 = 20;

/// What a check found.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct StoreCheck {
    /// Errors of the database; empty: it is sound.
    pub database_errors: Vec<String>,
    /// Evidence files that rows name and that are sound.
    pub evidence_files: usize,
    /// Evidence that rows name and that is not there or is damaged.
    pub missing: Vec<MissingEvidence>,
    /// Sound or damaged files that no row names.
    pub unnamed: Vec<UnnamedFile>,
    /// Half-written files.
    pub half_written: Vec<String>,
    /// The journal.
    pub journal: JournalCheck,
}

/// Evidence that is not there or is damaged.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct MissingEvidence {
    /// Sequence number of the sweep.
    pub sweep_id: i64,
    /// Visit that the sweep belongs to; null for one of a reference.
    pub visit_id: Option<i64>,
    /// Name of its waypoint.
    pub waypoint: String,
    /// File name.
    pub file: String,
    /// What is wrong.
    pub why: String,
}

/// A file that no row names.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct UnnamedFile {
    /// File name.
    pub file: String,
    /// Its size.
    pub bytes: u64,
}

/// The state of the journal.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct JournalCheck {
    /// Lines that can be read.
    pub lines: usize,
    /// Lines that cannot.
    pub damaged_lines: usize,
    /// Changed rows that are not in it yet.
    pub waiting_rows: i64,
    /// Changes that it knows and the database does not.
    pub ahead: i64,
}

impl StoreCheck {
    /// Whether nothing is missing or damaged. A file that no row names is no damage.
    pub fn is_sound(&self) -> bool {
        self.database_errors.is_empty()
            && self.missing.is_empty()
            && self.journal.damaged_lines == 0
            && self.journal.ahead == 0
    }
}

struct SweepFile {
    sweep_id: i64,
    visit_id: Option<i64>,
    waypoint: String,
    file: String,
}

impl Store {
    /// Checks the database, each evidence file against its checksum, and the journal. `progress` is called with the number
    /// of files done and of all.
    ///
    /// # Errors
    /// The database cannot be read at all.
    pub fn check(&self, mut progress: impl FnMut(usize, usize)) -> Result<StoreCheck, StoreError> {
        let mut check = StoreCheck {
            database_errors: self.integrity_errors()?,
            half_written: self.files.half_written()?,
            journal: self.check_journal()?,
            ..StoreCheck::default()
        };
        let named = self.sweep_files()?;
        for (done, sweep) in named.iter().enumerate() {
            progress(done, named.len());
            match self.files.get(&sweep.file) {
                Ok(_) => check.evidence_files += 1,
                Err(error) => check.missing.push(MissingEvidence {
                    sweep_id: sweep.sweep_id,
                    visit_id: sweep.visit_id,
                    waypoint: sweep.waypoint.clone(),
                    file: sweep.file.clone(),
                    why: error.to_string(),
                }),
            }
        }
        check.unnamed = self
            .unnamed_files()?
            .into_iter()
            .map(|file| UnnamedFile {
                bytes: self.files.size(&file),
                file,
            })
            .collect();
        Ok(check)
    }

    /// What is damaged in the database, and which references in use cannot be read; a line each, with what to do.
    ///
    /// # Errors
    /// The database cannot be read at all.
    pub fn find_damage(&self) -> Result<Vec<String>, StoreError> {
        let mut damage = Vec::new();
        if let Some(error) = self.integrity_errors()?.first() {
            damage.push(format!(
                "{}: the database is damaged: {}; stop the service and run patrold store rebuild, or restore a backup",
                self.database_path().display(),
                error.replace('\n', " ")
            ));
        }
        for waypoint in self.waypoints()? {
            match self.reference(&waypoint.name) {
                Ok(_) | Err(StoreError::NoReference { .. }) => {}
                Err(error) => damage.push(format!("the reference of {}: {error}", waypoint.name)),
            }
        }
        Ok(damage)
    }

    fn integrity_errors(&self) -> Result<Vec<String>, StoreError> {
        self.query(|db| {
            let sql = format!("PRAGMA integrity_check({MAX_DATABASE_ERRORS})");
            let mut query = db.prepare(&sql)?;
            let rows = query.query_map([], |row| row.get(0))?;
            let mut errors: Vec<String> = rows.collect::<Result<_, _>>()?;
            errors.retain(|text| text != "ok");
            Ok(errors)
        })
    }

    fn sweep_files(&self) -> Result<Vec<SweepFile>, StoreError> {
        self.query(|db| {
            let mut query = db.prepare(
                "SELECT s.id, (SELECT min(v.id) FROM visit v WHERE v.sweep_id = s.id), w.name, f.file
                 FROM (SELECT id, view_file AS file FROM sweep WHERE view_file IS NOT NULL
                       UNION ALL SELECT id, raw_file FROM sweep WHERE raw_file IS NOT NULL
                       UNION ALL SELECT id, dialogue_file FROM sweep WHERE dialogue_file IS NOT NULL) f
                 JOIN sweep s ON s.id = f.id JOIN waypoint w ON w.id = s.waypoint_id
                 ORDER BY s.id, f.file",
            )?;
            let rows = query.query_map([], |row| {
                Ok(SweepFile {
                    sweep_id: row.get(0)?,
                    visit_id: row.get(1)?,
                    waypoint: row.get(2)?,
                    file: row.get(3)?,
                })
            })?;
            Ok(rows.collect::<Result<_, _>>()?)
        })
    }

    fn check_journal(&self) -> Result<JournalCheck, StoreError> {
        let (waiting_rows, ahead) = self.query(|db| {
            let sql = "SELECT (SELECT count(*) FROM unjournaled),
                              coalesce((SELECT changes FROM journal_ahead), 0)";
            Ok(db.query_row(sql, [], |row| row.try_into())?)
        })?;
        let mut check = JournalCheck {
            waiting_rows,
            ahead,
            ..JournalCheck::default()
        };
        let path = self.journal_path();
        let read = || -> io::Result<(usize, usize)> {
            let file = match File::open(path) {
                Ok(file) => file,
                Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok((0, 0)),
                Err(error) => return Err(error),
            };
            let mut lines = 0;
            let damaged = read_lines(BufReader::new(file), |_: JournalLine| -> io::Result<()> {
                lines += 1;
                Ok(())
            })?;
            Ok((lines, damaged))
        };
        (check.lines, check.damaged_lines) = read().map_err(|source| StoreError::File {
            path: path.to_owned(),
            source,
        })?;
        Ok(check)
    }
}
