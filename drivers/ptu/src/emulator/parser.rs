//! From the text of a request to a [`HeadRequest`] (ptu-d46 sections 2 and 6).

use super::axis_name::AxisName;
use super::command::{
    AxisParameter, DefaultsAction, HeadRequest, LimitAction, ModeSwitch, PresetAction,
};
use super::replies::RequestRefusal;
use super::settings::{HoldPowerMode, MovePowerMode, ScanRange, StepMode};

/// Collects bytes into requests.
#[derive(Debug, Default)]
pub(super) struct RequestBuffer {
    text: Vec<u8>,
    overlong: bool,
}

impl RequestBuffer {
    /// Takes one byte; returns the text of a request that the byte completes.
    pub(super) fn push(&mut self, byte: u8) -> Option<Vec<u8>> {
        if is_delimiter(byte) {
            if std::mem::take(&mut self.overlong) {
                // Longer than any command: becomes an unknown one, which is refused.
                self.text = vec![b'#'];
            }
            return (!self.text.is_empty()).then(|| std::mem::take(&mut self.text));
        }
        if self.text.len() < super::constants::MAX_COMMAND_BYTES {
            self.text.push(byte);
        } else {
            self.overlong = true;
        }
        None
    }
}

pub(super) fn is_delimiter(byte: u8) -> bool {
    matches!(byte, b' ' | b'\r' | b'\n')
}

/// Parses one request.
///
/// # Errors
/// [`RequestRefusal::IllegalCommand`] for anything that is not in the table of ptu-d46 section 6.
pub(super) fn parse(text: &[u8]) -> Result<HeadRequest, RequestRefusal> {
    let text = std::str::from_utf8(text)
        .map_err(|_| RequestRefusal::IllegalCommand)?
        .to_ascii_uppercase();
    let letters = text.bytes().take_while(u8::is_ascii_alphabetic).count();
    let (name, args) = text.split_at(letters);
    parse_unit_request(name, args)
        .or_else(|| parse_axis_request(name, args))
        .ok_or(RequestRefusal::IllegalCommand)
}

fn parse_unit_request(name: &str, args: &str) -> Option<HeadRequest> {
    use HeadRequest as C;
    if name.is_empty() {
        return parse_punctuation(args);
    }
    if !args.is_empty() {
        return match name {
            "U" => Some(C::UnitId(Some(number(args)?))),
            "XS" => Some(C::Preset(PresetAction::Store, number(args)?)),
            "XG" => Some(C::Preset(PresetAction::Go, number(args)?)),
            "XC" => Some(C::Preset(PresetAction::Clear, number(args)?)),
            "B" => Some(C::Batch(Some(numbers::<4>(args)?))),
            "M" => scan_range(args).map(|r| C::Monitor(Some(r))),
            _ => None,
        };
    }
    let switch = |s, on| Some(C::Switch(s, on));
    match name {
        "EE" => switch(ModeSwitch::Echo, Some(true)),
        "ED" => switch(ModeSwitch::Echo, Some(false)),
        "E" => switch(ModeSwitch::Echo, None),
        "FV" => switch(ModeSwitch::Verbose, Some(true)),
        "FT" => switch(ModeSwitch::Verbose, Some(false)),
        "F" => switch(ModeSwitch::Verbose, None),
        "CV" => switch(ModeSwitch::Velocity, Some(true)),
        "CI" => switch(ModeSwitch::Velocity, Some(false)),
        "C" => switch(ModeSwitch::Velocity, None),
        "S" => switch(ModeSwitch::Slaved, Some(true)),
        "I" => switch(ModeSwitch::Slaved, Some(false)),
        "IQ" => switch(ModeSwitch::Slaved, None),
        "ME" => switch(ModeSwitch::ScanAtPowerUp, Some(true)),
        "MD" => switch(ModeSwitch::ScanAtPowerUp, Some(false)),
        "MQ" => switch(ModeSwitch::ScanAtPowerUp, None),
        "LE" => Some(C::Limits(LimitAction::Enable)),
        "LD" => Some(C::Limits(LimitAction::Disable)),
        "LU" => Some(C::Limits(LimitAction::User)),
        "L" => Some(C::Limits(LimitAction::Query)),
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
        "DS" => Some(C::Defaults(DefaultsAction::Save)),
        "DR" => Some(C::Defaults(DefaultsAction::Restore)),
        "DF" => Some(C::Defaults(DefaultsAction::Factory)),
        "V" => Some(C::Version),
        "O" => Some(C::Supply),
        "U" => Some(C::UnitId(None)),
        "B" => Some(C::Batch(None)),
        "BT" => Some(C::BatchTimed),
        "JE" | "JD" | "OOH" | "OOL" => Some(C::OptionBoard),
        _ => None,
    }
}

fn parse_axis_request(name: &str, args: &str) -> Option<HeadRequest> {
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
        return args.is_empty().then_some(HeadRequest::StepMode(axis, mode));
    }
    let (axis, letters) = axis_of(name)?;
    let power = match letters {
        "H" => Some(HeadRequest::HoldPower(axis, None)),
        "HR" => Some(HeadRequest::HoldPower(axis, Some(HoldPowerMode::Regular))),
        "HL" => Some(HeadRequest::HoldPower(axis, Some(HoldPowerMode::Low))),
        "HO" => Some(HeadRequest::HoldPower(axis, Some(HoldPowerMode::Off))),
        "M" => Some(HeadRequest::MovePower(axis, None)),
        "MH" => Some(HeadRequest::MovePower(axis, Some(MovePowerMode::High))),
        "MR" => Some(HeadRequest::MovePower(axis, Some(MovePowerMode::Regular))),
        "ML" => Some(HeadRequest::MovePower(axis, Some(MovePowerMode::Low))),
        _ => None,
    };
    if power.is_some() {
        return power.filter(|_| args.is_empty());
    }
    let parameter = match letters {
        "P" => AxisParameter::Position,
        "O" => AxisParameter::RelativePosition,
        "S" => AxisParameter::Speed,
        "D" => AxisParameter::SpeedDelta,
        "A" => AxisParameter::Acceleration,
        "B" => AxisParameter::Base,
        "U" => AxisParameter::Upper,
        "L" => AxisParameter::Lower,
        "N" => AxisParameter::Minimum,
        "X" => AxisParameter::Maximum,
        "NU" => AxisParameter::UserMinimum,
        "XU" => AxisParameter::UserMaximum,
        "R" => AxisParameter::Resolution,
        _ => return None,
    };
    let value = if args.is_empty() {
        None
    } else {
        Some(number(args)?)
    };
    Some(HeadRequest::Axis(axis, parameter, value))
}

fn parse_punctuation(text: &str) -> Option<HeadRequest> {
    if text == "?" {
        return Some(HeadRequest::Menu);
    }
    if let Some(id) = text.strip_prefix('_') {
        return number(id).map(HeadRequest::Select);
    }
    let port = text.strip_prefix('@')?;
    if port.starts_with('A') || port.starts_with('B') {
        return Some(HeadRequest::OptionBoard);
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
        .then_some(HeadRequest::HostPort { baud, gap_ms, keep })
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
        let pan = |q, n| Ok(HeadRequest::Axis(AxisName::Pan, q, n));
        assert_eq!(parse(b"pp-2500"), pan(AxisParameter::Position, Some(-2500)));
        assert_eq!(parse(b"Pp+7"), pan(AxisParameter::Position, Some(7)));
        assert_eq!(parse(b"PXU"), pan(AxisParameter::UserMaximum, None));
        assert_eq!(
            parse(b"wta"),
            Ok(HeadRequest::StepMode(AxisName::Tilt, Some(StepMode::Auto)))
        );
        assert_eq!(
            parse(b"@(19200,5,T)"),
            Ok(HeadRequest::HostPort {
                baud: 19200,
                gap_ms: 5,
                keep: true
            })
        );
        assert_eq!(
            parse(b"m1,2"),
            Ok(HeadRequest::Monitor(Some([Some((1, 2)), None])))
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
            assert_eq!(parse(bad), Err(RequestRefusal::IllegalCommand), "{bad:?}");
        }
    }
}
