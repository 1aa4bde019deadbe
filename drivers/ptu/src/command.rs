//! The commands that the driver sends, and the form of the reply that each expects.

use std::time::Duration;

use crate::Axis;
use crate::constants::{CALIBRATION_TIMEOUT, REPLY_TIMEOUT};

/// A numeric property of one axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum AxisProperty {
    Position,
    Resolution,
    MinPosition,
    MaxPosition,
    MinSpeed,
    MaxSpeed,
    Speed,
    Acceleration,
    BaseSpeed,
}

impl AxisProperty {
    const fn letter(self) -> &'static str {
        match self {
            Self::Position => "P",
            Self::Resolution => "R",
            Self::MinPosition => "N",
            Self::MaxPosition => "X",
            Self::MinSpeed => "L",
            Self::MaxSpeed => "U",
            Self::Speed => "S",
            Self::Acceleration => "A",
            Self::BaseSpeed => "B",
        }
    }
}

/// A command of ptu-d46 section 6. All but the reset may be repeated without harm: targets and speeds are absolute.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PtuCommand {
    EchoOff,
    Terse,
    QueryVersion,
    Halt,
    IndependentMode,
    ImmediateMode,
    LimitsOn,
    QueryEcho,
    QueryFeedback,
    QueryControlMode,
    QueryLimits,
    Query(Axis, AxisProperty),
    SetSpeed(Axis, i32),
    MoveTo(Axis, i32),
    SetHoldPowerLow(Axis),
    QueryHoldPower(Axis),
    QueryMovePower(Axis),
    QuerySupply,
    Reset,
}

/// The form of a valid reply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ExpectedReply {
    /// `*` alone.
    Ack,
    /// `*`, perhaps with a text, but no bare number: some units answer `CI` with the mode's name (ptu-d46 section 12, second row).
    AckOrText,
    Integer,
    Decimal,
    /// Any text but an empty one.
    Text,
    /// A text that contains one of two keywords.
    Keyword {
        wanted: &'static str,
        other: &'static str,
    },
}

impl PtuCommand {
    /// Letters and number, without the delimiter.
    pub(crate) fn to_text(self) -> String {
        match self {
            Self::EchoOff => "ED".into(),
            Self::Terse => "FT".into(),
            Self::QueryVersion => "V".into(),
            Self::Halt => "H".into(),
            Self::IndependentMode => "CI".into(),
            Self::ImmediateMode => "I".into(),
            Self::LimitsOn => "LE".into(),
            Self::QueryEcho => "E".into(),
            Self::QueryFeedback => "F".into(),
            Self::QueryControlMode => "C".into(),
            Self::QueryLimits => "L".into(),
            Self::Query(axis, property) => format!("{}{}", axis.letter(), property.letter()),
            Self::SetSpeed(axis, speed) => format!("{}S{speed}", axis.letter()),
            Self::MoveTo(axis, steps) => format!("{}P{steps}", axis.letter()),
            Self::SetHoldPowerLow(axis) => format!("{}HL", axis.letter()),
            Self::QueryHoldPower(axis) => format!("{}H", axis.letter()),
            Self::QueryMovePower(axis) => format!("{}M", axis.letter()),
            Self::QuerySupply => "O".into(),
            Self::Reset => "R".into(),
        }
    }

    /// The bytes on the wire. A space ends the command: unlike CR it adds no line end to an echo (ptu-d46 section 2).
    pub(crate) fn to_bytes(self) -> Vec<u8> {
        let mut text = self.to_text();
        text.push(' ');
        text.into_bytes()
    }

    pub(crate) const fn reply_timeout(self) -> Duration {
        match self {
            Self::Reset => CALIBRATION_TIMEOUT,
            _ => REPLY_TIMEOUT,
        }
    }

    pub(crate) const fn expected_reply(self) -> ExpectedReply {
        match self {
            Self::Query(_, AxisProperty::Resolution) => ExpectedReply::Decimal,
            Self::Query(..) => ExpectedReply::Integer,
            Self::QueryVersion
            | Self::QuerySupply
            | Self::QueryHoldPower(_)
            | Self::QueryMovePower(_) => ExpectedReply::Text,
            Self::IndependentMode => ExpectedReply::AckOrText,
            Self::QueryEcho => ExpectedReply::Keyword {
                wanted: "off",
                other: "on",
            },
            Self::QueryFeedback => ExpectedReply::Keyword {
                wanted: "terse",
                other: "verbose",
            },
            Self::QueryControlMode => ExpectedReply::Keyword {
                wanted: "independent",
                other: "pure",
            },
            Self::QueryLimits => ExpectedReply::Keyword {
                wanted: "enabled",
                other: "disabled",
            },
            _ => ExpectedReply::Ack,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_is_letters_number_space() {
        assert_eq!(
            PtuCommand::Query(Axis::Tilt, AxisProperty::Position).to_bytes(),
            b"TP "
        );
        assert_eq!(PtuCommand::MoveTo(Axis::Pan, -2500).to_bytes(), b"PP-2500 ");
        assert_eq!(PtuCommand::SetSpeed(Axis::Tilt, 97).to_bytes(), b"TS97 ");
        assert_eq!(
            PtuCommand::Query(Axis::Pan, AxisProperty::MaxPosition).to_bytes(),
            b"PX "
        );
        assert_eq!(PtuCommand::SetHoldPowerLow(Axis::Tilt).to_bytes(), b"THL ");
        assert_eq!(PtuCommand::QueryMovePower(Axis::Pan).to_bytes(), b"PM ");
    }
}
