//! Takes what the patrol learnt, gives it back after any stop: waypoints and their reference versions, sweeps,
//! visits, alarms, events. SQLite for rows, files named by their content for big things. The only room that
//! speaks SQL.

mod alarms;
mod error;
mod events;
mod files;
mod handle;
mod novelties;
mod references;
mod retention;
mod sweeps;
mod visits;
mod waypoints;

pub use alarms::{AlarmFilter, AlarmRow};
pub use error::StoreError;
pub use events::{EventRow, Level};
pub use handle::{Stamp, Store};
pub use references::{NewReference, ReferenceRow, StoredReference};
pub use retention::{Retention, Swept};
pub use sweeps::SweepRecord;
pub use visits::{NewVisit, Recorded, StoredVisit};
pub use waypoints::{WaypointDetail, WaypointRow};
