//! The words of the unit (sections 3 and 4).

use super::command::Quantity;
use super::names::AxisName;
use super::options::{Model, Supply};
use super::settings::{AxisSettings, HoldPower, LimitMode, MovePower, StepMode};

/// Why a command is refused; displays as the text after `! `.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub(super) enum Refusal {
    #[error("Illegal command")]
    IllegalCommand,
    #[error("Maximum allowable {0} position is {1}")]
    AboveMaximum(AxisName, i32),
    #[error("Minimum allowable {0} position is {1}")]
    BelowMinimum(AxisName, i32),
    #[error("{0} speed cannot exceed {1} positions/sec")]
    TooFast(AxisName, i32),
    #[error("{0} speed cannot be less than {1} positions/sec")]
    TooSlow(AxisName, i32),
    #[error("Motor speed cannot be less than {0} pos/sec")]
    BelowMotor(i32),
    #[error("Acceleration table exceeded")]
    TableExceeded,
    #[error("Illegal command while in motion")]
    InMotion,
    #[error("Illegal unit ID")]
    IllegalUnitId,
    #[error("Preset not set")]
    PresetEmpty,
    #[error("Axis Error")]
    AxisError,
    #[error("Reset failed")]
    ResetFailed,
}

/// A query's answer in both feedback modes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Answer {
    pub terse: String,
    pub verbose: String,
}

impl Answer {
    /// An answer that is the same in both modes.
    pub(super) fn same(text: impl Into<String>) -> Self {
        let text = text.into();
        Self {
            verbose: text.clone(),
            terse: text,
        }
    }

    fn new(terse: impl ToString, verbose: String) -> Self {
        Self {
            terse: terse.to_string(),
            verbose,
        }
    }
}

/// `<phrase><n>[ unit]` for a figure of one axis.
pub(super) fn figure(axis: AxisName, quantity: Quantity, n: i32) -> Answer {
    let verbose = match quantity {
        Quantity::Position => format!("Current {axis} position is {n}"),
        Quantity::Offset => format!("Target {axis} position is {n}"),
        Quantity::Minimum => format!("Minimum {axis} position is {n}"),
        Quantity::Maximum => format!("Maximum {axis} position is {n}"),
        Quantity::UserMinimum => format!("Minimum user {axis} position is {n}"),
        Quantity::UserMaximum => format!("Maximum user {axis} position is {n}"),
        Quantity::Speed => format!("Target {axis} speed is {n} positions/sec"),
        Quantity::SpeedDelta => format!("Current {axis} speed is {n} positions/sec"),
        Quantity::Acceleration => format!("{axis} acceleration is {n} positions/sec^2"),
        Quantity::Base => format!("Current {axis} base speed is {n} positions/sec"),
        Quantity::Upper => format!("Maximum {axis} speed is {n} positions/sec"),
        Quantity::Lower => format!("Minimum {axis} speed is {n} positions/sec"),
        Quantity::Resolution => format!("{n} seconds arc per {axis} position"),
    };
    Answer::new(n, verbose)
}

/// `PR` `TR`: four decimals, cut off and not rounded (185.142857 prints as 185.1428).
pub(super) fn resolution(axis: AxisName, model: Model, mode_counts: f64, e_series: bool) -> Answer {
    let printed = (model.half_step_arcsec() / mode_counts * 1e4 + 1e-6).floor() / 1e4;
    let terse = format!("{printed:.4}");
    let per = if e_series {
        "per position".to_owned()
    } else {
        format!("per {axis} position")
    };
    Answer {
        verbose: format!("{terse} seconds arc {per}"),
        terse,
    }
}

/// `PH` `TH`.
pub(super) fn hold(axis: AxisName, settings: &AxisSettings) -> Answer {
    let (terse, word) = match settings.hold {
        HoldPower::Regular => ("REG", "REGULAR"),
        HoldPower::Low => ("LOW", "LOW"),
        HoldPower::Off => ("OFF", "OFF"),
    };
    Answer::new(terse, format!("{axis} in {word} hold power mode"))
}

/// `PM` `TM`.
pub(super) fn moving(axis: AxisName, settings: &AxisSettings) -> Answer {
    let (terse, word) = match settings.moving {
        MovePower::High => ("HIGH", "HIGH"),
        MovePower::Regular => ("REG", "REGULAR"),
        MovePower::Low => ("LOW", "LOW"),
    };
    Answer::new(terse, format!("{axis} in {word} move power mode"))
}

/// `WP` `WT`; the verbose wording is not documented.
pub(super) fn step_mode(axis: AxisName, settings: &AxisSettings) -> Answer {
    let (terse, word) = match settings.step_mode {
        StepMode::Full => ("F", "FULL"),
        StepMode::Half => ("H", "HALF"),
        StepMode::Quarter => ("Q", "QUARTER"),
        StepMode::Eighth => ("E", "EIGHTH"),
        StepMode::Auto => ("A", "AUTO"),
    };
    Answer::new(terse, format!("{axis} in {word} step mode"))
}

/// `L`.
pub(super) fn limits(mode: LimitMode) -> Answer {
    Answer::same(match mode {
        LimitMode::Factory => "Limit bounds are ENABLED (soft limits enabled)",
        LimitMode::User => "Limit bounds are ENABLED (user limits enabled)",
        LimitMode::Off => "Limit bounds are DISABLED (hard limits only: use care)",
    })
}

/// `E`.
pub(super) fn echo(on: bool) -> Answer {
    Answer::same(if on { "Echoing ON" } else { "Echoing OFF" })
}

/// `F`.
pub(super) fn feedback(verbose: bool) -> Answer {
    Answer::same(if verbose {
        "ASCII verbose mode"
    } else {
        "ASCII terse mode"
    })
}

/// `C`.
pub(super) fn control(velocity: bool, e_series: bool) -> Answer {
    Answer::same(match (velocity, e_series) {
        (false, false) => "independent (default) speed control mode",
        (true, false) => "pure velocity speed control mode",
        (false, true) => "Independent speed control mode",
        (true, true) => "Pure Velocity speed control mode",
    })
}

/// `IQ`.
pub(super) fn execution(slaved: bool) -> Answer {
    let (terse, word) = if slaved {
        ("S", "SLAVED")
    } else {
        ("I", "IMMEDIATE")
    };
    Answer::new(terse, format!("{word} execution mode"))
}

/// `MQ`; the wording is not documented.
pub(super) fn scan_at_power_up(on: bool) -> Answer {
    let (terse, word) = if on {
        ("E", "ENABLED")
    } else {
        ("D", "DISABLED")
    };
    Answer::new(terse, format!("Monitor mode at power up is {word}"))
}

/// `O`.
pub(super) fn supply(supply: &Supply) -> Answer {
    let [head, pan, tilt] = supply.temperature_f;
    Answer {
        terse: format!("{:.1},{head:.0},{pan:.0},{tilt:.0}", supply.volts),
        verbose: format!("Input {:.0} VDC @ {head:.0} degF", supply.volts),
    }
}

/// `U`.
pub(super) fn unit_id(id: u8) -> Answer {
    Answer::new(id, format!("Unit ID is {id}"))
}

/// `?`: lines without a defined end.
pub(super) const MENU: [&str; 6] = [
    "PAN-TILT COMMANDS",
    "  P,T position  O offset  S speed  D delta  A acceleration  B base  U,L bounds  N,X limits  R resolution",
    "  I immediate  S slaved  A await  H halt  M monitor  R reset  L limits",
    "  C control  E echo  F feedback  D defaults  W step mode  H hold  M move",
    "  V version  O voltage  @ host port  U unit ID  _ select  X presets",
    "  ? menu",
];
