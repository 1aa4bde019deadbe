//! What can happen to the patrol.

use std::fmt;

/// What is asked of the patrol.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Task {
    /// Compare the place with its reference.
    Visit,
    /// Take the place's reference.
    Teach,
    /// Sweep, and hand the points back.
    Sweep,
}

impl Task {
    /// The word of the command.
    pub fn word(self) -> &'static str {
        match self {
            Self::Visit => "visit",
            Self::Teach => "teach",
            Self::Sweep => "sweep",
        }
    }
}

/// One request, from its arrival to its reply.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Request {
    /// Number of the request within this run of the service.
    pub id: u64,
    /// What is asked.
    pub task: Task,
    /// At which waypoint; empty for a bare sweep.
    pub waypoint: String,
}

/// Why a request was not carried out; nothing was stored for it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Refusal {
    /// Too many requests wait already.
    Busy,
    /// The service is stopping.
    Stopping,
    /// No such waypoint.
    UnknownWaypoint(String),
    /// The waypoint has no reference.
    NoReference(String),
    /// The devices gave no sweep.
    NoSweep(String),
    /// The sweep is not good enough to become a reference or to be handed out.
    BadSweep(String),
    /// The disk, the database or the engine failed.
    Failed(String),
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Busy => f.write_str("busy: too many requests wait already; try again later"),
            Self::Stopping => f.write_str("the service is stopping"),
            Self::UnknownWaypoint(why)
            | Self::NoReference(why)
            | Self::NoSweep(why)
            | Self::BadSweep(why)
            | Self::Failed(why) => f.write_str(why),
        }
    }
}

/// What a changed configuration asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Change {
    /// The devices can stay open.
    Plain,
    /// The devices must be opened anew.
    Devices,
}

/// What happens to the patrol. Events about a request carry its number; those of a request that is no longer in
/// hand are ignored.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Event {
    /// The devices are connected and homed.
    DevicesReady,
    /// The devices could not be opened.
    DevicesFailed(String),
    /// The devices could not be opened, for one is not there.
    DevicesAbsent(String),
    /// Devices that were ready went away while nothing was asked of them.
    DevicesLost(String),
    /// The devices are let go: laser off, head stopped.
    DevicesClosed,
    /// Somebody asks for something.
    Requested(Request),
    /// Whoever asked does not wait for the outcome any more.
    AskerGone(u64),
    /// The waypoint's reference is there, or why not.
    Prepared(u64, Result<(), Refusal>),
    /// The sweep is taken.
    SweepDone(u64),
    /// The sweep failed; the devices must be opened anew where `lost`.
    SweepFailed {
        /// The request.
        id: u64,
        /// Why.
        reason: String,
        /// Whether the devices must be opened anew.
        lost: bool,
    },
    /// The sweep does not fit at the head's angles: why it is not judged.
    Doubted(u64, String),
    /// The sweep is judged, or why it cannot be.
    Judged(u64, Result<(), String>),
    /// The outcome is on disk, or why not.
    Recorded(u64, Result<(), String>),
    /// The configuration was read again: what it changes, or every mistake in it.
    Reload(Result<Change, Vec<String>>),
    /// The service shall end.
    Shutdown,
    /// Time passes.
    Tick,
}
