//! Whether the disk has room for the next visits.

use super::connection::Store;
use super::error::StoreError;
use super::reserve::RESERVE_BYTES;

/// The disk counts as low where it has no room for so many visits more: three rounds of 40 waypoints, a night in which
/// someone can still make room.
const VISITS_AHEAD: u64 = 120;
/// The size of a visit is the mean of the last ones.
const VISITS_MEASURED: u32 = 20;
/// Rows of a visit, twice (database and write-ahead log): see the reserve.
const ROW_BYTES: u64 = 40 << 10;
/// Sweep of a visit as long as none is stored: one of the URG-04LX with its raw data takes 1 to 4 MB.
const ASSUMED_SWEEP_BYTES: u64 = 4 << 20;

/// Room on the disk of the store.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DiskSpace {
    /// Bytes that this user may still write.
    pub free_bytes: u64,
    /// Bytes of one visit, the mean of the last ones.
    pub visit_bytes: u64,
}

impl DiskSpace {
    /// Visits that it has room for, beside the reserve for alarms.
    pub fn visits(&self) -> u64 {
        self.free_bytes.saturating_sub(RESERVE_BYTES) / self.visit_bytes.max(1)
    }

    /// Whether someone has to make room.
    pub fn is_low(&self) -> bool {
        self.visits() < VISITS_AHEAD
    }

    /// Whether there is room again: a quarter more than what counts as low, so that it does not come and go.
    pub fn is_ample(&self) -> bool {
        self.visits() >= VISITS_AHEAD + VISITS_AHEAD / 4
    }
}

impl Store {
    /// Room on the disk.
    ///
    /// # Errors
    /// The disk or the database fails.
    pub fn disk_space(&self) -> Result<DiskSpace, StoreError> {
        let files = self.query(|db| {
            let mut query = db.prepare(
                "SELECT view_file, raw_file, dialogue_file FROM sweep
                 WHERE view_file IS NOT NULL OR raw_file IS NOT NULL OR dialogue_file IS NOT NULL
                 ORDER BY id DESC LIMIT ?1",
            )?;
            let rows = query.query_map([VISITS_MEASURED], |row| {
                let files: [Option<String>; 3] = [row.get(0)?, row.get(1)?, row.get(2)?];
                Ok(files)
            })?;
            Ok(rows.collect::<Result<Vec<_>, _>>()?)
        })?;
        let size = |files: &[Option<String>; 3]| -> u64 {
            files.iter().flatten().map(|f| self.files.size(f)).sum()
        };
        let sizes: Vec<u64> = files.iter().map(size).filter(|size| *size > 0).collect();
        let sweep_bytes = match sizes.len() as u64 {
            0 => ASSUMED_SWEEP_BYTES,
            count => sizes.iter().sum::<u64>() / count,
        };
        Ok(DiskSpace {
            free_bytes: self.free_bytes()?,
            visit_bytes: sweep_bytes + ROW_BYTES,
        })
    }
}
