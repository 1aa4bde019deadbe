//! What the driver asks of its caller, and the events it reports.

use std::time::Duration;

use crate::Axis;
use crate::error::HeadError;
use crate::identity::{AxisLimits, HeadIdentity, Health};

/// One thing for the caller to do, in order.
#[derive(Debug, Clone, PartialEq)]
pub enum PtuAction {
    /// Send these bytes now, all of them.
    Send(Vec<u8>),
    /// A reply, a notice of the unit or a failure; nothing to send.
    Event(PtuEvent),
}

/// What the unit reported or did.
#[derive(Debug, Clone, PartialEq)]
pub enum PtuEvent {
    /// The unit is set up and identified. Follows [`PtuEvent::EchoReturned`], [`PtuEvent::VerboseReturned`] and
    /// [`PtuEvent::Restarted`] without a further request.
    Connected(Box<HeadIdentity>),
    /// A polled position. The unit latched the count between the two instants (sweep-geometry section 3).
    Position {
        /// Axis polled.
        axis: Axis,
        /// Position, counts. The unit runs open loop: this is what was commanded, not what was measured (ptu-d46 section 9).
        steps: i32,
        /// End of sending of the query, never after `first_byte_at`.
        sent_at: Duration,
        /// First byte of the reply.
        first_byte_at: Duration,
    },
    /// The set speed was accepted.
    SpeedSet {
        /// The axis whose speed was set.
        axis: Axis,
        /// Speed, counts per second.
        steps_per_s: i32,
    },
    /// The target was accepted and the axis starts to move.
    MoveAccepted {
        /// The axis that starts to move.
        axis: Axis,
        /// Target, counts.
        target_steps: i32,
        /// First byte of the reply.
        at: Duration,
    },
    /// The unit accepted the halt of both axes; they decelerate first. Confirm by polls (ptu-d46 section 11, step 6).
    Halted,
    /// The calibration succeeded: positions can be trusted, limits are measured anew.
    HomeDone {
        /// Pan range.
        pan: AxisLimits,
        /// Tilt range.
        tilt: AxisLimits,
    },
    /// Supply voltage and temperatures.
    Health(Health),
    /// Hold power of both axes is low; takes effect after the next move (ptu-d46 section 6).
    HoldPowerLow,
    /// An axis hit its limit outside a calibration: steps are lost, the position is not trusted until a reset.
    LimitHit(Axis),
    /// The cable between controller and head was disconnected.
    CableLost,
    /// The unit echoes again: its settings are lost, most likely by a power cycle. The position is unknown; waiting requests
    /// are dropped and the driver connects anew.
    EchoReturned,
    /// The unit sends verbose replies again; handled like [`PtuEvent::EchoReturned`].
    VerboseReturned,
    /// The power-up banner came; handled like [`PtuEvent::EchoReturned`].
    Restarted,
    /// The unit refused a command; a refused command changes nothing (ptu-d46 section 4).
    Refused {
        /// The command, without its delimiter.
        command: String,
        /// The unit's text.
        text: String,
    },
    /// Something failed. Unless the error's variant states otherwise, the driver is offline afterwards and needs a new connect.
    Fault(HeadError),
}
