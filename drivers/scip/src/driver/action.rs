//! The outputs of the driver: bytes to send, and events.

use super::error::ScipError;
use super::identity::LaserIdentity;
use super::recovery::{RecoveryCause, RecoveryStep};
use crate::error::{EscapedBytes, ReplyError};
use crate::scan::LaserScan;
use std::time::Duration;

/// One output of the driver. Drain all of them after every input.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub enum LaserAction {
    /// Write these bytes to the device, now.
    Send(Vec<u8>),
    /// Change the line rate of the port, bit/s, now.
    SetBitRate(u32),
    /// A result or a change of state; nothing to send.
    Event(LaserEvent),
}

/// What the driver reports.
#[derive(Debug, Clone, PartialEq)]
pub enum LaserEvent {
    /// The device is identified and idle, its laser off.
    Connected(LaserIdentity),
    /// The bit rate stays as it was: the sensor refused another one, or did not answer at it. `Connected` follows.
    BitRateKept {
        /// The rate that was asked for, bit/s.
        wanted: u32,
    },
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
        /// Ranges in mm and the timer stamp.
        scan: LaserScan,
        /// Instant of the input that carried its message's first byte.
        first_byte_at: Duration,
        /// Instant of the input that carried its message's last byte.
        last_byte_at: Duration,
    },
    /// Scans missing between two stamps.
    LostScans(u32),
    /// Connecting accepted a `VV` reply with wrong sums, since every attempt brought them.
    WrongSumsTolerated {
        /// Number of lines with a wrong sum; their text is used.
        lines: usize,
    },
    /// A message was not used.
    Rejected {
        /// What is wrong with the message.
        reason: Rejection,
        /// Rejections since [`ScipDriver::new`](crate::ScipDriver::new).
        total: u64,
    },
    /// The device stopped scanning to verify an error (status 21 to 49).
    Verifying {
        /// The status number, 21 to 49.
        status: u8,
    },
    /// Verified as normal, scans go on (status 98).
    VerifiedNormal,
    /// The stream stopped; the driver tries to restart it.
    Recovering {
        /// Why the stream counts as stopped.
        cause: RecoveryCause,
        /// How the driver restarts it.
        step: RecoveryStep,
    },
    /// The stream is acknowledged again.
    Recovered {
        /// Whether the timer is back at zero, so that the clock must be fitted again.
        timer_reset: bool,
    },
    /// The stop is acknowledged, or a counted stream has ended: the device is idle, its laser off.
    Stopped,
    /// Only this request failed; the device is idle and takes another.
    RequestFailed(ScipError),
    /// The driver gave up. Close the port, reopen it with back-off, connect again.
    ConnectionFailed(ScipError),
}

/// Why a message was not used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Rejection {
    /// Damaged, or refused by the device.
    Reply(ReplyError),
    /// No request is waiting for it.
    Unsolicited {
        /// Its first line.
        echo: EscapedBytes,
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
    /// A line or message was too long and was dropped.
    Overrun,
}
