//! The requests of section 6 as a type.

use super::names::AxisName;
use super::settings::{HoldPower, MovePower, ScanRange, StepMode};

/// A figure that belongs to one axis; with a number it is set, without it is asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    /// `xP`
    Position,
    /// `xO`
    Offset,
    /// `xS`
    Speed,
    /// `xD`
    SpeedDelta,
    /// `xA`
    Acceleration,
    /// `xB`
    Base,
    /// `xU`
    Upper,
    /// `xL`
    Lower,
    /// `xN`
    Minimum,
    /// `xX`
    Maximum,
    /// `xNU`
    UserMinimum,
    /// `xXU`
    UserMaximum,
    /// `xR`
    Resolution,
}

/// A switch of the whole unit; `None` asks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Switch {
    /// `EE` `ED` `E`
    Echo,
    /// `FV` `FT` `F`
    Verbose,
    /// `CV` `CI` `C`
    Velocity,
    /// `S` `I` `IQ`
    Slaved,
    /// `ME` `MD` `MQ`
    ScanAtPowerUp,
}

/// What to do with a preset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Preset {
    Store,
    Go,
    Clear,
}

/// How limits are to be enforced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LimitCommand {
    Enable,
    Disable,
    User,
    Query,
}

/// Which saved settings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Defaults {
    Save,
    Restore,
    Factory,
}

/// One request.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Command {
    Axis(AxisName, Quantity, Option<i32>),
    Hold(AxisName, Option<HoldPower>),
    Moving(AxisName, Option<MovePower>),
    Step(AxisName, Option<StepMode>),
    Switch(Switch, Option<bool>),
    Limits(LimitCommand),
    Await,
    Halt {
        pan: bool,
        tilt: bool,
    },
    Monitor(Option<ScanRange>),
    Reset,
    /// `RE RP RT RD`
    ResetSelect {
        pan: bool,
        tilt: bool,
    },
    Defaults(Defaults),
    Version,
    Supply,
    HostPort {
        baud: u32,
        gap_ms: i32,
        keep: bool,
    },
    UnitId(Option<i32>),
    Select(i32),
    Preset(Preset, i32),
    Batch(Option<[i32; 4]>),
    BatchTimed,
    Menu,
    /// `@A @B JE JD OOH OOL`
    OptionBoard,
}
