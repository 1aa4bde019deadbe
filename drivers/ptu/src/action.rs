//! What the driver asks of its caller and tells it.

use crate::identity::{AxisLimits, HeadIdentity, Health};
use crate::{Axis, HoldPower, Instant, MovePower};

/// One thing to do, in order.
#[derive(Debug, Clone, PartialEq)]
pub enum Action {
    /// Send these bytes now, all of them.
    Send(Vec<u8>),
    /// Something happened.
    Event(Event),
}

/// What the unit said or did.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// The unit is set up and known. Follows [`Event::EchoReturned`], [`Event::VerboseReturned`] and [`Event::Restarted`] by itself.
    Connected(Box<HeadIdentity>),
    /// A polled position. The count was latched between the two instants (sweep geometry, section 3).
    Position {
        /// Axis.
        axis: Axis,
        /// Position, counts. In an open loop this is what was commanded, not what is (section 9).
        steps: i32,
        /// End of sending of the query, never after `first_byte_at`.
        sent_at: Instant,
        /// First byte of the reply.
        first_byte_at: Instant,
    },
    /// How fast an axis is (`PS` is only the set speed: section 12).
    Speed {
        /// Axis.
        axis: Axis,
        /// Counts per second.
        steps_per_s: i32,
    },
    /// Where an axis is on its way to.
    Target {
        /// Axis.
        axis: Axis,
        /// Counts.
        steps: i32,
    },
    /// The hold power was taken; it takes effect after the next move (section 6).
    HoldPowerSet {
        /// Axis.
        axis: Axis,
        /// Power.
        power: HoldPower,
    },
    /// The move power was taken.
    MovePowerSet {
        /// Axis.
        axis: Axis,
        /// Power.
        power: MovePower,
    },
    /// One axis was told to stop; as [`Event::Halted`].
    AxisHalted(Axis),
    /// The set speed was taken.
    SpeedSet {
        /// Axis.
        axis: Axis,
        /// Speed, counts per second.
        steps_per_s: i32,
    },
    /// The target was taken and the axis is on its way.
    MoveAccepted {
        /// Axis.
        axis: Axis,
        /// Target, counts.
        target_steps: i32,
        /// First byte of the reply.
        at: Instant,
    },
    /// Both axes were told to stop; they decelerate first. Confirm by polls (section 11, step 6).
    Halted,
    /// The calibration went through: positions can be trusted, limits are measured anew.
    HomeDone {
        /// Pan range.
        pan: AxisLimits,
        /// Tilt range.
        tilt: AxisLimits,
    },
    /// Supply and temperature.
    Health(Health),
    /// Hold power of both axes is low; takes effect after the next move (section 6).
    HoldPowerLow,
    /// An axis ran into its limit unasked: steps are lost, the position is not trusted until a reset.
    LimitHit(Axis),
    /// The cable between controller and head came off.
    CableLost,
    /// The unit echoes again: its settings are lost, very likely by a power cycle. The position is unknown; waiting requests are
    /// dropped and the connection is made anew.
    EchoReturned,
    /// The unit talks in phrases again; as [`Event::EchoReturned`].
    VerboseReturned,
    /// The power-up banner came; as [`Event::EchoReturned`].
    Restarted,
    /// The unit refused a command; a refused command changes nothing (section 4).
    Refused {
        /// The command, without its delimiter.
        command: String,
        /// The unit's words.
        text: String,
    },
    /// Something failed. Unless the variant says otherwise the driver is offline afterwards and wants a new connect.
    Fault(HeadError),
}

/// What can go wrong between driver and unit.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum HeadError {
    /// No valid answer at connecting.
    #[error(
        "no pan-tilt unit answers ({bytes_heard} bytes heard, none of them a reply): wrong port, wrong baud rate, no power, \
         a network id is set, or the unit is still calibrating"
    )]
    Silent {
        /// Bytes that came while connecting. Many of them suggest a wrong baud rate.
        bytes_heard: u64,
    },
    /// A calibration was under way at connecting and did not end.
    #[error("the unit calibrates, but was not done after {waited_s} s")]
    CalibrationTimedOut {
        /// Seconds waited.
        waited_s: u64,
    },
    /// A setting needed for this driver was not taken.
    #[error("`{command}` should answer {expected:?}, got {got:?}")]
    SettingNotTaken {
        /// The query that showed it.
        command: String,
        /// The wanted word.
        expected: String,
        /// The reply.
        got: String,
    },
    /// The unit refused a command that connecting cannot do without, or answered it with an impossible value.
    #[error("connecting needs `{command}`, but the unit answered {text:?}")]
    SetupRefused {
        /// The command.
        command: String,
        /// The unit's words.
        text: String,
    },
    /// A command was sent several times and never answered properly.
    #[error("no fitting reply to `{command}` after {tries} tries; last heard {heard:?}")]
    NoReply {
        /// The command.
        command: String,
        /// Times it was sent.
        tries: u32,
        /// The last line that came instead, escaped; empty if none.
        heard: String,
    },
    /// The calibration ended with an error; the driver stays connected, the position is not trusted.
    #[error("the reset failed: {text}")]
    ResetFailed {
        /// The unit's words.
        text: String,
    },
    /// The calibration did not end in time.
    #[error("the reset was not done after {waited_s} s")]
    ResetTimedOut {
        /// Seconds waited.
        waited_s: u64,
    },
}

/// A request that was not taken; nothing was sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum RequestError {
    /// There is no connection (yet): wait for [`Event::Connected`].
    #[error("the pan-tilt unit is not connected")]
    NotConnected,
    /// Too many commands wait.
    #[error("{waiting} commands wait already: poll slower")]
    QueueFull {
        /// Commands waiting.
        waiting: usize,
    },
}

/// Faults of the line since the driver was made, for health reports.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counters {
    /// Commands whose reply did not come in time.
    pub timeouts: u64,
    /// Lines that fitted no command, late ones among them.
    pub unmatched_lines: u64,
    /// Lines beyond all length.
    pub overlong_lines: u64,
    /// Times the dialogue was brought back into step.
    pub resyncs: u64,
    /// Commands sent again.
    pub retries: u64,
}
