//! The outputs of the driver: bytes to send, and events.

use super::error::ScipError;
use super::identity::LaserIdentity;
use super::recovery::{RecoveryCause, RecoveryStep};
use crate::error::{ReplyError, Shown};
use crate::scan::LaserScan;
use std::time::Duration;

/// One output of the driver. Drain all of them after every input.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub enum LaserAction {
    /// Write these bytes to the device, now.
    Send(Vec<u8>),
    /// For the caller.
    Event(LaserEvent),
}

/// What the driver reports.
#[derive(Debug, Clone, PartialEq)]
pub enum LaserEvent {
    /// The device is identified and idle, its laser off.
    Connected(LaserIdentity),
    /// One reading of the timer.
    TimeSample {
        /// When the request was sent.
        sent: Duration,
        /// When the first byte of the reply came.
        received: Duration,
        /// The timer in between, ms, 24 bits.
        stamp_ms: u32,
    },
    /// The time exchange is over, the device idle, its laser off.
    TimeExchanged {
        /// Number of samples; a lost reply ends the exchange early.
        samples: u32,
    },
    /// The stream is acknowledged; scans follow.
    Streaming,
    /// A scan that passed every check.
    Scan {
        /// Ranges and stamp.
        scan: LaserScan,
        /// Instant of the input that carried its message's first byte.
        first_byte_at: Duration,
        /// Instant of the input that carried its message's last byte.
        last_byte_at: Duration,
    },
    /// Scans missing between two stamps.
    LostScans(u32),
    /// A message was not used.
    Rejected {
        /// What is wrong with it.
        reason: Rejection,
        /// Rejections since [`ScipDriver::new`](crate::ScipDriver::new).
        total: u64,
    },
    /// The device stopped scanning to verify an error (status 21 to 49).
    Verifying {
        /// As the device sent it.
        status: u8,
    },
    /// Verified as normal, scans go on (status 98).
    VerifiedNormal,
    /// The stream stopped; the driver tries to restart it.
    Recovering {
        /// Why the stream counts as stopped.
        cause: RecoveryCause,
        /// The attempt.
        step: RecoveryStep,
    },
    /// The stream is acknowledged again.
    Recovered {
        /// Whether the timer is back at zero, so that the clock must be fitted again.
        timer_reset: bool,
    },
    /// Idle, laser off.
    Stopped,
    /// The request failed; the device is idle and takes another.
    Failed(ScipError),
    /// The driver gave up. Close the port, reopen it with back-off, connect again.
    Fault(ScipError),
}

/// Why a message was not used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Rejection {
    /// Damaged, or refused by the device.
    Reply(ReplyError),
    /// No request is waiting for it.
    Unsolicited {
        /// Its first line.
        echo: Shown,
    },
    /// Same stamp as the scan before.
    RepeatedStamp {
        /// Milliseconds, 24 bits.
        stamp_ms: u32,
    },
    /// The stamp's advance is no multiple of the scan period, or too large.
    StampJump {
        /// Since the scan before.
        advance_ms: u32,
        /// One scan period.
        expected_ms: u32,
    },
    /// Lines of `VV` kept a wrong sum; their text was used all the same.
    ToleratedSums {
        /// Number of these lines.
        lines: usize,
    },
    /// A line or message was too long and was dropped.
    Overrun,
}
