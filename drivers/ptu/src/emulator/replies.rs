//! The texts that the unit prints (ptu-d46 sections 3 and 4).

use super::axis_name::AxisName;
use super::command::AxisParameter;
use super::options::{HeadModel, Supply};
use super::settings::{AxisSettings, HoldPowerMode, LimitMode, MovePowerMode, StepMode};

/// Why a command is refused; displays as the text after `! `.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub(super) enum RequestRefusal {
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

/// The answer to a query in both feedback modes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct QueryAnswer {
    pub terse: String,
    pub verbose: String,
}

impl QueryAnswer {
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

/// `<phrase><n>[ unit]` for a parameter of one axis.
pub(super) fn parameter(axis: AxisName, parameter: AxisParameter, n: i32) -> QueryAnswer {
    let verbose = match parameter {
        AxisParameter::Position => format!("Current {axis} position is {n}"),
        AxisParameter::RelativePosition => format!("Target {axis} position is {n}"),
        AxisParameter::Minimum => format!("Minimum {axis} position is {n}"),
        AxisParameter::Maximum => format!("Maximum {axis} position is {n}"),
        AxisParameter::UserMinimum => format!("Minimum user {axis} position is {n}"),
        AxisParameter::UserMaximum => format!("Maximum user {axis} position is {n}"),
        AxisParameter::Speed => format!("Target {axis} speed is {n} positions/sec"),
        AxisParameter::SpeedDelta => format!("Current {axis} speed is {n} positions/sec"),
        AxisParameter::Acceleration => format!("{axis} acceleration is {n} positions/sec^2"),
        AxisParameter::Base => format!("Current {axis} base speed is {n} positions/sec"),
        AxisParameter::Upper => format!("Maximum {axis} speed is {n} positions/sec"),
        AxisParameter::Lower => format!("Minimum {axis} speed is {n} positions/sec"),
        AxisParameter::Resolution => format!("{n} seconds arc per {axis} position"),
    };
    QueryAnswer::new(n, verbose)
}

/// `PR` `TR`: four decimals, truncated (185.142857 prints as 185.1428).
pub(super) fn resolution(
    axis: AxisName,
    model: HeadModel,
    mode_counts: f64,
    e_series: bool,
) -> QueryAnswer {
    let printed = (model.half_step_arcsec() / mode_counts * 1e4 + 1e-6).floor() / 1e4;
    let terse = format!("{printed:.4}");
    let per = if e_series {
        "per position".to_owned()
    } else {
        format!("per {axis} position")
    };
    QueryAnswer {
        verbose: format!("{terse} seconds arc {per}"),
        terse,
    }
}

/// `PH` `TH`.
pub(super) fn hold(axis: AxisName, settings: &AxisSettings) -> QueryAnswer {
    let (terse, word) = match settings.hold {
        HoldPowerMode::Regular => ("REG", "REGULAR"),
        HoldPowerMode::Low => ("LOW", "LOW"),
        HoldPowerMode::Off => ("OFF", "OFF"),
    };
    QueryAnswer::new(terse, format!("{axis} in {word} hold power mode"))
}

/// `PM` `TM`.
pub(super) fn moving(axis: AxisName, settings: &AxisSettings) -> QueryAnswer {
    let (terse, word) = match settings.moving {
        MovePowerMode::High => ("HIGH", "HIGH"),
        MovePowerMode::Regular => ("REG", "REGULAR"),
        MovePowerMode::Low => ("LOW", "LOW"),
    };
    QueryAnswer::new(terse, format!("{axis} in {word} move power mode"))
}

/// `WP` `WT`; the verbose text is not documented.
pub(super) fn step_mode(axis: AxisName, settings: &AxisSettings) -> QueryAnswer {
    let (terse, word) = match settings.step_mode {
        StepMode::Full => ("F", "FULL"),
        StepMode::Half => ("H", "HALF"),
        StepMode::Quarter => ("Q", "QUARTER"),
        StepMode::Eighth => ("E", "EIGHTH"),
        StepMode::Auto => ("A", "AUTO"),
    };
    QueryAnswer::new(terse, format!("{axis} in {word} step mode"))
}

/// `L`.
pub(super) fn limits(mode: LimitMode) -> QueryAnswer {
    QueryAnswer::same(match mode {
        LimitMode::Factory => "Limit bounds are ENABLED (soft limits enabled)",
        LimitMode::User => "Limit bounds are ENABLED (user limits enabled)",
        LimitMode::Off => "Limit bounds are DISABLED (hard limits only: use care)",
    })
}

/// `E`.
pub(super) fn echo(on: bool) -> QueryAnswer {
    QueryAnswer::same(if on { "Echoing ON" } else { "Echoing OFF" })
}

/// `F`.
pub(super) fn feedback(verbose: bool) -> QueryAnswer {
    QueryAnswer::same(if verbose {
        "ASCII verbose mode"
    } else {
        "ASCII terse mode"
    })
}

/// `C`.
pub(super) fn control(velocity: bool, e_series: bool) -> QueryAnswer {
    QueryAnswer::same(match (velocity, e_series) {
        (false, false) => "independent (default) speed control mode",
        (true, false) => "pure velocity speed control mode",
        (false, true) => "Independent speed control mode",
        (true, true) => "Pure Velocity speed control mode",
    })
}

/// `IQ`.
pub(super) fn execution(slaved: bool) -> QueryAnswer {
    let (terse, word) = if slaved {
        ("S", "SLAVED")
    } else {
        ("I", "IMMEDIATE")
    };
    QueryAnswer::new(terse, format!("{word} execution mode"))
}

/// `MQ`; the text is not documented.
pub(super) fn scan_at_power_up(on: bool) -> QueryAnswer {
    let (terse, word) = if on {
        ("E", "ENABLED")
    } else {
        ("D", "DISABLED")
    };
    QueryAnswer::new(terse, format!("Monitor mode at power up is {word}"))
}

/// `O`.
pub(super) fn supply(supply: &Supply) -> QueryAnswer {
    let [head, pan, tilt] = supply.temperature_f;
    QueryAnswer {
        terse: format!("{:.1},{head:.0},{pan:.0},{tilt:.0}", supply.volts),
        verbose: format!("Input {:.0} VDC @ {head:.0} degF", supply.volts),
    }
}

/// `U`.
pub(super) fn unit_id(id: u8) -> QueryAnswer {
    QueryAnswer::new(id, format!("Unit ID is {id}"))
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
