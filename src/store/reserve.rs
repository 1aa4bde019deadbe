//! Space on the disk that is kept for alarms: a file that is deleted when the disk is full, so that the row of an alarm
//! finds room. Evidence and quiet visits never use it.

use super::disk::Disk;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Size of the reserve: what the database needs to store alarms until someone makes room. A changed visit with two novelties
/// has 10 kB of text (columns `report` and `record` after `patrold demo --state DIR`), on pages of 4 kB at most 20. Before
/// it gets there it is in the write-ahead log, which grows to 1000 pages and is then reused (SQLite's
/// wal_autocheckpoint): 4 MiB of log and 12 MiB of rows, 600 alarms.
pub(super) const RESERVE_BYTES: u64 = 16 << 20;
/// Written in pieces of this size.
const PIECE_BYTES: usize = 1 << 20;

/// The file that holds the space.
#[derive(Debug)]
pub(super) struct Reserve {
    path: PathBuf,
    disk: Arc<dyn Disk>,
    state: ReserveState,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ReserveState {
    /// This process keeps none.
    Unused,
    Held,
    /// Given to alarms, or the disk had no room for it.
    Released,
}

impl Reserve {
    pub(super) fn new(dir: &Path, disk: Arc<dyn Disk>) -> Self {
        Self {
            path: dir.join("patrold.reserve"),
            disk,
            state: ReserveState::Unused,
        }
    }

    /// Takes the space, if there is room for it and as much again. From now on only alarms may use the last bytes.
    ///
    /// # Errors
    /// The disk refuses it.
    pub(super) fn hold(&mut self) -> io::Result<()> {
        if self.len() == RESERVE_BYTES {
            self.state = ReserveState::Held;
            return Ok(());
        }
        self.state = ReserveState::Released;
        let folder = self.path.parent().unwrap_or(&self.path);
        if self.disk.free_bytes(folder)? < 2 * RESERVE_BYTES {
            return Ok(());
        }
        let written = self.write();
        if written.is_err() {
            // A half of it is no reserve, and the room is needed now.
            let _ = self.disk.remove(&self.path);
        } else {
            self.state = ReserveState::Held;
        }
        written
    }

    /// Gives the space back. Whether there was any.
    pub(super) fn release(&mut self) -> bool {
        if self.state == ReserveState::Held {
            self.state = ReserveState::Released;
        }
        // Also that of another process: its alarms and ours are worth the same.
        self.len() > 0 && self.disk.remove(&self.path).is_ok()
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Whether only alarms may use what is left of the disk.
    pub(super) fn is_released(&self) -> bool {
        self.state == ReserveState::Released
    }

    fn len(&self) -> u64 {
        fs::metadata(&self.path).map_or(0, |file| file.len())
    }

    fn write(&self) -> io::Result<()> {
        let mut file = self.disk.create(&self.path)?;
        // Bytes that no file system compresses or leaves out: a linear congruential sequence (Knuth, MMIX).
        let mut state = 1_u64;
        let mut piece = vec![0; PIECE_BYTES];
        for _ in 0..RESERVE_BYTES / PIECE_BYTES as u64 {
            for byte in &mut piece {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                *byte = (state >> 56) as u8;
            }
            file.write(&piece)?;
        }
        file.sync()
    }
}
