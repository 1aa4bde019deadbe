//! The requests of ptu-d46 section 6 as types.

use super::axis_name::AxisName;
use super::settings::{HoldPowerMode, MovePowerMode, ScanRange, StepMode};

/// A parameter of one axis, set with a number, queried without.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum AxisParameter {
    /// `xP`
    Position,
    /// `xO`
    RelativePosition,
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

/// A mode of the whole unit, switched on or off, or queried.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ModeSwitch {
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

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PresetAction {
    Store,
    Go,
    Clear,
}

/// Enforcement of the limits (`LE LD LU L`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LimitAction {
    Enable,
    Disable,
    User,
    Query,
}

/// What to do with the saved settings (`DS DR DF`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum DefaultsAction {
    Save,
    Restore,
    Factory,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum HeadRequest {
    Axis(AxisName, AxisParameter, Option<i32>),
    HoldPower(AxisName, Option<HoldPowerMode>),
    MovePower(AxisName, Option<MovePowerMode>),
    StepMode(AxisName, Option<StepMode>),
    Switch(ModeSwitch, Option<bool>),
    Limits(LimitAction),
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
    Defaults(DefaultsAction),
    Version,
    Supply,
    HostPort {
        baud: u32,
        gap_ms: i32,
        keep: bool,
    },
    UnitId(Option<i32>),
    Select(i32),
    Preset(PresetAction, i32),
    Batch(Option<[i32; 4]>),
    BatchTimed,
    Menu,
    /// `@A @B JE JD OOH OOL`
    OptionBoard,
}
