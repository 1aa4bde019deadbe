//! Events of the patrol, and the requests of its clients.

use super::turn_history::SeenTurn;
use std::fmt;

/// What a request asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PatrolTask {
    /// Compare the place with its reference.
    Visit,
    /// Take the place's reference.
    Teach,
    /// Take a sweep and return its points.
    Sweep,
}

impl PatrolTask {
    /// As in the API and the log.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Visit => "visit",
            Self::Teach => "teach",
            Self::Sweep => "sweep",
        }
    }
}

/// A request of a client.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PatrolRequest {
    /// Number within this run of the service.
    pub id: u64,
    /// Visit, teach or sweep.
    pub task: PatrolTask,
    /// Name of the waypoint; empty for a sweep.
    pub waypoint: String,
}

/// Why a request was refused; nothing is stored for it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RefusalReason {
    /// The queue is full.
    Busy,
    /// The service is stopping.
    Stopping,
    /// No such waypoint.
    UnknownWaypoint(String),
    /// The waypoint has no reference.
    NoReference(String),
    /// Somebody has to decide first: alarms stand.
    Undecided(String),
    /// Somebody has to decide first: the name is nearly a known one.
    NearName {
        /// The known name.
        known: String,
        /// One line.
        why: String,
    },
    /// The devices failed.
    NoSweep(String),
    /// The quality of the sweep is too poor for a reference or for export.
    BadSweep(String),
    /// The disk, the database or the engine failed.
    Failed(String),
}

impl fmt::Display for RefusalReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Busy => f.write_str("busy: too many requests are waiting; try again later"),
            Self::Stopping => f.write_str("the service is stopping"),
            Self::UnknownWaypoint(why)
            | Self::NoReference(why)
            | Self::Undecided(why)
            | Self::NoSweep(why)
            | Self::BadSweep(why)
            | Self::NearName { why, .. }
            | Self::Failed(why) => f.write_str(why),
        }
    }
}

/// What a changed configuration requires.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SettingsChange {
    /// The devices can stay open.
    KeepDevices,
    /// The devices must be reopened.
    ReopenDevices,
}

/// Input of the state machine. A `u64` is the number of a request; events of other than the current request are ignored.
#[derive(Debug, Clone, PartialEq)]
pub enum PatrolEvent {
    /// The devices are connected and homed.
    DevicesReady,
    /// The head was homed, whoever asked for it; comes before what followed.
    HeadHomed,
    /// The homing that the patrol asked for is over.
    HomingDone,
    /// The devices could not be opened.
    DevicesFailed(String),
    /// A device is absent.
    DevicesAbsent(String),
    /// A device was lost while idle.
    DevicesLost(String),
    /// The devices are released: laser off, head stopped.
    DevicesClosed,
    /// A client sent a request.
    Requested(PatrolRequest),
    /// The client of a request has disconnected.
    ClientGone(u64),
    /// The client of a request asked to end it.
    Cancelled(u64),
    /// The waypoint's reference is loaded, or the request is refused.
    Prepared(u64, Result<(), RefusalReason>),
    /// The sweep is complete.
    SweepDone(u64),
    /// The sweep failed.
    SweepFailed {
        /// Number of the request.
        id: u64,
        /// Reason, one line.
        reason: String,
        /// Whether the devices must be reopened.
        lost: bool,
    },
    /// The sweep does not fit the reference at the head's angles; the reason.
    LostStepsSuspected(u64, String),
    /// How far the judged view lay turned.
    ViewTurned(SeenTurn),
    /// The sweep is judged, or cannot be.
    Judged(u64, Result<(), String>),
    /// The result is stored, or cannot be.
    Recorded(u64, Result<(), String>),
    /// The configuration was read again: the kind of change, or its errors.
    Reload(Result<SettingsChange, Vec<String>>),
    /// End the service.
    Shutdown,
    /// Sent periodically.
    Tick,
}
