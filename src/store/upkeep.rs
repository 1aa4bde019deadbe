//! The upkeep of the store while the service runs: at its start, and then every few seconds.

use super::error::StoreError;
use super::journal::compaction::CompactedJournal;
use super::ledger::{Ledger, RetryResult};
use super::space::DiskSpace;

/// What the start of a service found in the store.
#[derive(Debug, Default)]
pub struct StoreStart {
    /// Half-written files deleted.
    pub half_written: usize,
    /// Sweeps whose files were never written.
    pub evidence_missing: usize,
    /// Evidence files of a store whose database was lost.
    pub lost_files: Option<usize>,
    /// What could not be done; the service runs all the same.
    pub failures: Vec<StoreError>,
}

/// What the upkeep found and did.
#[derive(Debug)]
pub struct StorageReport {
    /// What was held.
    pub retry: RetryResult,
    /// Why the last changes are not in the journal.
    pub journal_error: Option<String>,
    /// The journal, where it was compacted now.
    pub compacted: Result<Option<CompactedJournal>, StoreError>,
    /// Room on the disk.
    pub space: Result<DiskSpace, StoreError>,
}

impl Ledger {
    /// Puts the store in order before the first visit. Only for the holder of the service's lock.
    pub fn start(&mut self) -> StoreStart {
        let mut start = StoreStart::default();
        match self.store.delete_half_written() {
            Ok(deleted) => start.half_written = deleted.sweeps,
            Err(error) => start.failures.push(error),
        }
        self.compactor.reset(&self.store);
        match self.store.settle_evidence() {
            Ok(missing) => start.evidence_missing = missing,
            Err(error) => start.failures.push(error),
        }
        match self.store.is_lost() {
            Ok(true) => start.lost_files = self.store.count_files().ok(),
            Ok(false) => {}
            Err(error) => start.failures.push(error),
        }
        start
    }

    /// Writes what is held, takes the reserve where it is not held, looks how much room there is.
    pub fn maintain(&mut self) -> StorageReport {
        // Where it fails it is tried again next time; visits are stored all the same.
        let _ = self.undo_restore();
        let retry = self.retry();
        // Where the disk is full it is tried again next time; where it fails, `retry` and the visits say so.
        let _ = self.store.hold_reserve();
        self.store.append_to_journal();
        let compacted = self.compactor.step(&mut self.store);
        StorageReport {
            retry,
            journal_error: self.store.journal_error().map(ToString::to_string),
            compacted,
            space: self.store.disk_space(),
        }
    }
}
