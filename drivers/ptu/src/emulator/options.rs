//! Options of the emulated head: kind of unit, start state, line.

use std::time::Duration;

use super::constants::{ARCSEC_D46_17, ARCSEC_D46_70};

/// The gear of the unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(non_camel_case_types, reason = "the manufacturer's type names")]
pub enum HeadModel {
    /// 17.5:1, 185.1428 arc seconds per half step.
    D46_17,
    /// 70:1, 46.2857 arc seconds per half step.
    D46_70,
}

impl HeadModel {
    /// Arc seconds per half step (ptu-d46 section 5, the full constant).
    pub(super) fn half_step_arcsec(self) -> f64 {
        match self {
            HeadModel::D46_17 => ARCSEC_D46_17,
            HeadModel::D46_70 => ARCSEC_D46_70,
        }
    }
}

/// How the unit ends its lines (ptu-d46 section 2).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineEnd {
    /// What real units send.
    CrLf,
    /// What the manual writes.
    Cr,
}

impl LineEnd {
    pub(super) fn bytes(self) -> &'static [u8] {
        match self {
            LineEnd::CrLf => b"\r\n",
            LineEnd::Cr => b"\r",
        }
    }
}

/// What happens to bytes that arrive during calibration (ptu-d46 section 7 leaves it open).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InputDuringReset {
    /// They wait and are executed afterwards.
    Queued,
    /// They are lost.
    Dropped,
}

/// Supply voltage and temperatures as `O` reports them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Supply {
    /// Supply voltage, V.
    pub volts: f64,
    /// Temperatures of head, pan motor and tilt motor, degrees Fahrenheit.
    pub temperature_f: [f64; 3],
}

/// State of the unit at the start. The default is a unit with factory settings that has calibrated.
#[derive(Debug, Clone, PartialEq)]
pub struct HeadStartState {
    /// Characters are echoed.
    pub echo: bool,
    /// Verbose replies.
    pub verbose: bool,
    /// Pure velocity mode (`CV`) instead of position mode (`CI`).
    pub velocity_mode: bool,
    /// Slaved mode (`S`): position commands wait for `A` or `I`.
    pub slaved: bool,
    /// Targets beyond the limits are refused (`LE`).
    pub limits: bool,
    /// Network id; a unit whose id is not 0 stays silent until selected.
    pub unit_id: u8,
    /// Line speed.
    pub baud: u32,
    /// Position of `[pan, tilt]`, half steps.
    pub position_steps: [i32; 2],
    /// Targets of `[pan, tilt]` that the axes are moving to, half steps.
    pub moving_to_steps: Option<[i32; 2]>,
    /// Auto-scan is running between the pan limits.
    pub monitor: bool,
}

impl Default for HeadStartState {
    fn default() -> Self {
        Self {
            echo: true,
            verbose: true,
            velocity_mode: false,
            slaved: false,
            limits: true,
            unit_id: 0,
            baud: 9600,
            position_steps: [0, 0],
            moving_to_steps: None,
            monitor: false,
        }
    }
}

/// Options of one emulated head. Pairs are `[pan, tilt]`; positions and speeds are in half steps.
#[derive(Debug, Clone, PartialEq)]
pub struct HeadOptions {
    /// The gear.
    pub model: HeadModel,
    /// What `V` prints after `* `; also the second line of the banner.
    pub firmware: String,
    /// Nominal lowest positions; each calibration measures them again (ptu-d46 section 5).
    pub minimum_steps: [i32; 2],
    /// Nominal highest positions.
    pub maximum_steps: [i32; 2],
    /// Largest deviation of measured limits from the nominal ones, half steps.
    pub limit_spread_steps: i32,
    /// Distance of the mechanical stops beyond the nominal limits, half steps.
    pub stop_margin_steps: i32,
    /// Speed after power-up, positions/s.
    pub speed: [i32; 2],
    /// Base speed (`PB`), positions/s.
    pub base_speed: [i32; 2],
    /// Acceleration (`PA`), positions/s^2.
    pub acceleration: [i32; 2],
    /// Speed while calibrating, positions/s; ptu-d46 section 7 derives its durations from 1000.
    pub reset_speed: [i32; 2],
    /// Upper speed bound (`PU`), positions/s.
    pub upper_speed: [i32; 2],
    /// Lower speed bound (`PL`), positions/s.
    pub lower_speed: [i32; 2],
    /// State at the start.
    pub start: HeadStartState,
    /// The unit is being switched on: banner, then calibration. [`HeadOptions::start`] is then what was saved with `DS`.
    pub power_up: bool,
    /// At power-up the unit calibrates (`RE`); else it only prints its banner (`RD`).
    pub calibrate_at_power_up: bool,
    /// It prints a banner at power-up.
    pub banner: bool,
    /// Bytes take time on the line, as at the set baud rate.
    pub byte_pacing: bool,
    /// Line end of replies.
    pub line_end: LineEnd,
    /// Shortest and longest time from delimiter to reply.
    pub latency: [Duration; 2],
    /// Time to recompute the speed tables after `PA PB PU` (ptu-d46 section 9).
    pub table_delay: Duration,
    /// What happens to bytes received during a calibration.
    pub input_during_reset: InputDuringReset,
    /// `RP RT RE` calibrate at once, as on the E series.
    pub axis_reset_at_once: bool,
    /// E-series extras: user limits, `B`, `IQ`, more baud rates, its own texts.
    pub e_series: bool,
    /// The option board is fitted: `JE JD OOH OOL @A @B` answer `*`.
    pub option_board: bool,
    /// The true position advances in whole steps; otherwise smoothly, as the commanded profile.
    pub whole_steps: bool,
    /// Play of the gears, half steps: the head lags behind the rotor by half of it, against the direction of travel.
    pub backlash_half_steps: [f64; 2],
    /// What `O` reports.
    pub supply: Supply,
    /// Seed of latencies, measured limits and garbage bytes.
    pub seed: u64,
}

impl Default for HeadOptions {
    fn default() -> Self {
        Self {
            model: HeadModel::D46_17,
            firmware: "Pan-Tilt Controller v2.12.1d1(C14/E), (C)2003 Directed Perception, Inc., All Rights Reserved"
                .to_owned(),
            minimum_steps: [-3090, -907],
            maximum_steps: [3090, 604],
            limit_spread_steps: 4,
            stop_margin_steps: 12,
            speed: [1000, 1000],
            base_speed: [1000, 1000],
            acceleration: [2000, 2000],
            reset_speed: [1000, 1000],
            upper_speed: [2902, 2902],
            lower_speed: [31, 31],
            start: HeadStartState::default(),
            power_up: false,
            calibrate_at_power_up: true,
            banner: true,
            byte_pacing: true,
            line_end: LineEnd::CrLf,
            latency: [Duration::from_millis(1), Duration::from_millis(3)],
            table_delay: Duration::from_secs(3),
            input_during_reset: InputDuringReset::Queued,
            axis_reset_at_once: false,
            e_series: false,
            option_board: false,
            whole_steps: true,
            backlash_half_steps: [0.0; 2],
            supply: Supply { volts: 24.0, temperature_f: [86.0, 90.0, 88.0] },
            seed: 0,
        }
    }
}

impl HeadOptions {
    /// Defaults of a model: the 70:1 gear has four times the counts for the same ranges in degrees, and calibrates at its
    /// upper speed bound.
    pub(super) fn for_model(model: HeadModel) -> Self {
        let d46_17 = Self::default();
        match model {
            HeadModel::D46_17 => d46_17,
            HeadModel::D46_70 => Self {
                model,
                minimum_steps: d46_17.minimum_steps.map(|n| n * 4),
                maximum_steps: d46_17.maximum_steps.map(|n| n * 4),
                reset_speed: d46_17.upper_speed,
                ..d46_17
            },
        }
    }
}
