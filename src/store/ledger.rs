//! The store as the service uses it: no verdict is lost because the disk fails. What it does not take is held in memory and
//! written at the first chance, in order.

use super::backup::swapped_store::SwappedStore;
use super::connection::{RecordTime, Store};
use super::error::StoreError;
use super::held_visits::{HeldVisits, precedes_a_change};
use super::journal::compaction::{CompactionLimits, Compactor};
use super::sweeps::{SweepFiles, SweepRecord};
use super::visits::{NewVisit, VisitOutcome};
use std::collections::{BTreeSet, VecDeque};

/// Bytes of evidence that wait in memory at most, beside those of held visits.
const MAX_WAITING_BYTES: u64 = 128 << 20;

/// A store with what it could not take yet.
#[derive(Debug)]
pub struct Ledger {
    /// Where it goes.
    pub store: Store,
    held: HeldVisits,
    /// Files of sweeps whose rows are stored, oldest first.
    waiting: VecDeque<(i64, SweepFiles)>,
    /// What became of held visits since the last [`retry`](Self::retry).
    unreported: RetryResult,
    /// Of a restore that failed half way and is not undone yet.
    pub(super) half_restored: Option<SwappedStore>,
    pub(super) compactor: Compactor,
}

/// What became of a visit.
#[derive(Debug)]
pub enum VisitRecord {
    /// Its rows are on disk.
    Stored(VisitOutcome),
    /// It is held in memory, because of this.
    Held(StoreError),
    /// Nor is it held, because as many are as can be: the answer to the client is all that there is of it.
    Dropped(StoreError),
}

/// What became of what was held.
#[derive(Debug, Default)]
pub struct RetryResult {
    /// Visits stored, with their waypoint and time.
    pub stored: Vec<(String, RecordTime, VisitOutcome)>,
    /// Visits that will never be stored: their waypoint, time and the reason.
    pub refused: Vec<(String, RecordTime, StoreError)>,
    /// Sweeps whose files were written.
    pub evidence: usize,
    /// Visits still held.
    pub held: usize,
    /// Sweeps whose files still wait.
    pub waiting: usize,
    /// Why, where something is left.
    pub why: Option<StoreError>,
}

impl Ledger {
    /// Of an open store.
    pub fn new(store: Store) -> Self {
        Self {
            store,
            held: HeldVisits::default(),
            waiting: VecDeque::new(),
            unreported: RetryResult::default(),
            half_restored: None,
            compactor: Compactor::new(CompactionLimits::default()),
        }
    }

    /// Compacts the journal under these limits instead of the usual ones.
    pub fn with_compaction(mut self, limits: CompactionLimits) -> Self {
        self.compactor = Compactor::new(limits);
        self
    }

    /// Stores a visit, after those of its waypoint that are held; holds it where the disk or the database fails.
    ///
    /// # Errors
    /// It can never be stored: its waypoint or its reference is unknown.
    pub fn record_visit(
        &mut self,
        visit: &NewVisit<'_>,
        stamp: &RecordTime,
    ) -> Result<VisitRecord, StoreError> {
        let why = self.write_held(Some(visit));
        let blocks = |why: &StoreError| !why.is_lack_of_space() || self.held.has_of(visit.waypoint);
        if let Some(why) = why.filter(blocks) {
            return Ok(self.hold(visit, stamp, why));
        }
        match self.store.record_visit(visit, stamp) {
            Ok(outcome) => {
                self.keep_evidence(visit, &outcome);
                Ok(VisitRecord::Stored(outcome))
            }
            Err(why) if why.is_of_storage() => Ok(self.hold(visit, stamp, why)),
            Err(error) => Err(error),
        }
    }

    fn hold(&mut self, visit: &NewVisit<'_>, stamp: &RecordTime, why: StoreError) -> VisitRecord {
        if self.held.push(visit, stamp) {
            VisitRecord::Held(why)
        } else {
            VisitRecord::Dropped(why)
        }
    }

    /// Tries to write what is held: visits, then evidence.
    pub fn retry(&mut self) -> RetryResult {
        let why = self.write_held(None);
        let mut result = std::mem::take(&mut self.unreported);
        result.why = why;
        while let Some((sweep_id, files)) = self.waiting.pop_front() {
            match self.store.write_evidence_again(sweep_id, &files) {
                Ok(()) => result.evidence += 1,
                Err(error) => {
                    self.waiting.push_front((sweep_id, files));
                    result.why.get_or_insert(error);
                    break;
                }
            }
        }
        result.held = self.held.len();
        result.waiting = self.waiting.len();
        result
    }

    /// Closes the database.
    pub fn close(mut self) {
        // Where it fails, the next start sees by the journal what the database has not.
        let _ = self.undo_restore();
        self.store.close();
    }

    /// Whether [`retry`](Self::retry) has anything to do.
    pub fn is_behind(&self) -> bool {
        self.held.len() > 0 || !self.waiting.is_empty()
    }

    /// Writes held visits in their order. Where only the reserve is left, a waypoint's visits before its last change are
    /// written too, because what a change means depends on them; the rest waits. `next` is the visit that comes after them.
    /// Returns why something is left.
    fn write_held(&mut self, next: Option<&NewVisit<'_>>) -> Option<StoreError> {
        let mut left = VecDeque::new();
        let mut blocked = BTreeSet::new();
        let mut why: Option<StoreError> = None;
        let mut queue = self.held.take_all();
        while let Some(held) = queue.pop_front() {
            let only_space = why.as_ref().is_none_or(StoreError::is_lack_of_space);
            if !only_space || blocked.contains(&held.waypoint) {
                left.push_back(held);
                continue;
            }
            let may_use_reserve = precedes_a_change(&held, &queue, next);
            let visit = held.visit();
            let recorded = self
                .store
                .record_visit_with(&visit, &held.stamp, may_use_reserve);
            match recorded {
                Ok(outcome) => {
                    self.keep_evidence(&visit, &outcome);
                    let stored = (held.waypoint.clone(), held.stamp.clone(), outcome);
                    self.unreported.stored.push(stored);
                }
                Err(error) if error.is_of_storage() => {
                    blocked.insert(held.waypoint.clone());
                    why = Some(error);
                    left.push_back(held);
                }
                Err(_) => {
                    let refused = StoreError::NotKept {
                        what: format!("a visit of {}", held.waypoint),
                        why: "its waypoint or reference went while it was held",
                    };
                    let of = (held.waypoint.clone(), held.stamp.clone(), refused);
                    self.unreported.refused.push(of);
                }
            }
        }
        self.held.put_back(left);
        why
    }

    /// Keeps the files of a sweep that could not be written. Beyond the bound they are not kept: the first evidence of an
    /// alarm matters most.
    fn keep_evidence(&mut self, visit: &NewVisit<'_>, outcome: &VisitOutcome) {
        let files = visit.sweep.as_ref().map(SweepRecord::files);
        let (Some(sweep_id), Some(files), Some(_)) =
            (outcome.sweep_id, files, &outcome.evidence_missing)
        else {
            return;
        };
        let size = |files: &SweepFiles| files.bytes() + files.dialogue_bytes();
        let waiting: u64 = self.waiting.iter().map(|(_, files)| size(files)).sum();
        if waiting + size(&files) <= MAX_WAITING_BYTES {
            self.waiting.push_back((sweep_id, files));
        }
    }
}
