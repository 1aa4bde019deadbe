//! What commands change and `DS` saves.

use super::constants::PRESETS;
use super::names::AxisName;
use super::options::{StartState, TwinOptions};
use super::profile::Ramp;

/// Power while standing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum HoldPower {
    Regular,
    Low,
    Off,
}

/// Power while moving.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum MovePower {
    High,
    Regular,
    Low,
}

/// Step mode; positions and speeds count in its steps (section 5).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum StepMode {
    Full,
    Half,
    Quarter,
    Eighth,
    Auto,
}

impl StepMode {
    /// Counts per half step.
    pub(super) fn counts_per_half_step(self) -> f64 {
        match self {
            StepMode::Full => 0.5,
            StepMode::Half => 1.0,
            StepMode::Quarter => 2.0,
            StepMode::Eighth | StepMode::Auto => 4.0,
        }
    }
}

/// How targets are bounded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LimitMode {
    Factory,
    User,
    Off,
}

/// Which axes calibrate at power-up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ResetSelect {
    pub pan: bool,
    pub tilt: bool,
}

/// Auto-scan: per axis the two ends, `None` for an axis at rest.
pub(super) type ScanRange = [Option<(i32, i32)>; 2];

/// The settings of one axis, in counts of its step mode.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct AxisSettings {
    /// Signed in velocity mode.
    pub speed: i32,
    pub base: i32,
    pub acceleration: i32,
    pub upper: i32,
    pub lower: i32,
    pub hold: HoldPower,
    pub moving: MovePower,
    /// Step mode asked for with `W`; in force after a calibration.
    pub step_mode: StepMode,
    /// Step mode in whose steps the figures here count.
    pub counted_in: StepMode,
    /// User limits, E series.
    pub user_minimum: Option<i32>,
    /// See `user_minimum`.
    pub user_maximum: Option<i32>,
}

impl AxisSettings {
    /// The figures that shape a motion now.
    pub(super) fn ramp(&self) -> Ramp {
        let speed = self
            .speed
            .abs()
            .max(if self.speed == 0 { self.lower } else { 1 });
        Ramp {
            speed: f64::from(speed),
            base: f64::from(self.base.max(1)),
            acceleration: f64::from(self.acceleration.max(1)),
        }
    }

    /// Rescales what is counted in steps to those of another step mode.
    pub(super) fn count_in(&mut self, mode: StepMode) {
        let ratio = mode.counts_per_half_step() / self.counted_in.counts_per_half_step();
        self.counted_in = mode;
        let scale = |n: i32| (f64::from(n) * ratio).round() as i32;
        for n in [
            &mut self.speed,
            &mut self.base,
            &mut self.acceleration,
            &mut self.upper,
            &mut self.lower,
        ] {
            *n = scale(*n);
        }
        self.user_minimum = self.user_minimum.map(scale);
        self.user_maximum = self.user_maximum.map(scale);
    }

    /// Whether the speed tables differ, so that a change takes its time (section 9).
    pub(super) fn same_tables(&self, other: &Self) -> bool {
        (self.base, self.acceleration, self.upper) == (other.base, other.acceleration, other.upper)
    }
}

/// All settings of the unit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Settings {
    pub echo: bool,
    pub verbose: bool,
    pub velocity_mode: bool,
    pub slaved: bool,
    pub limits: LimitMode,
    pub axes: [AxisSettings; 2],
    pub reset_at_power_up: ResetSelect,
    pub scan_at_power_up: bool,
    pub scan: Option<ScanRange>,
    pub unit_id: u8,
    pub presets: [Option<[i32; 2]>; PRESETS],
}

impl Settings {
    /// What `DF` restores.
    pub(super) fn factory(options: &TwinOptions) -> Self {
        let axis = |name: AxisName| {
            let i = name.index();
            AxisSettings {
                speed: options.speed[i],
                base: options.base_speed[i],
                acceleration: options.acceleration[i],
                upper: options.upper_speed[i],
                lower: options.lower_speed[i],
                hold: HoldPower::Regular,
                moving: MovePower::Regular,
                step_mode: StepMode::Half,
                counted_in: StepMode::Half,
                user_minimum: None,
                user_maximum: None,
            }
        };
        Self {
            echo: true,
            verbose: true,
            velocity_mode: false,
            slaved: false,
            limits: LimitMode::Factory,
            axes: [axis(AxisName::Pan), axis(AxisName::Tilt)],
            reset_at_power_up: ResetSelect {
                pan: options.calibrate_at_power_up,
                tilt: options.calibrate_at_power_up,
            },
            scan_at_power_up: false,
            scan: None,
            unit_id: 0,
            presets: [None; PRESETS],
        }
    }

    /// Factory settings with the start state laid over them.
    pub(super) fn started(options: &TwinOptions) -> Self {
        let StartState {
            echo,
            verbose,
            velocity_mode,
            slaved,
            limits,
            unit_id,
            monitor,
            ..
        } = options.start;
        Self {
            echo,
            verbose,
            velocity_mode,
            slaved,
            limits: if limits {
                LimitMode::Factory
            } else {
                LimitMode::Off
            },
            unit_id,
            scan_at_power_up: monitor,
            ..Self::factory(options)
        }
    }

    /// One axis.
    pub(super) fn axis(&self, name: AxisName) -> &AxisSettings {
        &self.axes[name.index()]
    }

    /// One axis, to be changed.
    pub(super) fn axis_mut(&mut self, name: AxisName) -> &mut AxisSettings {
        &mut self.axes[name.index()]
    }
}
