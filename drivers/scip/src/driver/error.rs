//! Why a dialogue with the laser failed.

use std::time::Duration;
use thiserror::Error;

use super::laser_line::LaserLine;
use super::recovery::RecoveryCause;
use crate::error::{EscapedBytes, ReplyError};
use crate::status::{ScipCommand, StatusMeaning};

/// A dialogue that failed.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[allow(missing_docs, reason = "each message shows what its fields are")]
pub enum ScipError {
    #[error("no reply to {command} after {attempts} attempts of {timeout:?}")]
    NoReply {
        command: ScipCommand,
        attempts: u8,
        timeout: Duration,
    },
    /// While connecting: something answers, but no request of this driver.
    #[error("heard {heard} ({bytes} bytes): {line}")]
    NotALaser {
        line: LaserLine,
        heard: EscapedBytes,
        bytes: u64,
    },
    /// It answers `SCIP2.0` as a unit does that has no other protocol.
    #[error(
        "heard {heard}: a sensor whose firmware speaks SCIP 1.1 only; have its firmware updated to SCIP 2.0, or use another unit"
    )]
    Scip11Only { heard: EscapedBytes },
    /// After `SS` it answers neither at the new nor at the old rate.
    #[error(
        "after a change to {wanted} bit/s it does not answer any more, nor at the rate before; power-cycle it, and ask for a rate \
         that its line carries"
    )]
    BitRateLost { wanted: u32 },
    #[error("no usable reply to {command} after {attempts} attempts; the last one: {last}")]
    BadReply {
        command: ScipCommand,
        attempts: u8,
        last: ReplyError,
    },
    #[error("not connected within {limit:?} (at {command})")]
    ConnectTimeout {
        limit: Duration,
        command: ScipCommand,
    },
    /// The device stays in another mode in spite of `SCIP2.0`, `TM2` or `RS`.
    #[error("the sensor does not enter SCIP 2.0 ({last}); it may need a power cycle")]
    WrongMode { last: StatusMeaning },
    /// `STAT` of `II` reports a fault.
    #[error("the sensor reports a fault: {status}; it needs a power cycle")]
    Trouble { status: String },
    /// Status 50 to 97 of a stream.
    #[error("the sensor reports hardware trouble {status}; it needs a power cycle")]
    Hardware { status: u8 },
    /// Stalled firmware or stale buffers.
    #[error("stamp {stamp_ms} ms repeated {repeats} times: stale data")]
    StaleStamp { stamp_ms: u32, repeats: u8 },
    #[error(
        "{jumps} stamps in a row jumped; the last one by {advance_ms} ms, {expected_ms} ms expected"
    )]
    ErraticStamps {
        jumps: u8,
        advance_ms: u32,
        expected_ms: u32,
    },
    #[error("the stream stopped ({cause}) and neither QT nor RS brought it back")]
    StreamLost { cause: RecoveryCause },
    /// It lost power in between.
    #[error("the sensor restarted: it is in SCIP 1.1 again")]
    FellBackToScip11,
    /// The model is not known to have it, and asking could leave it unresponsive (scip2 section 10).
    #[error("{what} not requested: a {model} may stop responding until a power cycle")]
    Unsupported { what: &'static str, model: String },
    /// The driver is busy or not connected.
    #[error("{request} is not possible while {state}")]
    NotReady {
        request: &'static str,
        state: &'static str,
    },
    /// A [`StreamPlan`](crate::StreamPlan) that no request can carry.
    #[error("scan plan: {what}: {expected} expected, got {got}")]
    Plan {
        what: &'static str,
        expected: &'static str,
        got: u32,
    },
}
