//! Speeds, bounds, tables, velocity mode.

use super::{Executed, Outcome};
use crate::twin::command::Quantity;
use crate::twin::constants::{BEYOND, MAX_ACCELERATION, MAX_SPEED, MIN_SPEED};
use crate::twin::names::AxisName;
use crate::twin::replies::{self, Refusal};
use crate::twin::settings::Settings;
use crate::twin::unit::{Cpu, Twin};

impl Twin {
    /// `xS xD xA xB xU xL`.
    pub(super) fn speed(
        &mut self,
        axis: AxisName,
        quantity: Quantity,
        value: Option<i32>,
    ) -> Executed {
        let settings = self.settings.axis(axis);
        match (quantity, value) {
            (_, None) => {
                let n = match quantity {
                    Quantity::Speed => settings.speed,
                    Quantity::SpeedDelta => self.speed_now(axis),
                    Quantity::Acceleration => settings.acceleration,
                    Quantity::Base => settings.base,
                    Quantity::Upper => settings.upper,
                    _ => settings.lower,
                };
                Ok(Outcome::Say(replies::figure(axis, quantity, n)))
            }
            (Quantity::Speed, Some(speed)) => self.set_speed(axis, speed),
            (Quantity::SpeedDelta, Some(change)) => {
                self.set_speed(axis, settings.speed.saturating_add(change))
            }
            (Quantity::Lower, Some(lower)) => {
                if lower < MIN_SPEED {
                    return Err(Refusal::BelowMotor(MIN_SPEED));
                }
                if lower > settings.upper {
                    return Err(Refusal::TooFast(axis, settings.upper));
                }
                self.settings.axis_mut(axis).lower = lower;
                Ok(Outcome::Done)
            }
            (_, Some(value)) => self.set_table(axis, quantity, value),
        }
    }

    /// Instantaneous speed: signed in velocity mode only.
    fn speed_now(&self, axis: AxisName) -> i32 {
        let speed = self.axes[axis.index()].speed(self.now).round() as i32;
        if self.settings.velocity_mode {
            speed
        } else {
            speed.abs()
        }
    }

    /// Whether a speed is within the bounds of the mode in force.
    pub(super) fn check_speed(&self, axis: AxisName, speed: i32) -> Result<(), Refusal> {
        let settings = self.settings.axis(axis);
        let velocity = self.settings.velocity_mode;
        if velocity && speed == 0 {
            return Ok(());
        }
        let magnitude = if velocity {
            speed.saturating_abs()
        } else {
            speed
        };
        if magnitude > settings.upper {
            return Err(Refusal::TooFast(axis, settings.upper));
        }
        if magnitude < settings.lower {
            return Err(Refusal::TooSlow(axis, settings.lower));
        }
        Ok(())
    }

    fn set_speed(&mut self, axis: AxisName, speed: i32) -> Executed {
        self.check_speed(axis, speed)?;
        self.settings.axis_mut(axis).speed = speed;
        if self.settings.velocity_mode {
            self.follow_velocity(axis);
        } else if self.axes[axis.index()].moving() {
            let target = self.overshot[axis.index()].unwrap_or(self.axes[axis.index()].target());
            self.drive(axis, target);
        }
        Ok(Outcome::Done)
    }

    /// Velocity mode: the signed speed is a drive towards that end of the range, 0 is a halt (section 9).
    pub(super) fn follow_velocity(&mut self, axis: AxisName) {
        let speed = self.settings.axis(axis).speed;
        let here = self.axes[axis.index()].position(self.now);
        let end = match (self.limits_in_force(axis), speed > 0) {
            (Some((_, maximum)), true) => maximum.max(here),
            (Some((minimum, _)), false) => minimum.min(here),
            (None, up) => {
                if up {
                    BEYOND
                } else {
                    -BEYOND
                }
            }
        };
        if speed == 0 || end == here {
            self.axes[axis.index()].halt(self.now);
        } else {
            self.drive(axis, end);
        }
    }

    /// `CV` and `CI`.
    pub(in crate::twin) fn set_velocity_mode(&mut self, on: bool) {
        if on == self.settings.velocity_mode {
            return;
        }
        self.settings.velocity_mode = on;
        self.held_back = [None; 2];
        for axis in AxisName::BOTH {
            if on {
                self.follow_velocity(axis);
            } else {
                self.axes[axis.index()].halt(self.now);
            }
        }
    }

    /// `PA PB PU`: at rest only; the tables are recomputed before the reply (section 9).
    fn set_table(&mut self, axis: AxisName, quantity: Quantity, value: i32) -> Executed {
        if self.moving() {
            return Err(Refusal::InMotion);
        }
        let mut settings = self.settings.clone();
        let own = settings.axis_mut(axis);
        match quantity {
            Quantity::Acceleration => {
                if !(1..=MAX_ACCELERATION).contains(&value) {
                    return Err(Refusal::TableExceeded);
                }
                own.acceleration = value;
            }
            Quantity::Base => {
                if value < MIN_SPEED {
                    return Err(Refusal::BelowMotor(MIN_SPEED));
                }
                if value > own.upper {
                    return Err(Refusal::TooFast(axis, own.upper));
                }
                own.base = value;
            }
            _ => {
                if value < own.lower {
                    return Err(Refusal::TooSlow(axis, own.lower));
                }
                if value > MAX_SPEED {
                    return Err(Refusal::TableExceeded);
                }
                own.upper = value;
                own.speed = own.speed.clamp(-value, value);
            }
        }
        Ok(self.recompute(settings))
    }

    /// Settings whose tables need time: they hold, and `*` is printed, when it has passed.
    pub(super) fn recompute(&mut self, settings: Settings) -> Outcome {
        let due = self.now.saturating_add(self.options.table_delay);
        self.cpu = Cpu::Recomputing {
            due,
            settings: Box::new(settings),
        };
        Outcome::Silent
    }

    /// `xR`.
    pub(super) fn resolution(&mut self, axis: AxisName, value: Option<i32>) -> Executed {
        if value.is_some() {
            return Err(Refusal::IllegalCommand);
        }
        let counts = self.settings.axis(axis).counted_in.counts_per_half_step();
        Ok(Outcome::Say(replies::resolution(
            axis,
            self.options.model,
            counts,
            self.options.e_series,
        )))
    }
}
