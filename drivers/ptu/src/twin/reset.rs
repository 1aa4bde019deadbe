//! Power-up and calibration (section 7).

use std::collections::VecDeque;
use std::time::Duration;

use rand::RngExt;

use super::Instant;
use super::constants::{RESET_GRACE, RESET_PATIENCE};
use super::names::AxisName;
use super::profile::Ramp;
use super::replies::Refusal;
use super::settings::Settings;
use super::unit::{Cpu, Twin};

/// One drive of a calibration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// To a stop, which prints its event.
    Stop { axis: AxisName, upper: bool },
    /// The chosen axes to 0.
    Home,
}

/// A calibration under way.
#[derive(Debug)]
pub(super) struct Reset {
    axes: Vec<AxisName>,
    stages: VecDeque<Stage>,
    current: Option<(Stage, Instant)>,
    fails: bool,
    power_up: bool,
}

impl Reset {
    /// When the drive under way counts as failed.
    pub(super) fn deadline(&self) -> Option<Instant> {
        self.current.map(|(_, deadline)| deadline)
    }
}

impl Twin {
    /// Power comes: saved settings, position unknown and called 0, banner, calibration as selected.
    pub(super) fn power_up(&mut self) {
        self.settings = self.saved.clone();
        self.baud = self.power_up_baud;
        self.byte_gap = Duration::ZERO;
        self.selected = self.settings.unit_id == 0;
        self.calibrated = false;
        for axis in AxisName::BOTH {
            self.adopt_step_mode(axis);
            let counts = self.settings.axis(axis).counted_in.counts_per_half_step();
            self.axes[axis.index()].forget(self.now, counts);
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
            self.cpu = Cpu::Ready;
            self.start_running();
            return;
        }
        self.begin_reset(selected.pan, selected.tilt, true);
    }

    /// Starts calibrating the chosen axes; both others stop.
    pub(super) fn begin_reset(&mut self, pan: bool, tilt: bool, power_up: bool) {
        self.scan = None;
        self.held_back = [None; 2];
        self.overshot = [None; 2];
        let mut reset = Reset {
            axes: Vec::new(),
            stages: VecDeque::new(),
            current: None,
            fails: (pan || tilt) && self.faults.reset_fails(self.now),
            power_up,
        };
        for (axis, chosen) in [(AxisName::Tilt, tilt), (AxisName::Pan, pan)] {
            if !chosen {
                self.axes[axis.index()].halt(self.now);
                continue;
            }
            self.adopt_step_mode(axis);
            let counts = self.settings.axis(axis).counted_in.counts_per_half_step();
            self.axes[axis.index()].adopt_truth(self.now, counts);
            reset.axes.push(axis);
            reset.stages.extend([
                Stage::Stop { axis, upper: false },
                Stage::Stop { axis, upper: true },
            ]);
        }
        if !reset.axes.is_empty() {
            reset.stages.push_back(Stage::Home);
        }
        self.continue_reset(reset);
    }

    /// Goes on with a calibration as far as `now` allows.
    pub(super) fn continue_reset(&mut self, mut reset: Reset) {
        loop {
            match reset.current {
                Some((stage, deadline)) => {
                    if !self.reached(stage, &reset.axes) {
                        if deadline <= self.now {
                            return self.fail_reset();
                        }
                        self.cpu = Cpu::Resetting(reset);
                        return;
                    }
                    if reset.fails {
                        return self.fail_reset();
                    }
                    if let Stage::Stop { axis, .. } = stage {
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

    /// Sends the axes off; the instant at which patience ends.
    fn start_stage(&mut self, stage: Stage, axes: &[AxisName]) -> Instant {
        let mut longest = Duration::ZERO;
        for &axis in axes {
            let target = match stage {
                Stage::Stop { axis: wanted, .. } if wanted != axis => continue,
                Stage::Stop { upper, .. } => self.axes[axis.index()].stop_count(upper),
                Stage::Home => 0,
            };
            let settings = self.settings.axis(axis);
            let speed = f64::from(self.options.reset_speed[axis.index()].max(1))
                * settings.counted_in.counts_per_half_step();
            let ramp = Ramp {
                speed,
                ..settings.ramp()
            };
            let motor = &mut self.axes[axis.index()];
            let way = f64::from((target - motor.position(self.now)).abs());
            let slowest = speed.min(ramp.base.max(1.0));
            let time = Duration::try_from_secs_f64(RESET_PATIENCE * way / slowest)
                .unwrap_or(Duration::MAX);
            longest = longest.max(time);
            motor.drive(self.now, target, ramp);
        }
        self.now.saturating_add(longest).saturating_add(RESET_GRACE)
    }

    /// Whether the stage's axes stand at their targets, count and rotor.
    fn reached(&self, stage: Stage, axes: &[AxisName]) -> bool {
        axes.iter().all(|&axis| {
            if matches!(stage, Stage::Stop { axis: wanted, .. } if wanted != axis) {
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
        self.cpu = Cpu::Ready;
        self.reply(Err(Refusal::ResetFailed));
    }

    fn finish_reset(&mut self, reset: &Reset) {
        for &axis in &reset.axes {
            self.measure_limits(axis);
        }
        if reset.axes.len() == AxisName::BOTH.len() {
            self.calibrated = true;
        }
        self.cpu = Cpu::Ready;
        self.reply(Ok(None));
        if reset.power_up {
            self.start_running();
        }
    }

    /// What runs by itself once the unit is ready: a motion or a scan that the start state or `ME` asks for.
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

    /// Measures an axis's limits: nominal, give or take a few counts (section 5).
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

    /// The step mode asked for with `W` comes into force.
    fn adopt_step_mode(&mut self, axis: AxisName) {
        let settings: &mut Settings = &mut self.settings;
        let settings = settings.axis_mut(axis);
        settings.count_in(settings.step_mode);
    }
}
