//! The commands this driver sends, and what each must be answered with.

use crate::{Axis, HoldPower, MovePower};

/// A numeric property of one axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Quantity {
    Position,
    Target,
    SpeedNow,
    Resolution,
    MinPosition,
    MaxPosition,
    SpeedMin,
    SpeedMax,
    Speed,
    Acceleration,
    BaseSpeed,
}

impl Quantity {
    const fn letter(self) -> &'static str {
        match self {
            Self::Position => "P",
            Self::Target => "O",
            Self::SpeedNow => "D",
            Self::Resolution => "R",
            Self::MinPosition => "N",
            Self::MaxPosition => "X",
            Self::SpeedMin => "L",
            Self::SpeedMax => "U",
            Self::Speed => "S",
            Self::Acceleration => "A",
            Self::BaseSpeed => "B",
        }
    }
}

/// One command of section 6. All but the reset may be repeated without harm: targets and speeds are absolute.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Command {
    EchoOff,
    Terse,
    Version,
    Halt,
    HaltAxis(Axis),
    Independent,
    Immediate,
    LimitsOn,
    EchoState,
    FeedbackState,
    ControlState,
    LimitState,
    Query(Axis, Quantity),
    SetSpeed(Axis, i32),
    MoveTo(Axis, i32),
    HoldLow(Axis),
    SetHold(Axis, HoldPower),
    SetMove(Axis, MovePower),
    HoldState(Axis),
    MoveState(Axis),
    Supply,
    Reset,
}

/// The form of a fitting reply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Expected {
    /// `*` alone.
    Done,
    /// `*`, perhaps with words, but no bare number: some units answer `CI` with the mode's name (section 12, second row).
    DoneOrWords,
    /// A whole number.
    Whole,
    /// A number with decimals.
    Decimal,
    /// A text with letters or numbers in it.
    Text,
    /// A text that holds one of two words: the wanted one, or the other.
    Either {
        wanted: &'static str,
        other: &'static str,
    },
}

impl Command {
    /// The letters and number, without the delimiter.
    pub(crate) fn text(self) -> String {
        match self {
            Self::EchoOff => "ED".into(),
            Self::Terse => "FT".into(),
            Self::Version => "V".into(),
            Self::Halt => "H".into(),
            Self::Independent => "CI".into(),
            Self::Immediate => "I".into(),
            Self::LimitsOn => "LE".into(),
            Self::EchoState => "E".into(),
            Self::FeedbackState => "F".into(),
            Self::ControlState => "C".into(),
            Self::LimitState => "L".into(),
            Self::Query(axis, quantity) => format!("{}{}", axis.letter(), quantity.letter()),
            Self::SetSpeed(axis, speed) => format!("{}S{speed}", axis.letter()),
            Self::MoveTo(axis, steps) => format!("{}P{steps}", axis.letter()),
            Self::HaltAxis(axis) => format!("H{}", axis.letter()),
            Self::HoldLow(axis) => format!("{}HL", axis.letter()),
            Self::SetHold(axis, power) => format!("{}H{}", axis.letter(), power.letter()),
            Self::SetMove(axis, power) => format!("{}M{}", axis.letter(), power.letter()),
            Self::HoldState(axis) => format!("{}H", axis.letter()),
            Self::MoveState(axis) => format!("{}M", axis.letter()),
            Self::Supply => "O".into(),
            Self::Reset => "R".into(),
        }
    }

    /// The bytes on the wire: a space ends a command and adds no line end to an echo (section 2).
    pub(crate) fn wire(self) -> Vec<u8> {
        let mut text = self.text();
        text.push(' ');
        text.into_bytes()
    }

    pub(crate) const fn expected(self) -> Expected {
        match self {
            Self::Query(_, Quantity::Resolution) => Expected::Decimal,
            Self::Query(..) => Expected::Whole,
            Self::Version | Self::Supply | Self::HoldState(_) | Self::MoveState(_) => {
                Expected::Text
            }
            Self::Independent => Expected::DoneOrWords,
            Self::EchoState => Expected::Either {
                wanted: "off",
                other: "on",
            },
            Self::FeedbackState => Expected::Either {
                wanted: "terse",
                other: "verbose",
            },
            Self::ControlState => Expected::Either {
                wanted: "independent",
                other: "pure",
            },
            Self::LimitState => Expected::Either {
                wanted: "enabled",
                other: "disabled",
            },
            _ => Expected::Done,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_wire_has_letters_number_space() {
        assert_eq!(
            Command::Query(Axis::Tilt, Quantity::Position).wire(),
            b"TP "
        );
        assert_eq!(Command::MoveTo(Axis::Pan, -2500).wire(), b"PP-2500 ");
        assert_eq!(Command::SetSpeed(Axis::Tilt, 97).wire(), b"TS97 ");
        assert_eq!(
            Command::Query(Axis::Pan, Quantity::MaxPosition).wire(),
            b"PX "
        );
        assert_eq!(Command::HoldLow(Axis::Tilt).wire(), b"THL ");
        assert_eq!(Command::SetHold(Axis::Pan, HoldPower::Off).wire(), b"PHO ");
        assert_eq!(
            Command::SetMove(Axis::Tilt, MovePower::High).wire(),
            b"TMH "
        );
        assert_eq!(Command::HaltAxis(Axis::Tilt).wire(), b"HT ");
        assert_eq!(Command::MoveState(Axis::Pan).wire(), b"PM ");
        assert_eq!(Command::Query(Axis::Pan, Quantity::SpeedNow).wire(), b"PD ");
        assert_eq!(Command::Query(Axis::Tilt, Quantity::Target).wire(), b"TO ");
    }
}
