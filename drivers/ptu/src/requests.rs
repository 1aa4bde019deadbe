//! What the caller can ask of a connected unit.

use std::time::Duration;

use crate::Axis;
use crate::command::{AxisProperty, PtuCommand};
use crate::constants::MAX_QUEUED_COMMANDS;
use crate::driver::PtuDriver;
use crate::error::RequestError;

impl PtuDriver {
    /// Calibrates both axes: drives them to all their stops and then to 0,0, which takes up to a minute. Ends in
    /// [`PtuEvent::HomeDone`](crate::PtuEvent::HomeDone) or a fault.
    ///
    /// # Errors
    /// [`RequestError`].
    pub fn reset(&mut self, now: Duration) -> Result<(), RequestError> {
        self.request(&[PtuCommand::Reset], now)
    }

    /// Sets the speed of an axis, counts per second. Allowed while moving.
    ///
    /// # Errors
    /// [`RequestError`]. A speed out of bounds is refused by the unit: [`PtuEvent::Refused`](crate::PtuEvent::Refused).
    pub fn set_speed(
        &mut self,
        axis: Axis,
        steps_per_s: i32,
        now: Duration,
    ) -> Result<(), RequestError> {
        self.request(&[PtuCommand::SetSpeed(axis, steps_per_s)], now)
    }

    /// Sends an axis to a position, counts. Allowed while moving: the new target replaces the old one.
    ///
    /// # Errors
    /// [`RequestError`]. A target out of reach is refused by the unit: [`PtuEvent::Refused`](crate::PtuEvent::Refused).
    pub fn move_to(
        &mut self,
        axis: Axis,
        position_steps: i32,
        now: Duration,
    ) -> Result<(), RequestError> {
        self.request(&[PtuCommand::MoveTo(axis, position_steps)], now)
    }

    /// Asks for the position of an axis; answered by [`PtuEvent::Position`](crate::PtuEvent::Position).
    ///
    /// # Errors
    /// [`RequestError`].
    pub fn poll_position(&mut self, axis: Axis, now: Duration) -> Result<(), RequestError> {
        self.request(&[PtuCommand::Query(axis, AxisProperty::Position)], now)
    }

    /// Asks for supply voltage and temperatures; answered by [`PtuEvent::Health`](crate::PtuEvent::Health).
    ///
    /// # Errors
    /// [`RequestError`].
    pub fn query_health(&mut self, now: Duration) -> Result<(), RequestError> {
        self.request(&[PtuCommand::QuerySupply], now)
    }

    /// Sets the hold power of both axes low, for parking and shutdown (ptu-d46 section 10).
    ///
    /// # Errors
    /// [`RequestError`].
    pub fn hold_power_low(&mut self, now: Duration) -> Result<(), RequestError> {
        self.request(
            &[
                PtuCommand::SetHoldPowerLow(Axis::Pan),
                PtuCommand::SetHoldPowerLow(Axis::Tilt),
            ],
            now,
        )
    }

    /// Stops both axes, ahead of the queue; waiting moves and resets are dropped. Goes out as soon as the command in flight is
    /// answered or timed out; a running calibration ends first.
    ///
    /// # Errors
    /// [`RequestError::NotConnected`] only.
    pub fn halt(&mut self, now: Duration) -> Result<(), RequestError> {
        if !self.is_connected() {
            return Err(RequestError::NotConnected);
        }
        self.queue.retain(|c| {
            !matches!(
                c,
                PtuCommand::MoveTo(..) | PtuCommand::Reset | PtuCommand::Halt
            )
        });
        self.queue.push_front(PtuCommand::Halt);
        self.start_next(now);
        Ok(())
    }

    fn request(&mut self, commands: &[PtuCommand], now: Duration) -> Result<(), RequestError> {
        if !self.is_connected() {
            return Err(RequestError::NotConnected);
        }
        let waiting = self.queue.len();
        if waiting + commands.len() > MAX_QUEUED_COMMANDS {
            return Err(RequestError::QueueFull { waiting });
        }
        self.queue.extend(commands);
        self.start_next(now);
        Ok(())
    }
}
