//! Laser and pan-tilt head: settings in, raw sweeps out. Each port has a thread that runs the sans-IO driver; a sweep is a
//! state machine without threads.
//!
//! | file | input | output |
//! |---|---|---|
//! | `device_driver`, `laser`, `head` | commands, bytes, times | bytes and events of one device |
//! | `port_config`, `port` | a configured port | a thread that keeps it open and runs its driver |
//! | `inventory` | settings | all serial ports of the machine: device, holders, configuration key |
//! | `device_links` | commands | messages of both port threads |
//! | `plan` | request, settings, identities | one sweep in counts |
//! | `calibration_plan` | one request | the requests of a calibration |
//! | `sweep_run`, `sweep_data` | events of both devices | commands for both; a raw sweep or an error |
//! | `recording` | what ports and station do in a sweep | its dialogue as bytes, and from these the sweep again |
//! | `position_trust`, `power_marker` | what happens to the head | whether its counts are angles |
//! | `station`, `device_state`, `report` | settings | both devices as one object with blocking calls; their state |

mod calibration_plan;
mod cancel;
mod constants;
mod device_driver;
mod device_links;
mod device_state;
mod error;
mod head;
mod inventory;
mod laser;
mod plan;
mod port;
mod port_config;
mod position_trust;
mod power_marker;
mod recording;
mod report;
mod station;
mod sweep_data;
mod sweep_run;
#[cfg(test)]
pub(crate) mod lockstep;
#[cfg(test)]
mod on_terminals;

pub use calibration_plan::calibration_requests;
pub use cancel::Cancel;
pub use device_state::DeviceNote;
pub use error::{Device, DeviceError, PortError};
pub use inventory::{PortReport, inventory};
pub use plan::{AngleSettings, SweepRequest};
pub use position_trust::PositionTrust;
pub use recording::{
    DialogueEnd, DialogueEntry, DialogueEntryKind, DialogueError, ReplayError, ReplayedSweep,
    SweepDialogue, replay_sweep,
};
pub use report::{AxisReport, DeviceSurvey, DevicesReport, HeadReport, LaserReport};
pub use station::Station;
