//! Further requests of the user: one axis at a time, powers, health.

use crate::action::RequestError;
use crate::command::{Command, Quantity};
use crate::head::Head;
use crate::{Axis, HoldPower, Instant, MovePower};

impl Head {
    /// Stops one axis, before everything that waits; its waiting moves are dropped. As [`Head::halt`] in all else.
    ///
    /// # Errors
    /// [`RequestError::NotConnected`] only.
    pub fn halt_axis(&mut self, axis: Axis, now: Instant) -> Result<(), RequestError> {
        if !self.is_connected() {
            return Err(RequestError::NotConnected);
        }
        let halt = Command::HaltAxis(axis);
        self.queue
            .retain(|c| !matches!(c, Command::MoveTo(moved, _) if *moved == axis) && *c != halt);
        self.queue.push_front(halt);
        self.start_next(now);
        Ok(())
    }

    /// Asks how fast an axis is; comes back as [`Event::Speed`].
    ///
    /// # Errors
    /// [`RequestError`].
    pub fn poll_speed(&mut self, axis: Axis, now: Instant) -> Result<(), RequestError> {
        self.request(&[Command::Query(axis, Quantity::SpeedNow)], now)
    }

    /// Asks where an axis is on its way to; comes back as [`Event::Target`].
    ///
    /// # Errors
    /// [`RequestError`].
    pub fn poll_target(&mut self, axis: Axis, now: Instant) -> Result<(), RequestError> {
        self.request(&[Command::Query(axis, Quantity::Target)], now)
    }

    /// Sets the hold power of an axis; comes back as [`Event::HoldPowerSet`].
    ///
    /// # Errors
    /// [`RequestError`].
    pub fn set_hold_power(
        &mut self,
        axis: Axis,
        power: HoldPower,
        now: Instant,
    ) -> Result<(), RequestError> {
        self.request(&[Command::SetHold(axis, power)], now)
    }

    /// Sets the move power of an axis; comes back as [`Event::MovePowerSet`].
    ///
    /// # Errors
    /// [`RequestError`].
    pub fn set_move_power(
        &mut self,
        axis: Axis,
        power: MovePower,
        now: Instant,
    ) -> Result<(), RequestError> {
        self.request(&[Command::SetMove(axis, power)], now)
    }

    /// Asks supply and temperature; comes back as [`Event::Health`].
    ///
    /// # Errors
    /// [`RequestError`].
    pub fn query_health(&mut self, now: Instant) -> Result<(), RequestError> {
        self.request(&[Command::Supply], now)
    }

    /// Sets the hold power of both axes low: for parking and shutdown (section 10).
    ///
    /// # Errors
    /// [`RequestError`].
    pub fn hold_power_low(&mut self, now: Instant) -> Result<(), RequestError> {
        self.request(
            &[Command::HoldLow(Axis::Pan), Command::HoldLow(Axis::Tilt)],
            now,
        )
    }
}
