//! The patrol's records: waypoints and their references, sweeps, visits, alarms, events. SQLite rows, and files named by
//! their content for large data. SQL is used in this module only.

mod advice;
mod alarms;
mod blob_files;
mod checksum;
mod connection;
mod disk;
mod error;
mod events;
mod evidence;
mod held_visits;
mod ledger;
mod lookup;
mod new_mixture;
mod novelties;
mod ready_reference;
mod references;
mod reserve;
mod retention;
mod space;
mod stored_mixture;
mod sweeps;
mod upkeep;
mod visits;
mod waypoints;

pub use alarms::{AlarmFilter, AlarmRow};
pub use connection::{RecordTime, Store};
pub use disk::{Disk, DiskFile, SystemDisk, TransactionStep};
pub use error::StoreError;
pub use events::EventRow;
pub use ledger::{Ledger, RetryResult, VisitRecord};
pub use new_mixture::NewMixture;
pub use ready_reference::{MadeAnew, ReadyReference, ReferenceError};
pub use references::{NewReference, ReferenceRow, StoredReference};
pub use retention::{Retention, RetentionResult};
pub use space::DiskSpace;
pub use stored_mixture::StoredMixture;
pub use sweeps::SweepRecord;
pub use upkeep::{StorageReport, StoreStart};
pub use visits::{NewVisit, StoredVisit, VisitOutcome};
pub use waypoints::{WaypointDetail, WaypointRow};
