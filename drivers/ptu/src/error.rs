//! What can go wrong between driver and unit.

/// A fault of the dialogue with the unit.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum HeadError {
    /// No valid reply while connecting.
    #[error(
        "no pan-tilt unit answers ({bytes_heard} bytes received, none of them a reply): wrong port, wrong baud rate, no power, \
         a network id is set, or the unit is still calibrating"
    )]
    Silent {
        /// Bytes received while connecting. Many of them suggest a wrong baud rate.
        bytes_heard: u64,
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
    /// The unit refused a command that connecting needs, or answered it with an impossible value.
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
