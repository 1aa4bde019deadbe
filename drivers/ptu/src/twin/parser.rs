//! Text of one request to a `Command` (sections 2 and 6).

use super::command::{Command, Defaults, LimitCommand, Preset, Quantity, Switch};
use super::names::AxisName;
use super::replies::Refusal;
use super::settings::{HoldPower, MovePower, ScanRange, StepMode};

/// Collects bytes into requests.
#[derive(Debug, Default)]
pub(super) struct LineParser {
    text: Vec<u8>,
    overlong: bool,
}

impl LineParser {
    /// Takes one byte; a delimiter that ends a non-empty request gives its text.
    pub(super) fn feed(&mut self, byte: u8) -> Option<Vec<u8>> {
        if is_delimiter(byte) {
            if std::mem::take(&mut self.overlong) {
                // Longer than any command: answered, as illegal.
                self.text = vec![b'#'];
            }
            return (!self.text.is_empty()).then(|| std::mem::take(&mut self.text));
        }
        if self.text.len() < super::constants::COMMAND_BYTES {
            self.text.push(byte);
        } else {
            self.overlong = true;
        }
        None
    }
}

/// Space, CR or LF.
pub(super) fn is_delimiter(byte: u8) -> bool {
    matches!(byte, b' ' | b'\r' | b'\n')
}

/// Reads one request.
///
/// # Errors
/// [`Refusal::IllegalCommand`] for anything that is not in the table of section 6.
pub(super) fn parse(text: &[u8]) -> Result<Command, Refusal> {
    let text = std::str::from_utf8(text)
        .map_err(|_| Refusal::IllegalCommand)?
        .to_ascii_uppercase();
    let letters = text.bytes().take_while(u8::is_ascii_alphabetic).count();
    let (name, args) = text.split_at(letters);
    whole_unit(name, args)
        .or_else(|| one_axis(name, args))
        .ok_or(Refusal::IllegalCommand)
}

fn whole_unit(name: &str, args: &str) -> Option<Command> {
    use Command as C;
    if name.is_empty() {
        return punctuated(args);
    }
    if !args.is_empty() {
        return match name {
            "U" => Some(C::UnitId(Some(number(args)?))),
            "XS" => Some(C::Preset(Preset::Store, number(args)?)),
            "XG" => Some(C::Preset(Preset::Go, number(args)?)),
            "XC" => Some(C::Preset(Preset::Clear, number(args)?)),
            "B" => Some(C::Batch(Some(numbers::<4>(args)?))),
            "M" => scan_range(args).map(|r| C::Monitor(Some(r))),
            _ => None,
        };
    }
    let switch = |s, on| Some(C::Switch(s, on));
    match name {
        "EE" => switch(Switch::Echo, Some(true)),
        "ED" => switch(Switch::Echo, Some(false)),
        "E" => switch(Switch::Echo, None),
        "FV" => switch(Switch::Verbose, Some(true)),
        "FT" => switch(Switch::Verbose, Some(false)),
        "F" => switch(Switch::Verbose, None),
        "CV" => switch(Switch::Velocity, Some(true)),
        "CI" => switch(Switch::Velocity, Some(false)),
        "C" => switch(Switch::Velocity, None),
        "S" => switch(Switch::Slaved, Some(true)),
        "I" => switch(Switch::Slaved, Some(false)),
        "IQ" => switch(Switch::Slaved, None),
        "ME" => switch(Switch::ScanAtPowerUp, Some(true)),
        "MD" => switch(Switch::ScanAtPowerUp, Some(false)),
        "MQ" => switch(Switch::ScanAtPowerUp, None),
        "LE" => Some(C::Limits(LimitCommand::Enable)),
        "LD" => Some(C::Limits(LimitCommand::Disable)),
        "LU" => Some(C::Limits(LimitCommand::User)),
        "L" => Some(C::Limits(LimitCommand::Query)),
        "A" => Some(C::Await),
        "H" => Some(C::Halt {
            pan: true,
            tilt: true,
        }),
        "HP" => Some(C::Halt {
            pan: true,
            tilt: false,
        }),
        "HT" => Some(C::Halt {
            pan: false,
            tilt: true,
        }),
        "M" => Some(C::Monitor(None)),
        "R" => Some(C::Reset),
        "RE" => Some(C::ResetSelect {
            pan: true,
            tilt: true,
        }),
        "RP" => Some(C::ResetSelect {
            pan: true,
            tilt: false,
        }),
        "RT" => Some(C::ResetSelect {
            pan: false,
            tilt: true,
        }),
        "RD" => Some(C::ResetSelect {
            pan: false,
            tilt: false,
        }),
        "DS" => Some(C::Defaults(Defaults::Save)),
        "DR" => Some(C::Defaults(Defaults::Restore)),
        "DF" => Some(C::Defaults(Defaults::Factory)),
        "V" => Some(C::Version),
        "O" => Some(C::Supply),
        "U" => Some(C::UnitId(None)),
        "B" => Some(C::Batch(None)),
        "BT" => Some(C::BatchTimed),
        "JE" | "JD" | "OOH" | "OOL" => Some(C::OptionBoard),
        _ => None,
    }
}

fn one_axis(name: &str, args: &str) -> Option<Command> {
    if let Some(rest) = name.strip_prefix('W') {
        let (axis, mode) = axis_of(rest)?;
        let mode = match mode {
            "" => None,
            "F" => Some(StepMode::Full),
            "H" => Some(StepMode::Half),
            "Q" => Some(StepMode::Quarter),
            "E" => Some(StepMode::Eighth),
            "A" => Some(StepMode::Auto),
            _ => return None,
        };
        return args.is_empty().then_some(Command::Step(axis, mode));
    }
    let (axis, letters) = axis_of(name)?;
    let power = match letters {
        "H" => Some(Command::Hold(axis, None)),
        "HR" => Some(Command::Hold(axis, Some(HoldPower::Regular))),
        "HL" => Some(Command::Hold(axis, Some(HoldPower::Low))),
        "HO" => Some(Command::Hold(axis, Some(HoldPower::Off))),
        "M" => Some(Command::Moving(axis, None)),
        "MH" => Some(Command::Moving(axis, Some(MovePower::High))),
        "MR" => Some(Command::Moving(axis, Some(MovePower::Regular))),
        "ML" => Some(Command::Moving(axis, Some(MovePower::Low))),
        _ => None,
    };
    if power.is_some() {
        return power.filter(|_| args.is_empty());
    }
    let quantity = match letters {
        "P" => Quantity::Position,
        "O" => Quantity::Offset,
        "S" => Quantity::Speed,
        "D" => Quantity::SpeedDelta,
        "A" => Quantity::Acceleration,
        "B" => Quantity::Base,
        "U" => Quantity::Upper,
        "L" => Quantity::Lower,
        "N" => Quantity::Minimum,
        "X" => Quantity::Maximum,
        "NU" => Quantity::UserMinimum,
        "XU" => Quantity::UserMaximum,
        "R" => Quantity::Resolution,
        _ => return None,
    };
    let value = if args.is_empty() {
        None
    } else {
        Some(number(args)?)
    };
    Some(Command::Axis(axis, quantity, value))
}

fn punctuated(text: &str) -> Option<Command> {
    if text == "?" {
        return Some(Command::Menu);
    }
    if let Some(id) = text.strip_prefix('_') {
        return number(id).map(Command::Select);
    }
    let port = text.strip_prefix('@')?;
    if port.starts_with('A') || port.starts_with('B') {
        return Some(Command::OptionBoard);
    }
    let mut fields = port.strip_prefix('(')?.strip_suffix(')')?.split(',');
    let baud = fields.next()?.parse().ok()?;
    let gap_ms = number(fields.next()?)?;
    let keep = match fields.next()? {
        "T" => true,
        "F" => false,
        _ => return None,
    };
    fields
        .next()
        .is_none()
        .then_some(Command::HostPort { baud, gap_ms, keep })
}

fn axis_of(name: &str) -> Option<(AxisName, &str)> {
    if let Some(rest) = name.strip_prefix('P') {
        Some((AxisName::Pan, rest))
    } else {
        name.strip_prefix('T').map(|rest| (AxisName::Tilt, rest))
    }
}

fn scan_range(args: &str) -> Option<ScanRange> {
    if let Some([a, b]) = numbers::<2>(args) {
        return Some([Some((a, b)), None]);
    }
    let [a, b, c, d] = numbers::<4>(args)?;
    Some([Some((a, b)), Some((c, d))])
}

fn numbers<const N: usize>(args: &str) -> Option<[i32; N]> {
    let all: Option<Vec<i32>> = args.split(',').map(number).collect();
    all?.try_into().ok()
}

/// A signed decimal integer and nothing else.
fn number(text: &str) -> Option<i32> {
    text.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_in_any_case_and_signed_numbers() {
        let pan = |q, n| Ok(Command::Axis(AxisName::Pan, q, n));
        assert_eq!(parse(b"pp-2500"), pan(Quantity::Position, Some(-2500)));
        assert_eq!(parse(b"Pp+7"), pan(Quantity::Position, Some(7)));
        assert_eq!(parse(b"PXU"), pan(Quantity::UserMaximum, None));
        assert_eq!(
            parse(b"wta"),
            Ok(Command::Step(AxisName::Tilt, Some(StepMode::Auto)))
        );
        assert_eq!(
            parse(b"@(19200,5,T)"),
            Ok(Command::HostPort {
                baud: 19200,
                gap_ms: 5,
                keep: true
            })
        );
        assert_eq!(
            parse(b"m1,2"),
            Ok(Command::Monitor(Some([Some((1, 2)), None])))
        );
        for bad in [
            &b"PP--1"[..],
            b"PP1.5",
            b"PP99999999999",
            b"PQ",
            b"@(1,2)",
            b"M1,2,3",
            b"\xff",
            b"PHR5",
            b"_",
            b"#",
        ] {
            assert_eq!(parse(bad), Err(Refusal::IllegalCommand), "{bad:?}");
        }
    }
}
