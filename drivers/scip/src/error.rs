//! What can go wrong: [`ReplyError`] in one reply, [`SensorError`] in the dialogue. Expected, got, where.

use thiserror::Error;

use crate::Instant;
use crate::status::{Command, Meaning};

/// Bytes from the device, shown with their unprintable ones escaped.
#[derive(Clone, PartialEq, Eq)]
pub struct Shown(Vec<u8>);

impl From<&[u8]> for Shown {
    fn from(bytes: &[u8]) -> Self {
        Self(bytes.to_vec())
    }
}

impl std::fmt::Display for Shown {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "\"{}\"", self.0.escape_ascii())
    }
}

impl std::fmt::Debug for Shown {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        std::fmt::Display::fmt(self, f)
    }
}

/// A reply that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum ReplyError {
    /// The reply belongs to another request.
    #[error("reply to {expected} expected, got one to {got}")]
    Echo {
        /// The request's line.
        expected: Shown,
        /// The echo that came.
        got: Shown,
    },
    /// The message has an echo and nothing else.
    #[error("no status after the echo {echo}")]
    NoStatus {
        /// The echo that came.
        echo: Shown,
    },
    /// A line's sum is wrong.
    #[error("sum '{}' expected, got '{}' in line {line}", char::from(*.expected), .got.escape_ascii())]
    Sum {
        /// The whole line.
        line: Shown,
        /// Sum of the line's body.
        expected: u8,
        /// The character that stood there.
        got: u8,
    },
    /// A byte that no encoded number has.
    #[error("character in '0'..='o' expected, got '{}'", .got.escape_ascii())]
    Character {
        /// The byte.
        got: u8,
    },
    /// A part has another length than the protocol gives it.
    #[error("{what}: length {expected} expected, got {got}")]
    Length {
        /// Which part.
        what: &'static str,
        /// Its length by the protocol.
        expected: usize,
        /// The length that came.
        got: usize,
    },
    /// The scan has another number of values than was asked for.
    #[error("{expected} values expected, got {got}")]
    ValueCount {
        /// By the request (rounded down).
        expected: usize,
        /// That came.
        got: usize,
    },
    /// The field of scans remaining is not what the request leads to.
    #[error("remaining scans {expected} expected, got {got}")]
    Remaining {
        /// By the request.
        expected: u8,
        /// In the echo.
        got: u8,
    },
    /// A key the reply must have is missing.
    #[error("no {key} in the reply to {command}")]
    MissingKey {
        /// The key.
        key: &'static str,
        /// The command.
        command: Command,
    },
    /// A value that should be a number is none, or none that makes sense.
    #[error("{key}: {expected} expected, got {got}")]
    Value {
        /// The key.
        key: &'static str,
        /// What it should be.
        expected: &'static str,
        /// What stood there.
        got: Shown,
    },
    /// The device answered with an error status.
    #[error("{command} refused: {meaning}")]
    Refused {
        /// The command.
        command: Command,
        /// What the status means.
        meaning: Meaning,
    },
}

impl ReplyError {
    pub(crate) fn sum(line: &[u8], expected: u8, got: u8) -> Self {
        Self::Sum {
            line: line.into(),
            expected,
            got,
        }
    }

    /// What the device's error status means, if this is one.
    #[must_use]
    pub fn refusal(&self) -> Option<Meaning> {
        match self {
            Self::Refused { meaning, .. } => Some(*meaning),
            _ => None,
        }
    }
}

/// A dialogue that did not come to its end.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum SensorError {
    /// The device did not answer.
    #[error("no reply to {command} after {attempts} attempts of {timeout:?}")]
    NoReply {
        /// The command.
        command: Command,
        /// How often it was sent.
        attempts: u8,
        /// How long each was waited for.
        timeout: Instant,
    },
    /// The device answered, never usably.
    #[error("no usable reply to {command} after {attempts} attempts; the last one: {last}")]
    BadReply {
        /// The command.
        command: Command,
        /// How often it was sent.
        attempts: u8,
        /// What was wrong with the last answer.
        last: ReplyError,
    },
    /// Connecting took longer than allowed.
    #[error("not connected within {limit:?} (at {command})")]
    ConnectTimeout {
        /// The limit.
        limit: Instant,
        /// The command then under way.
        command: Command,
    },
    /// The device stays in a mode it cannot be talked out of.
    #[error("the sensor does not reach SCIP 2.0 ({last}); it may need a power cycle")]
    WrongMode {
        /// Its last complaint.
        last: Meaning,
    },
    /// The device says it is broken (`II`, `STAT`).
    #[error("the sensor reports a fault: {status}; it needs a power cycle")]
    Trouble {
        /// Its own words.
        status: String,
    },
    /// Hardware status 50 to 97 in the middle of a stream.
    #[error("the sensor reports hardware trouble {status}; it needs a power cycle")]
    Hardware {
        /// The status.
        status: u8,
    },
    /// The same stamp again and again: firmware stalled, or stale buffers.
    #[error("stamp {stamp_ms} ms repeated {repeats} times: stale data")]
    StaleStamp {
        /// The stamp.
        stamp_ms: u32,
        /// How often it was repeated.
        repeats: u8,
    },
    /// Stamps that jump in every scan.
    #[error(
        "{jumps} stamps in a row jumped; the last one by {advance_ms} ms, {expected_ms} ms expected"
    )]
    ErraticStamps {
        /// How many.
        jumps: u8,
        /// The last advance.
        advance_ms: u32,
        /// The advance of the plan.
        expected_ms: u32,
    },
    /// The stream stopped and neither `QT` nor `RS` brought it back for long.
    #[error("the stream stopped ({cause}) and neither QT nor RS brought it back")]
    StreamLost {
        /// What was seen last.
        cause: crate::sensor::RecoveryCause,
    },
    /// The device fell back to SCIP 1.1: it lost power in between.
    #[error("the sensor restarted in between (it speaks SCIP 1.1 again)")]
    Relapsed,
    /// The model is not known to have what was asked for; asking could leave it deaf (protocol section 10).
    #[error("{what}: not asked of a {model}, which could fall deaf")]
    Unsupported {
        /// What was asked for.
        what: &'static str,
        /// `MODL` of the device.
        model: String,
    },
    /// The request does not fit the state of the dialogue.
    #[error("{request} is not possible while {state}")]
    NotReady {
        /// What was asked.
        request: &'static str,
        /// What the dialogue is doing.
        state: &'static str,
    },
    /// The scan asked for cannot be.
    #[error("scan plan: {what}: {expected} expected, got {got}")]
    Plan {
        /// Which field.
        what: &'static str,
        /// Its bounds.
        expected: &'static str,
        /// What was given.
        got: u32,
    },
}
