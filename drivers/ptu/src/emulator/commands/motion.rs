//! Targets, limits, halt, await, auto-scan, presets.

use super::{RequestOutcome, RequestResult};
use crate::emulator::axis_name::AxisName;
use crate::emulator::command::{AxisParameter, PresetAction};
use crate::emulator::constants::{MAX_POSITION, PRESET_COUNT};
use crate::emulator::replies::{self, RequestRefusal};
use crate::emulator::settings::{LimitMode, ScanRange};
use crate::emulator::state::{AutoScan, CpuState, EmulatedHead};

impl EmulatedHead {
    /// `xP` and `xO`.
    pub(super) fn position(
        &mut self,
        axis: AxisName,
        parameter: AxisParameter,
        value: Option<i32>,
    ) -> RequestResult {
        let i = axis.index();
        let here = self.axes[i].position(self.now);
        let Some(value) = value else {
            let n = match parameter {
                AxisParameter::RelativePosition => {
                    self.held_back[i].unwrap_or(self.axes[i].target())
                }
                _ => here,
            };
            return Ok(RequestOutcome::Answer(replies::parameter(
                axis, parameter, n,
            )));
        };
        let target = if parameter == AxisParameter::RelativePosition {
            here.saturating_add(value)
        } else {
            value
        };
        self.check_target(axis, target)?;
        self.drive_or_hold_back(axis, target);
        Ok(RequestOutcome::Done)
    }

    /// Refuses a target that is not acceptable now.
    fn check_target(&self, axis: AxisName, target: i32) -> Result<(), RequestRefusal> {
        if self.settings.velocity_mode {
            return Err(RequestRefusal::IllegalCommand);
        }
        if self.options.e_series && !self.calibrated {
            return Err(RequestRefusal::AxisError);
        }
        match self.limits_in_force(axis) {
            Some((_, maximum)) if target > maximum => {
                Err(RequestRefusal::AboveMaximum(axis, maximum))
            }
            Some((minimum, _)) if target < minimum => {
                Err(RequestRefusal::BelowMinimum(axis, minimum))
            }
            None if target.unsigned_abs() > MAX_POSITION.unsigned_abs() => {
                Err(RequestRefusal::IllegalCommand)
            }
            _ => Ok(()),
        }
    }

    /// Starts an axis, or holds its target back in slaved mode.
    fn drive_or_hold_back(&mut self, axis: AxisName, target: i32) {
        if self.settings.slaved {
            self.held_back[axis.index()] = Some(target);
        } else {
            self.drive(axis, target);
        }
    }

    /// Starts an axis with its present settings.
    pub(in crate::emulator) fn drive(&mut self, axis: AxisName, target: i32) {
        let ramp = self.settings.axis(axis).ramp();
        let here = self.axes[axis.index()].position(self.now);
        let past = self.faults.overshoot(axis, self.now) * (target - here).signum();
        self.overshoot_target[axis.index()] = (past != 0).then_some(target);
        self.axes[axis.index()].drive(self.now, target.saturating_add(past), ramp);
    }

    /// Starts what slaved mode held back, both axes together.
    pub(super) fn start_held_back(&mut self) {
        for axis in AxisName::BOTH {
            if let Some(target) = self.held_back[axis.index()].take() {
                self.drive(axis, target);
            }
        }
    }

    /// `A`.
    pub(super) fn await_motion(&mut self) -> RequestResult {
        self.start_held_back();
        if !self.moving() {
            return Ok(RequestOutcome::Done);
        }
        self.cpu = CpuState::Awaiting;
        Ok(RequestOutcome::NoReply)
    }

    /// `H HP HT`.
    pub(super) fn halt(&mut self, pan: bool, tilt: bool) -> RequestResult {
        for (axis, chosen) in AxisName::BOTH.into_iter().zip([pan, tilt]) {
            if chosen {
                self.held_back[axis.index()] = None;
                self.overshoot_target[axis.index()] = None;
                self.axes[axis.index()].halt(self.now);
            }
        }
        Ok(RequestOutcome::Done)
    }

    /// The limits in force for targets; `None` if they are off.
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
    pub(super) fn limit_mode(&mut self, mode: LimitMode) -> RequestResult {
        self.settings.limits = mode;
        if self.settings.velocity_mode {
            for axis in AxisName::BOTH {
                if self.axes[axis.index()].moving() {
                    self.follow_velocity(axis);
                }
            }
        }
        Ok(RequestOutcome::Done)
    }

    /// `xN xX` and, on the E series, `xNU xXU`.
    pub(super) fn limit(
        &mut self,
        axis: AxisName,
        parameter: AxisParameter,
        value: Option<i32>,
    ) -> RequestResult {
        let (minimum, maximum) = self.limits[axis.index()];
        let user = matches!(
            parameter,
            AxisParameter::UserMinimum | AxisParameter::UserMaximum
        );
        if user {
            self.e_series()?;
        }
        let settings = self.settings.axis_mut(axis);
        let Some(value) = value else {
            let n = match parameter {
                AxisParameter::Minimum => minimum,
                AxisParameter::Maximum => maximum,
                AxisParameter::UserMinimum => settings.user_minimum.unwrap_or(minimum),
                _ => settings.user_maximum.unwrap_or(maximum),
            };
            return Ok(RequestOutcome::Answer(replies::parameter(
                axis, parameter, n,
            )));
        };
        if !user {
            return Err(RequestRefusal::IllegalCommand);
        }
        if value > maximum {
            return Err(RequestRefusal::AboveMaximum(axis, maximum));
        }
        if value < minimum {
            return Err(RequestRefusal::BelowMinimum(axis, minimum));
        }
        let bound = if parameter == AxisParameter::UserMinimum {
            &mut settings.user_minimum
        } else {
            &mut settings.user_maximum
        };
        *bound = Some(value);
        Ok(RequestOutcome::Done)
    }

    /// `M` (ptu-d46 section 8).
    pub(super) fn monitor(&mut self, range: Option<ScanRange>) -> RequestResult {
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
        Ok(RequestOutcome::Done)
    }

    /// The default range: pan between its limits.
    pub(in crate::emulator) fn default_scan(&self) -> ScanRange {
        [Some(self.limits[AxisName::Pan.index()]), None]
    }

    pub(in crate::emulator) fn begin_scan(&mut self, range: ScanRange) {
        self.scan = Some(AutoScan {
            range,
            second: true,
        });
        self.reverse_scan();
    }

    /// Sends the axes of a scan to their other ends once both have arrived.
    pub(in crate::emulator) fn reverse_scan(&mut self) {
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

    /// Ends a scan and sends the head home, as any character does.
    pub(in crate::emulator) fn end_scan(&mut self) {
        if self.scan.take().is_some() {
            AxisName::BOTH
                .into_iter()
                .for_each(|axis| self.drive(axis, 0));
        }
    }

    /// `XS XG XC`.
    pub(super) fn preset(&mut self, what: PresetAction, index: i32) -> RequestResult {
        let index = usize::try_from(index)
            .ok()
            .filter(|i| *i < PRESET_COUNT)
            .ok_or(RequestRefusal::IllegalCommand)?;
        match what {
            PresetAction::Clear => self.settings.presets[index] = None,
            PresetAction::Store => {
                let [pan, tilt] = &self.axes;
                self.settings.presets[index] =
                    Some([pan.position(self.now), tilt.position(self.now)]);
            }
            PresetAction::Go => {
                let targets = self.settings.presets[index].ok_or(RequestRefusal::PresetEmpty)?;
                for (axis, target) in AxisName::BOTH.into_iter().zip(targets) {
                    self.check_target(axis, target)?;
                }
                for (axis, target) in AxisName::BOTH.into_iter().zip(targets) {
                    self.drive_or_hold_back(axis, target);
                }
            }
        }
        Ok(RequestOutcome::Done)
    }

    /// `B`: sets both positions and speeds, or none.
    pub(super) fn batch(&mut self, values: Option<[i32; 4]>) -> RequestResult {
        let Some([pan, tilt, pan_speed, tilt_speed]) = values else {
            return Ok(RequestOutcome::Answer(replies::QueryAnswer::same(
                self.batch_text(),
            )));
        };
        let requested = [
            (AxisName::Pan, pan, pan_speed),
            (AxisName::Tilt, tilt, tilt_speed),
        ];
        for (axis, target, speed) in requested {
            self.check_target(axis, target)?;
            self.check_speed(axis, speed)?;
        }
        for (axis, target, speed) in requested {
            self.settings.axis_mut(axis).speed = speed;
            self.drive_or_hold_back(axis, target);
        }
        Ok(RequestOutcome::Done)
    }

    /// `BT`: the same query with the unit's time, ms.
    pub(super) fn batch_timed(&mut self) -> RequestResult {
        let text = format!("{},{}", self.batch_text(), self.now.as_millis());
        Ok(RequestOutcome::Answer(replies::QueryAnswer::same(text)))
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
