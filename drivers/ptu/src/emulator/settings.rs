//! Settings of the unit, which commands change and `DS` saves.

use super::axis_name::AxisName;
use super::constants::PRESET_COUNT;
use super::motion_profile::SpeedRamp;
use super::options::{HeadOptions, HeadStartState};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum HoldPowerMode {
    Regular,
    Low,
    Off,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum MovePowerMode {
    High,
    Regular,
    Low,
}

/// Step mode; positions and speeds count in its steps (ptu-d46 section 5).
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

/// Which limits bound the targets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LimitMode {
    Factory,
    User,
    Off,
}

/// Which axes calibrate at power-up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ResetSelection {
    pub pan: bool,
    pub tilt: bool,
}

/// Range of an auto-scan: the two ends per axis, `None` for an axis at rest.
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
    pub hold: HoldPowerMode,
    pub moving: MovePowerMode,
    /// Step mode set with `W`; in force after a calibration.
    pub step_mode: StepMode,
    /// Step mode that the values here are counted in.
    pub counted_in: StepMode,
    /// User limits of the E series.
    pub user_minimum: Option<i32>,
    pub user_maximum: Option<i32>,
}

impl AxisSettings {
    /// The ramp of a move with these settings.
    pub(super) fn ramp(&self) -> SpeedRamp {
        let speed = self
            .speed
            .abs()
            .max(if self.speed == 0 { self.lower } else { 1 });
        SpeedRamp {
            speed: f64::from(speed),
            base: f64::from(self.base.max(1)),
            acceleration: f64::from(self.acceleration.max(1)),
        }
    }

    /// Rescales all counts to the steps of another step mode.
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

    /// Whether the speed tables are the same; if not, a change takes time (ptu-d46 section 9).
    pub(super) fn same_tables(&self, other: &Self) -> bool {
        (self.base, self.acceleration, self.upper) == (other.base, other.acceleration, other.upper)
    }
}

/// All settings of the unit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct UnitSettings {
    pub echo: bool,
    pub verbose: bool,
    pub velocity_mode: bool,
    pub slaved: bool,
    pub limits: LimitMode,
    pub axes: [AxisSettings; 2],
    pub reset_at_power_up: ResetSelection,
    pub scan_at_power_up: bool,
    pub scan: Option<ScanRange>,
    pub unit_id: u8,
    pub presets: [Option<[i32; 2]>; PRESET_COUNT],
}

impl UnitSettings {
    /// The factory settings, which `DF` restores.
    pub(super) fn factory(options: &HeadOptions) -> Self {
        let axis = |name: AxisName| {
            let i = name.index();
            AxisSettings {
                speed: options.speed[i],
                base: options.base_speed[i],
                acceleration: options.acceleration[i],
                upper: options.upper_speed[i],
                lower: options.lower_speed[i],
                hold: HoldPowerMode::Regular,
                moving: MovePowerMode::Regular,
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
            reset_at_power_up: ResetSelection {
                pan: options.calibrate_at_power_up,
                tilt: options.calibrate_at_power_up,
            },
            scan_at_power_up: false,
            scan: None,
            unit_id: 0,
            presets: [None; PRESET_COUNT],
        }
    }

    /// The factory settings with the start state applied.
    pub(super) fn started(options: &HeadOptions) -> Self {
        let HeadStartState {
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

    pub(super) fn axis(&self, name: AxisName) -> &AxisSettings {
        &self.axes[name.index()]
    }

    pub(super) fn axis_mut(&mut self, name: AxisName) -> &mut AxisSettings {
        &mut self.axes[name.index()]
    }
}
