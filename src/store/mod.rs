//! The patrol's records: waypoints and their references, sweeps, visits, alarms, events. SQLite rows, and files named by
//! their content for large data. SQL is used in this module only.

mod advice;
mod alarms;
mod backup;
mod blob_files;
mod check;
mod checksum;
mod connection;
mod disk;
mod error;
mod events;
mod evidence;
mod held_visits;
mod journal;
mod ledger;
mod lookup;
mod lost;
mod newest;
mod novelties;
mod past;
mod rebuild;
mod references;
mod reserve;
mod restore;
mod retention;
mod space;
mod sweeps;
mod time_range;
mod upkeep;
mod visit_log;
mod visits;
mod waypoints;

pub use alarms::health::{HealthEvent, HealthRow};
pub use alarms::incidents::{AlarmEffects, AlarmSighting};
pub use alarms::{
    AlarmFilter, AlarmRow, FloorPlace, LastSighting, NearFilter, SightingRow, ThingFilter,
};
pub use backup::BackupResult;
pub use check::{JournalCheck, MissingEvidence, StoreCheck, UnnamedFile};
pub use connection::{RecordTime, Store};
pub use disk::{Disk, DiskFile, SystemDisk, TransactionStep, access_remedy, share_with_folder};
pub use error::StoreError;
pub use events::{EventFilter, EventRow};
pub use journal::compaction::{CompactedJournal, CompactionLimits};
pub use ledger::{Ledger, RetryResult, VisitRecord};
pub use rebuild::RebuildResult;
pub use references::new_mixture::NewMixture;
pub use references::ready_reference::{MadeAnew, ReadyReference, ReferenceError};
pub use references::stored_mixture::StoredMixture;
pub use references::{NewReference, ReferenceFrame, ReferenceRow, StoredReference};
pub use restore::PreparedRestore;
pub use retention::{Retention, RetentionResult};
pub use space::DiskSpace;
pub use sweeps::SweepRecord;
pub use time_range::TimeRange;
pub use upkeep::{StorageReport, StoreStart};
pub use visit_log::{VisitDetail, VisitFilter, VisitRow};
pub use visits::{NewVisit, StoredVisit, VisitOutcome};
pub use waypoints::{WaypointDetail, WaypointRow};
