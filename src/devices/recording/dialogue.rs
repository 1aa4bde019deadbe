//! The dialogue of one sweep, as values.

use crate::devices::error::Device;
use std::time::Duration;

/// What one sweep said to both devices and heard from them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SweepDialogue {
    /// The plan of the sweep, encoded: what the bytes mean.
    pub plan: Vec<u8>,
    /// State of the laser's driver before the first entry, encoded.
    pub laser: Vec<u8>,
    /// State of the head's driver before the first entry, encoded.
    pub head: Vec<u8>,
    /// When the sweep began, on the devices' clock.
    pub began_at: Duration,
    /// How it ended.
    pub end: DialogueEnd,
    /// In the order in which they were noted; the instants of the two devices may interleave.
    pub entries: Vec<DialogueEntry>,
}

/// How a dialogue ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum DialogueEnd {
    /// The sweep is complete.
    Complete,
    /// The sweep failed; why, one line.
    Failed(String),
    /// The sweep went on and its end was not recorded: the recording reached its largest size.
    TooLong,
}

/// One entry.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DialogueEntry {
    /// On the devices' clock: of bytes the instant that the driver was given.
    pub at: Duration,
    /// Which device.
    pub device: Device,
    /// What happened.
    pub kind: DialogueEntryKind,
}

/// What an entry is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum DialogueEntryKind {
    /// Bytes of the device.
    Received(Vec<u8>),
    /// Bytes to the device.
    Sent(Vec<u8>),
    /// The driver took the next command of the sweep.
    CommandTaken,
    /// A time limit of the driver was over.
    DriverDeadline,
    /// The sweep took the next event of the driver.
    EventHandled,
    /// The sweep heard that the port was lost.
    PortLost,
    /// A time limit of the sweep was over. The device says nothing.
    SweepDeadline,
    /// The sweep was cancelled. The device says nothing.
    Cancelled,
}
