//! What the dialogue wants done, and what it tells.

use crate::Instant;
use crate::command::info::Info;
use crate::command::parameters::Parameters;
use crate::command::setting::Setting;
use crate::error::{ReplyError, SensorError, Shown};
use crate::scan::RawScan;

/// One output of the dialogue. Drain all of them after every input.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub enum Action {
    /// Write these bytes to the device, now.
    Send(Vec<u8>),
    /// Something to know.
    Event(Event),
}

/// What happened.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// The device is known, idle, its laser off.
    Connected(Identity),
    /// One reading of the timer.
    TimeSample {
        /// When the request was handed out.
        sent: Instant,
        /// When the first byte of the reply came.
        received: Instant,
        /// What the timer said in between, ms, 24 bits.
        stamp_ms: u32,
    },
    /// The time exchange is over, the device idle, its laser off.
    TimeExchanged {
        /// How many samples it gave; a lost reply ends it early.
        samples: u32,
    },
    /// The stream is acknowledged; scans follow.
    Streaming,
    /// A scan that stood every check.
    Scan {
        /// The scan.
        scan: RawScan,
        /// Instant of the input that carried its message's first byte.
        first_byte_at: Instant,
        /// Instant of the input that carried its message's last byte.
        last_byte_at: Instant,
    },
    /// The stamps say that so many scans were made and never accepted here.
    LostScans(u32),
    /// A message was not taken.
    Rejected {
        /// Why.
        reason: Rejection,
        /// How many so far, since [`Sensor::new`](crate::Sensor::new).
        total: u64,
    },
    /// The device stopped scanning to verify an error (status 21 to 49).
    Verifying {
        /// The status.
        status: u8,
    },
    /// The laser proved normal and scans go on (status 98).
    VerifiedNormal,
    /// The stream stopped; the dialogue is trying to bring it back.
    Recovering {
        /// What was seen.
        cause: RecoveryCause,
        /// What is tried.
        step: RecoveryStep,
    },
    /// The stream is acknowledged again.
    Recovered {
        /// Whether the timer went back to zero, so that the clocks must be fitted anew.
        timer_reset: bool,
    },
    /// Stopped: idle, laser off.
    Stopped,
    /// The answer to a query.
    Info(Info),
    /// The setting holds.
    Applied(Setting),
    /// The request failed; the device is idle and another may be made.
    Failed(SensorError),
    /// The dialogue is over. Close the port, open it again with a growing pause, connect.
    Fault(SensorError),
}

/// Who the device is, from `VV`, `PP` and `II`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Identity {
    /// `MODL`.
    pub model: String,
    /// `VEND`.
    pub vendor: String,
    /// `PROD`.
    pub product: String,
    /// `FIRM`.
    pub firmware: String,
    /// `PROT`.
    pub protocol: String,
    /// `SERI`, as sent. Old units print `0` for the first letter: compare the digits.
    pub serial: String,
    /// The numbers of `PP`.
    pub parameters: Parameters,
    /// `STAT` of `II`, the device's own words.
    pub status: String,
}

/// Models whose documents tell of intensity (protocol sections 6 and 10).
const MODELS_WITH_INTENSITY: [&str; 3] = ["UTM-", "UST-", "UXM-"];

impl Identity {
    /// Whether the device is of a model that is known to measure intensity.
    #[must_use]
    pub fn has_intensity(&self) -> bool {
        let names = [&self.model, &self.product];
        MODELS_WITH_INTENSITY
            .iter()
            .any(|known| names.iter().any(|name| name.contains(known)))
    }
}

/// Why a message was not taken.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Rejection {
    /// Damaged, or refused by the device.
    Reply(ReplyError),
    /// Nobody asked for it.
    Unsolicited {
        /// Its first line.
        echo: Shown,
    },
    /// The stamp is the last one's.
    RepeatedStamp {
        /// The stamp.
        stamp_ms: u32,
    },
    /// The stamp's advance is no multiple of the plan's, or too great to believe.
    StampJump {
        /// The advance.
        advance_ms: u32,
        /// By the plan.
        expected_ms: u32,
    },
    /// A line of `VV` kept a wrong sum, and its text was taken all the same.
    ToleratedSums {
        /// How many lines.
        lines: usize,
    },
    /// A line or message grew past all bounds and was dropped.
    Overrun,
}

/// Why the stream is being restarted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RecoveryCause {
    /// No data in time.
    Silence,
    /// Too many damaged messages in a row.
    Damage,
    /// The request to stream was not acknowledged.
    NotAcknowledged,
}

impl std::fmt::Display for RecoveryCause {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Silence => "no data",
            Self::Damage => "damaged data",
            Self::NotAcknowledged => "not acknowledged",
        })
    }
}

/// How the stream is being restarted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RecoveryStep {
    /// `QT`, then stream again.
    Quit,
    /// `RS`, then stream again: the timer goes back to zero.
    Reset,
}
