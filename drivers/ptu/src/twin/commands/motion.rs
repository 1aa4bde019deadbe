//! Targets, limits, halting, waiting, scanning.

use super::{Executed, Outcome};
use crate::twin::command::{Preset, Quantity};
use crate::twin::constants::{MAX_POSITION, PRESETS};
use crate::twin::names::AxisName;
use crate::twin::replies::{self, Refusal};
use crate::twin::settings::{LimitMode, ScanRange};
use crate::twin::unit::{Cpu, Scan, Twin};

impl Twin {
    /// `xP` and `xO`.
    pub(super) fn position(
        &mut self,
        axis: AxisName,
        quantity: Quantity,
        value: Option<i32>,
    ) -> Executed {
        let i = axis.index();
        let here = self.axes[i].position(self.now);
        let Some(value) = value else {
            let n = match quantity {
                Quantity::Offset => self.held_back[i].unwrap_or(self.axes[i].target()),
                _ => here,
            };
            return Ok(Outcome::Say(replies::figure(axis, quantity, n)));
        };
        let target = if quantity == Quantity::Offset {
            here.saturating_add(value)
        } else {
            value
        };
        self.check_target(axis, target)?;
        self.go(axis, target);
        Ok(Outcome::Done)
    }

    /// Whether a target is acceptable now.
    fn check_target(&self, axis: AxisName, target: i32) -> Result<(), Refusal> {
        if self.settings.velocity_mode {
            return Err(Refusal::IllegalCommand);
        }
        if self.options.e_series && !self.calibrated {
            return Err(Refusal::AxisError);
        }
        match self.limits_in_force(axis) {
            Some((_, maximum)) if target > maximum => Err(Refusal::AboveMaximum(axis, maximum)),
            Some((minimum, _)) if target < minimum => Err(Refusal::BelowMinimum(axis, minimum)),
            None if target.unsigned_abs() > MAX_POSITION.unsigned_abs() => {
                Err(Refusal::IllegalCommand)
            }
            _ => Ok(()),
        }
    }

    /// Sends an axis off, or holds its target back in slaved mode.
    fn go(&mut self, axis: AxisName, target: i32) {
        if self.settings.slaved {
            self.held_back[axis.index()] = Some(target);
        } else {
            self.drive(axis, target);
        }
    }

    /// Sends an axis off with its present settings.
    pub(in crate::twin) fn drive(&mut self, axis: AxisName, target: i32) {
        let ramp = self.settings.axis(axis).ramp();
        let here = self.axes[axis.index()].position(self.now);
        let past = self.faults.overshoot(axis, self.now) * (target - here).signum();
        self.overshot[axis.index()] = (past != 0).then_some(target);
        self.axes[axis.index()].drive(self.now, target.saturating_add(past), ramp);
    }

    /// What slaved mode held back starts, both axes together.
    pub(super) fn release(&mut self) {
        for axis in AxisName::BOTH {
            if let Some(target) = self.held_back[axis.index()].take() {
                self.drive(axis, target);
            }
        }
    }

    /// `A`.
    pub(super) fn wait(&mut self) -> Executed {
        self.release();
        if !self.moving() {
            return Ok(Outcome::Done);
        }
        self.cpu = Cpu::Awaiting;
        Ok(Outcome::Silent)
    }

    /// `H HP HT`.
    pub(super) fn halt(&mut self, pan: bool, tilt: bool) -> Executed {
        for (axis, chosen) in AxisName::BOTH.into_iter().zip([pan, tilt]) {
            if chosen {
                self.held_back[axis.index()] = None;
                self.overshot[axis.index()] = None;
                self.axes[axis.index()].halt(self.now);
            }
        }
        Ok(Outcome::Done)
    }

    /// The limits that targets obey.
    pub(super) fn limits_in_force(&self, axis: AxisName) -> Option<(i32, i32)> {
        let measured = self.limits[axis.index()];
        let settings = self.settings.axis(axis);
        match self.settings.limits {
            LimitMode::Off => None,
            LimitMode::Factory => Some(measured),
            LimitMode::User => Some((
                settings.user_minimum.unwrap_or(measured.0),
                settings.user_maximum.unwrap_or(measured.1),
            )),
        }
    }

    /// `LE LD LU`.
    pub(super) fn limit_mode(&mut self, mode: LimitMode) -> Executed {
        self.settings.limits = mode;
        if self.settings.velocity_mode {
            for axis in AxisName::BOTH {
                if self.axes[axis.index()].moving() {
                    self.follow_velocity(axis);
                }
            }
        }
        Ok(Outcome::Done)
    }

    /// `xN xX` and, on the E series, `xNU xXU`.
    pub(super) fn limit(
        &mut self,
        axis: AxisName,
        quantity: Quantity,
        value: Option<i32>,
    ) -> Executed {
        let (minimum, maximum) = self.limits[axis.index()];
        let user = matches!(quantity, Quantity::UserMinimum | Quantity::UserMaximum);
        if user {
            self.e_series()?;
        }
        let settings = self.settings.axis_mut(axis);
        let Some(value) = value else {
            let n = match quantity {
                Quantity::Minimum => minimum,
                Quantity::Maximum => maximum,
                Quantity::UserMinimum => settings.user_minimum.unwrap_or(minimum),
                _ => settings.user_maximum.unwrap_or(maximum),
            };
            return Ok(Outcome::Say(replies::figure(axis, quantity, n)));
        };
        if !user {
            return Err(Refusal::IllegalCommand);
        }
        if value > maximum {
            return Err(Refusal::AboveMaximum(axis, maximum));
        }
        if value < minimum {
            return Err(Refusal::BelowMinimum(axis, minimum));
        }
        let bound = if quantity == Quantity::UserMinimum {
            &mut settings.user_minimum
        } else {
            &mut settings.user_maximum
        };
        *bound = Some(value);
        Ok(Outcome::Done)
    }

    /// `M` (section 8).
    pub(super) fn monitor(&mut self, range: Option<ScanRange>) -> Executed {
        let range = range
            .or(self.settings.scan)
            .unwrap_or_else(|| self.default_scan());
        for (axis, ends) in AxisName::BOTH.into_iter().zip(range) {
            if let Some((first, second)) = ends {
                self.check_target(axis, first)?;
                self.check_target(axis, second)?;
            }
        }
        self.settings.scan = Some(range);
        self.begin_scan(range);
        Ok(Outcome::Done)
    }

    /// Pan between its limits.
    pub(in crate::twin) fn default_scan(&self) -> ScanRange {
        [Some(self.limits[AxisName::Pan.index()]), None]
    }

    /// Starts an auto-scan.
    pub(in crate::twin) fn begin_scan(&mut self, range: ScanRange) {
        self.scan = Some(Scan {
            range,
            second: true,
        });
        self.turn_scan();
    }

    /// Sends the axes of a scan to their other ends when both have arrived.
    pub(in crate::twin) fn turn_scan(&mut self) {
        if self.moving() {
            return;
        }
        let Some(scan) = &mut self.scan else { return };
        scan.second = !scan.second;
        let (range, second) = (scan.range, scan.second);
        for (axis, ends) in AxisName::BOTH.into_iter().zip(range) {
            let target = ends.map(|(a, b)| if second { b } else { a });
            if let Some(target) =
                target.filter(|t| *t != self.axes[axis.index()].position(self.now))
            {
                self.drive(axis, target);
            }
        }
    }

    /// Any character ends a scan and sends the head home.
    pub(in crate::twin) fn end_scan(&mut self) {
        if self.scan.take().is_some() {
            AxisName::BOTH
                .into_iter()
                .for_each(|axis| self.drive(axis, 0));
        }
    }

    /// `XS XG XC`.
    pub(super) fn preset(&mut self, what: Preset, index: i32) -> Executed {
        let index = usize::try_from(index)
            .ok()
            .filter(|i| *i < PRESETS)
            .ok_or(Refusal::IllegalCommand)?;
        match what {
            Preset::Clear => self.settings.presets[index] = None,
            Preset::Store => {
                let [pan, tilt] = &self.axes;
                self.settings.presets[index] =
                    Some([pan.position(self.now), tilt.position(self.now)]);
            }
            Preset::Go => {
                let targets = self.settings.presets[index].ok_or(Refusal::PresetEmpty)?;
                for (axis, target) in AxisName::BOTH.into_iter().zip(targets) {
                    self.check_target(axis, target)?;
                }
                for (axis, target) in AxisName::BOTH.into_iter().zip(targets) {
                    self.go(axis, target);
                }
            }
        }
        Ok(Outcome::Done)
    }

    /// `B`: both positions and speeds, set together or not at all.
    pub(super) fn batch(&mut self, values: Option<[i32; 4]>) -> Executed {
        let Some([pan, tilt, pan_speed, tilt_speed]) = values else {
            return Ok(Outcome::Say(replies::Answer::same(self.batch_text())));
        };
        let wanted = [
            (AxisName::Pan, pan, pan_speed),
            (AxisName::Tilt, tilt, tilt_speed),
        ];
        for (axis, target, speed) in wanted {
            self.check_target(axis, target)?;
            self.check_speed(axis, speed)?;
        }
        for (axis, target, speed) in wanted {
            self.settings.axis_mut(axis).speed = speed;
            self.go(axis, target);
        }
        Ok(Outcome::Done)
    }

    /// `BT`: the same with the unit's time, ms.
    pub(super) fn batch_timed(&mut self) -> Executed {
        let text = format!("{},{}", self.batch_text(), self.now.as_millis());
        Ok(Outcome::Say(replies::Answer::same(text)))
    }

    fn batch_text(&self) -> String {
        let [pan, tilt] = &self.axes;
        let [pan_speed, tilt_speed] =
            [&self.settings.axes[0], &self.settings.axes[1]].map(|a| a.speed);
        format!(
            "{},{},{pan_speed},{tilt_speed}",
            pan.position(self.now),
            tilt.position(self.now)
        )
    }
}
