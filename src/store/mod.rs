//! The patrol's records: waypoints and their references, sweeps, visits, alarms, events. SQLite rows, and files named by
//! their content for large data. SQL is used in this module only.

mod alarms;
mod blob_files;
mod checksum;
mod connection;
mod error;
mod events;
mod lookup;
mod new_mixture;
mod novelties;
mod ready_reference;
mod references;
mod retention;
mod stored_mixture;
mod sweeps;
mod visits;
mod waypoints;

pub use alarms::{AlarmFilter, AlarmRow};
pub use connection::{RecordTime, Store};
pub use error::StoreError;
pub use events::EventRow;
pub use new_mixture::NewMixture;
pub use ready_reference::{MadeAnew, ReadyReference, ReferenceError};
pub use references::{NewReference, ReferenceRow, StoredReference};
pub use retention::{Retention, RetentionResult};
pub use stored_mixture::StoredMixture;
pub use sweeps::SweepRecord;
pub use visits::{NewVisit, StoredVisit, VisitOutcome};
pub use waypoints::{WaypointDetail, WaypointRow};
