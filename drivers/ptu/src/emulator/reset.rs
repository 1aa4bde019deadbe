//! Power-up and calibration (ptu-d46 section 7).

use std::collections::VecDeque;
use std::time::Duration;

use rand::RngExt;

use super::axis_name::AxisName;
use super::constants::{RESET_TIME_FACTOR, RESET_TIME_MARGIN};
use super::motion_profile::SpeedRamp;
use super::replies::RequestRefusal;
use super::settings::UnitSettings;
use super::state::{CpuState, EmulatedHead, ResetRun, ResetStage};

impl EmulatedHead {
    /// Power-up: saved settings, an unknown position that counts as 0, banner, calibration as selected.
    pub(super) fn power_up(&mut self) {
        self.settings = self.saved.clone();
        self.baud = self.power_up_baud;
        self.byte_gap = Duration::ZERO;
        self.selected = self.settings.unit_id == 0;
        self.calibrated = false;
        for axis in AxisName::BOTH {
            self.adopt_step_mode(axis);
            let counts = self.settings.axis(axis).counted_in.counts_per_half_step();
            self.axes[axis.index()].declare_zero(self.now, counts);
            self.measure_limits(axis);
        }
        let selected = self.settings.reset_at_power_up;
        if self.options.banner {
            let end = String::from_utf8_lossy(self.options.line_end.bytes()).into_owned();
            let version = self
                .options
                .firmware
                .trim_start_matches("Pan-Tilt Controller ")
                .to_owned();
            self.emit(
                format!("{end}{end}### PAN-TILT CONTROLLER{end}### {version}{end}Initializing...")
                    .as_bytes(),
            );
        } else if !selected.pan && !selected.tilt {
            self.cpu = CpuState::Ready;
            self.start_running();
            return;
        }
        self.begin_reset(selected.pan, selected.tilt, true);
    }

    /// Starts to calibrate the chosen axes; the others stop.
    pub(super) fn begin_reset(&mut self, pan: bool, tilt: bool, power_up: bool) {
        self.scan = None;
        self.held_back = [None; 2];
        self.overshoot_target = [None; 2];
        let mut reset = ResetRun {
            axes: Vec::new(),
            stages: VecDeque::new(),
            current: None,
            fails: (pan || tilt) && self.faults.take_reset_failure(self.now),
            power_up,
        };
        for (axis, chosen) in [(AxisName::Tilt, tilt), (AxisName::Pan, pan)] {
            if !chosen {
                self.axes[axis.index()].halt(self.now);
                continue;
            }
            self.adopt_step_mode(axis);
            let counts = self.settings.axis(axis).counted_in.counts_per_half_step();
            self.axes[axis.index()].recalibrate(self.now, counts);
            reset.axes.push(axis);
            reset.stages.extend([
                ResetStage::Stop { axis, upper: false },
                ResetStage::Stop { axis, upper: true },
            ]);
        }
        if !reset.axes.is_empty() {
            reset.stages.push_back(ResetStage::Home);
        }
        self.continue_reset(reset);
    }

    /// Continues a calibration as far as it is due.
    pub(super) fn continue_reset(&mut self, mut reset: ResetRun) {
        loop {
            match reset.current {
                Some((stage, deadline)) => {
                    if !self.reached(stage, &reset.axes) {
                        if deadline <= self.now {
                            return self.fail_reset();
                        }
                        self.cpu = CpuState::Resetting(reset);
                        return;
                    }
                    if reset.fails {
                        return self.fail_reset();
                    }
                    if let ResetStage::Stop { axis, .. } = stage {
                        self.emit(axis.limit_event());
                    }
                    reset.current = None;
                }
                None => match reset.stages.pop_front() {
                    Some(stage) => {
                        reset.current = Some((stage, self.start_stage(stage, &reset.axes)))
                    }
                    None => return self.finish_reset(&reset),
                },
            }
        }
    }

    /// Starts the axes of a stage; returns when it counts as failed.
    fn start_stage(&mut self, stage: ResetStage, axes: &[AxisName]) -> Duration {
        let mut longest = Duration::ZERO;
        for &axis in axes {
            let target = match stage {
                ResetStage::Stop { axis: wanted, .. } if wanted != axis => continue,
                ResetStage::Stop { upper, .. } => self.axes[axis.index()].stop_count(upper),
                ResetStage::Home => 0,
            };
            let settings = self.settings.axis(axis);
            let speed = f64::from(self.options.reset_speed[axis.index()].max(1))
                * settings.counted_in.counts_per_half_step();
            let ramp = SpeedRamp {
                speed,
                ..settings.ramp()
            };
            let motor = &mut self.axes[axis.index()];
            let distance = f64::from((target - motor.position(self.now)).abs());
            let slowest = speed.min(ramp.base.max(1.0));
            let time = Duration::try_from_secs_f64(RESET_TIME_FACTOR * distance / slowest)
                .unwrap_or(Duration::MAX);
            longest = longest.max(time);
            motor.drive(self.now, target, ramp);
        }
        self.now
            .saturating_add(longest)
            .saturating_add(RESET_TIME_MARGIN)
    }

    /// Whether count and rotor of the stage's axes are at rest at their targets.
    fn reached(&self, stage: ResetStage, axes: &[AxisName]) -> bool {
        axes.iter().all(|&axis| {
            if matches!(stage, ResetStage::Stop { axis: wanted, .. } if wanted != axis) {
                return true;
            }
            let motor = &self.axes[axis.index()];
            let target = f64::from(motor.target());
            let truth = motor.rotor_at(self.now) * motor.counts_per_half_step();
            !motor.moving() && (truth - target).abs() < 0.5
        })
    }

    fn fail_reset(&mut self) {
        for axis in &mut self.axes {
            axis.stop_at_once(self.now);
        }
        self.calibrated = false;
        self.cpu = CpuState::Ready;
        self.reply(Err(RequestRefusal::ResetFailed));
    }

    fn finish_reset(&mut self, reset: &ResetRun) {
        for &axis in &reset.axes {
            self.measure_limits(axis);
        }
        if reset.axes.len() == AxisName::BOTH.len() {
            self.calibrated = true;
        }
        self.cpu = CpuState::Ready;
        self.reply(Ok(None));
        if reset.power_up {
            self.start_running();
        }
    }

    /// Starts the move or scan that the start state or `ME` asks for.
    pub(super) fn start_running(&mut self) {
        if let (false, Some(targets)) = (
            self.options.power_up,
            self.options.start.moving_to_steps.take(),
        ) {
            for axis in AxisName::BOTH {
                self.drive(axis, targets[axis.index()]);
            }
        }
        if self.settings.scan_at_power_up {
            let range = self.settings.scan.unwrap_or_else(|| self.default_scan());
            self.begin_scan(range);
        }
    }

    /// Measures the limits of an axis: the nominal ones with a random deviation (ptu-d46 section 5).
    pub(super) fn measure_limits(&mut self, axis: AxisName) {
        let i = axis.index();
        let counts = self.settings.axis(axis).counted_in.counts_per_half_step();
        let spread = self.options.limit_spread_steps.max(0);
        let mut measured = |nominal: i32| {
            let n = nominal + self.rng.random_range(-spread..=spread);
            (f64::from(n) * counts).round() as i32
        };
        self.limits[i] = (
            measured(self.options.minimum_steps[i]),
            measured(self.options.maximum_steps[i]),
        );
    }

    /// Puts the step mode set with `W` into force.
    fn adopt_step_mode(&mut self, axis: AxisName) {
        let settings: &mut UnitSettings = &mut self.settings;
        let settings = settings.axis_mut(axis);
        settings.count_in(settings.step_mode);
    }
}
