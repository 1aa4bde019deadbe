//! What can go wrong between driver and unit.

use crate::head_line::HeadLine;

/// A fault of the dialogue with the unit.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum HeadError {
    /// No byte came while connecting.
    #[error(
        "no pan-tilt unit answers: wrong port, no power, a network id is set, or the unit is still calibrating"
    )]
    Silent,
    /// Bytes came while connecting, but no reply.
    #[error("heard \"{heard}\" ({bytes_heard} bytes): {line}")]
    NotAHead {
        /// What is there instead.
        line: HeadLine,
        /// The first bytes, escaped.
        heard: String,
        /// Bytes received while connecting.
        bytes_heard: u64,
    },
    /// While settings or identity were read, replies belonged to other commands, again and again.
    #[error(
        "`{command}` was answered by {heard:?}, the reply to another command: replies come twice or late; stop other programs \
         that use the port, look for an echo on the line (half-duplex adapter, bridged wires), then power-cycle the unit"
    )]
    OutOfStep {
        /// The command that showed it.
        command: String,
        /// What came, escaped.
        heard: String,
    },
    /// The unit reports a value that cannot be, again and again.
    #[error(
        "`{command}` answered {got}, {expected} expected: power-cycle the unit; if it repeats, the unit is faulty or of another kind"
    )]
    ImpossibleValue {
        /// The query.
        command: String,
        /// What can be.
        expected: String,
        /// What it answered.
        got: String,
    },
    /// A calibration was under way while connecting and did not end.
    #[error("the unit is calibrating and did not finish within {waited_s} s")]
    CalibrationTimedOut {
        /// Time limit while connecting, seconds.
        waited_s: u64,
    },
    /// A setting that this driver needs was not accepted.
    #[error("`{command}` should answer {expected:?}, got {got:?}")]
    SettingNotTaken {
        /// The query that showed it.
        command: String,
        /// The keyword that was expected in the reply.
        expected: String,
        /// The text that came instead.
        got: String,
    },
    /// The unit refused a command that connecting needs.
    #[error("connecting needs `{command}`, but the unit answered {text:?}")]
    SetupRefused {
        /// The command as sent, without its delimiter.
        command: String,
        /// The unit's answer, as printed.
        text: String,
    },
    /// A command was sent several times without a valid reply.
    #[error("no valid reply to `{command}` after {tries} tries; last line received: {heard:?}")]
    NoReply {
        /// The command as sent, without its delimiter.
        command: String,
        /// Times it was sent.
        tries: u32,
        /// The last line received instead, escaped; empty if none.
        heard: String,
    },
    /// The calibration ended with an error. The driver stays connected; the position is not trusted.
    #[error("the reset failed: {text}")]
    ResetFailed {
        /// The unit's text, or what spoilt the calibration.
        text: String,
    },
    /// The calibration did not end in time.
    #[error("the reset did not finish within {waited_s} s")]
    ResetTimedOut {
        /// Time limit of a calibration, seconds.
        waited_s: u64,
    },
}

/// A request that was not accepted; nothing was sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum RequestError {
    /// There is no connection (yet): wait for [`PtuEvent::Connected`](crate::PtuEvent::Connected).
    #[error("the pan-tilt unit is not connected")]
    NotConnected,
    /// Too many commands wait.
    #[error("{waiting} commands are queued already: poll slower")]
    QueueFull {
        /// Commands waiting.
        waiting: usize,
    },
}
