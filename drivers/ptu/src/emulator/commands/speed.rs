//! Speeds, their bounds, speed tables, velocity mode.

use super::{RequestOutcome, RequestResult};
use crate::emulator::axis_name::AxisName;
use crate::emulator::command::AxisParameter;
use crate::emulator::constants::{MAX_ACCELERATION, MAX_SPEED, MIN_SPEED, UNREACHABLE_TARGET};
use crate::emulator::replies::{self, RequestRefusal};
use crate::emulator::settings::UnitSettings;
use crate::emulator::state::{CpuState, EmulatedHead};

impl EmulatedHead {
    /// `xS xD xA xB xU xL`.
    pub(super) fn speed(
        &mut self,
        axis: AxisName,
        parameter: AxisParameter,
        value: Option<i32>,
    ) -> RequestResult {
        let settings = self.settings.axis(axis);
        match (parameter, value) {
            (_, None) => {
                let n = match parameter {
                    AxisParameter::Speed => settings.speed,
                    AxisParameter::SpeedDelta => self.speed_now(axis),
                    AxisParameter::Acceleration => settings.acceleration,
                    AxisParameter::Base => settings.base,
                    AxisParameter::Upper => settings.upper,
                    _ => settings.lower,
                };
                Ok(RequestOutcome::Answer(replies::parameter(
                    axis, parameter, n,
                )))
            }
            (AxisParameter::Speed, Some(speed)) => self.set_speed(axis, speed),
            (AxisParameter::SpeedDelta, Some(change)) => {
                self.set_speed(axis, settings.speed.saturating_add(change))
            }
            (AxisParameter::Lower, Some(lower)) => {
                if lower < MIN_SPEED {
                    return Err(RequestRefusal::BelowMotor(MIN_SPEED));
                }
                if lower > settings.upper {
                    return Err(RequestRefusal::TooFast(axis, settings.upper));
                }
                self.settings.axis_mut(axis).lower = lower;
                Ok(RequestOutcome::Done)
            }
            (_, Some(value)) => self.set_table(axis, parameter, value),
        }
    }

    /// The instantaneous speed, signed in velocity mode only.
    fn speed_now(&self, axis: AxisName) -> i32 {
        let speed = self.axes[axis.index()].speed(self.now).round() as i32;
        if self.settings.velocity_mode {
            speed
        } else {
            speed.abs()
        }
    }

    /// Refuses a speed out of the bounds of the mode in force.
    pub(super) fn check_speed(&self, axis: AxisName, speed: i32) -> Result<(), RequestRefusal> {
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
            return Err(RequestRefusal::TooFast(axis, settings.upper));
        }
        if magnitude < settings.lower {
            return Err(RequestRefusal::TooSlow(axis, settings.lower));
        }
        Ok(())
    }

    fn set_speed(&mut self, axis: AxisName, speed: i32) -> RequestResult {
        self.check_speed(axis, speed)?;
        self.settings.axis_mut(axis).speed = speed;
        if self.settings.velocity_mode {
            self.follow_velocity(axis);
        } else if self.axes[axis.index()].moving() {
            let target =
                self.overshoot_target[axis.index()].unwrap_or(self.axes[axis.index()].target());
            self.drive(axis, target);
        }
        Ok(RequestOutcome::Done)
    }

    /// Velocity mode: a signed speed moves towards that end of the range, 0 halts (ptu-d46 section 9).
    pub(super) fn follow_velocity(&mut self, axis: AxisName) {
        let speed = self.settings.axis(axis).speed;
        let here = self.axes[axis.index()].position(self.now);
        let end = match (self.limits_in_force(axis), speed > 0) {
            (Some((_, maximum)), true) => maximum.max(here),
            (Some((minimum, _)), false) => minimum.min(here),
            (None, up) => {
                if up {
                    UNREACHABLE_TARGET
                } else {
                    -UNREACHABLE_TARGET
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
    pub(in crate::emulator) fn set_velocity_mode(&mut self, on: bool) {
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

    /// `PA PB PU`: at rest only; the tables are recomputed before the reply (ptu-d46 section 9).
    fn set_table(&mut self, axis: AxisName, parameter: AxisParameter, value: i32) -> RequestResult {
        if self.moving() {
            return Err(RequestRefusal::InMotion);
        }
        let mut settings = self.settings.clone();
        let own = settings.axis_mut(axis);
        match parameter {
            AxisParameter::Acceleration => {
                if !(1..=MAX_ACCELERATION).contains(&value) {
                    return Err(RequestRefusal::TableExceeded);
                }
                own.acceleration = value;
            }
            AxisParameter::Base => {
                if value < MIN_SPEED {
                    return Err(RequestRefusal::BelowMotor(MIN_SPEED));
                }
                if value > own.upper {
                    return Err(RequestRefusal::TooFast(axis, own.upper));
                }
                own.base = value;
            }
            _ => {
                if value < own.lower {
                    return Err(RequestRefusal::TooSlow(axis, own.lower));
                }
                if value > MAX_SPEED {
                    return Err(RequestRefusal::TableExceeded);
                }
                own.upper = value;
                own.speed = own.speed.clamp(-value, value);
            }
        }
        Ok(self.recompute(settings))
    }

    /// Recomputes the tables of new settings: after the delay they are in force and `*` is printed.
    pub(super) fn recompute(&mut self, settings: UnitSettings) -> RequestOutcome {
        let due = self.now.saturating_add(self.options.table_delay);
        self.cpu = CpuState::Recomputing {
            due,
            settings: Box::new(settings),
        };
        RequestOutcome::NoReply
    }

    /// `xR`.
    pub(super) fn resolution(&mut self, axis: AxisName, value: Option<i32>) -> RequestResult {
        if value.is_some() {
            return Err(RequestRefusal::IllegalCommand);
        }
        let counts = self.settings.axis(axis).counted_in.counts_per_half_step();
        Ok(RequestOutcome::Answer(replies::resolution(
            axis,
            self.options.model,
            counts,
            self.options.e_series,
        )))
    }
}
