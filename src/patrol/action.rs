//! What the patrol wants done.

use super::event::{Refusal, Request};

/// How much an event in the log weighs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Weight {
    /// Good to know.
    Info,
    /// Worked around.
    Warning,
    /// Something was lost.
    Error,
}

/// One thing to do. Whoever does it reports back with an [`Event`](super::event::Event) where one exists for it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Action {
    /// Let the devices go if they are open, connect and home them.
    OpenDevices,
    /// Interrupt whatever the devices do: laser off, head stopped.
    CancelDevices,
    /// Let the devices go.
    CloseDevices,
    /// Look up the waypoint's reference.
    Prepare(Request),
    /// Take the head's angles for worthless: it is homed before the next sweep.
    DistrustHead,
    /// Take a sweep.
    StartSweep(Request),
    /// Judge the sweep that was taken.
    Judge(Request),
    /// Put what was judged on disk.
    Record(Request),
    /// Put on disk that the place was not observed, and why.
    RecordNotObserved(Request, String),
    /// Tell the asker the outcome.
    Reply(Request),
    /// Tell the asker why there is none.
    Refuse(Request, Refusal),
    /// Forget the request: its asker went away. Nothing is stored for it.
    Drop(Request),
    /// Put the new settings in force.
    ApplySettings,
    /// Keep the old settings and say every mistake in the new ones.
    KeepSettings(Vec<String>),
    /// Note in the event log what the devices did.
    Note(Weight, String),
    /// End.
    Exit,
}
