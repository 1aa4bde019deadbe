//! Actions of the patrol.

use super::event::{PatrolRequest, RefusalReason};
use super::severity::Severity;

/// To be carried out by the service, which reports the result as a [`PatrolEvent`](super::event::PatrolEvent).
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PatrolAction {
    /// Release the devices if they are open; connect and home them.
    OpenDevices,
    /// Stop what the devices are doing: laser off, head stopped.
    CancelDevices,
    /// Release the devices.
    CloseDevices,
    /// Load the waypoint's reference.
    Prepare(PatrolRequest),
    /// Home the head before the next sweep; its angles are wrong.
    DistrustHead,
    /// Home the head now; nobody waits for it.
    HomeHead,
    /// Take a sweep.
    StartSweep(PatrolRequest),
    /// Judge the sweep.
    Judge(PatrolRequest),
    /// Store the result.
    Record(PatrolRequest),
    /// Store that the place was not observed, with the reason.
    RecordNotObserved(PatrolRequest, String),
    /// Send the result to the client.
    Reply(PatrolRequest),
    /// Refuse the request.
    Refuse(PatrolRequest, RefusalReason),
    /// Drop the request; its client has disconnected. Nothing is stored.
    Abandon(PatrolRequest),
    /// Apply the new settings.
    ApplySettings,
    /// Keep the old settings; report the errors in the new ones.
    KeepSettings(Vec<String>),
    /// Write to the event log.
    LogEvent(Severity, String),
    /// End the service.
    Exit,
}
