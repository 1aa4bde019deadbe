//! Takes settings, gives raw sweeps: a thread per port with the sans-IO driver inside, and the sweep as a machine that
//! needs no thread.
//!
//! | file | takes | gives |
//! |---|---|---|
//! | `driver`, `laser`, `head` | commands, bytes, instants | bytes and events of one device |
//! | `port_name`, `port` | a configured port | a thread that keeps it open and serves its driver |
//! | `inventory` | settings | all serial ports of the machine: what they are, who has them, whose they are |
//! | `wires` | commands | both ports as one, on their threads |
//! | `plan` | settings, identities | one sweep in whole counts |
//! | `calibration_plan` | one request | those of a calibration |
//! | `sweep_run`, `sweep_data` | events of both devices | commands to both, in the end a raw sweep or the reason why not |
//! | `station`, `known`, `head_memory`, `power_mark`, `report` | settings | both devices as one object with blocking calls; what is known of them |

mod calibration_plan;
mod cancel;
mod constants;
mod driver;
mod error;
mod head;
mod head_memory;
mod known;
mod inventory;
mod laser;
mod plan;
mod port;
mod port_name;
mod power_mark;
mod report;
mod station;
mod sweep_data;
mod sweep_run;
mod wires;
#[cfg(test)]
pub(crate) mod lockstep;
#[cfg(test)]
mod on_terminals;

pub use calibration_plan::calibration_requests;
pub use cancel::Cancel;
pub use error::{Device, DeviceError, PortError};
pub use head_memory::HeadMemory;
pub use inventory::{PortReport, inventory};
pub use known::{DeviceNote, NoteLevel};
pub use plan::{SweepPlan, SweepRequest};
pub use report::{AxisReport, DevicesReport, HeadReport, LaserReport};
pub use station::Station;
