//! What each status means, per command. Protocol section 6.

use std::fmt;

use crate::encoding::checked_body;
use crate::error::ReplyError;

/// The commands this driver speaks, and no others: an unsupported one can leave a URG-04LX deaf until it is
/// power-cycled (protocol section 13). So intensity is asked of models that are known to have it, several echoes never.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Command {
    /// `SCIP2.0`: leave SCIP 1.1.
    SwitchProtocol,
    /// `VV`: version.
    Version,
    /// `PP`: parameters.
    Parameters,
    /// `II`: state.
    Info,
    /// `BM`: laser on.
    LaserOn,
    /// `QT`: laser off, stop streaming.
    Quit,
    /// `RS`: reset.
    Reset,
    /// `RT`: reset of the measurement only.
    SoftReset,
    /// `TM0`: enter time adjust.
    TimeEnter,
    /// `TM1`: read the timer.
    TimeRead,
    /// `TM2`: leave time adjust.
    TimeLeave,
    /// `GD`, `GS`, `GE`: the latest scan, once.
    Single,
    /// `MD`, `MS`, `ME`: scans as they come.
    Stream,
    /// `SS`: bit rate of the RS-232C.
    BitRate,
    /// `CR`: motor speed.
    MotorSpeed,
    /// `HS`: sensitivity.
    Sensitivity,
    /// `DB`: played malfunctions.
    Rehearsal,
}

impl fmt::Display for Command {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::SwitchProtocol => "SCIP2.0",
            Self::Version => "VV",
            Self::Parameters => "PP",
            Self::Info => "II",
            Self::LaserOn => "BM",
            Self::Quit => "QT",
            Self::Reset => "RS",
            Self::SoftReset => "RT",
            Self::TimeEnter => "TM0",
            Self::TimeRead => "TM1",
            Self::TimeLeave => "TM2",
            Self::Single => "GD/GS/GE",
            Self::Stream => "MD/MS/ME",
            Self::BitRate => "SS",
            Self::MotorSpeed => "CR",
            Self::Sensitivity => "HS",
            Self::Rehearsal => "DB",
        })
    }
}

/// The status of a reply as it stands on the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StatusCode {
    /// One character without a sum: SCIP 1.1, and the answer to `SCIP2.0`.
    Plain(u8),
    /// Two characters whose sum was right.
    Code([u8; 2]),
}

impl StatusCode {
    /// Reads a status line: one character, or two and their sum.
    ///
    /// # Errors
    /// [`ReplyError::Length`] for another length, [`ReplyError::Sum`] for a wrong sum.
    pub fn from_line(line: &[u8]) -> Result<Self, ReplyError> {
        match line {
            [plain] => Ok(Self::Plain(*plain)),
            [_, _, _] => match checked_body(line)? {
                [high, low] => Ok(Self::Code([*high, *low])),
                body => Err(ReplyError::Length {
                    what: "status line",
                    expected: 2,
                    got: body.len(),
                }),
            },
            _ => Err(ReplyError::Length {
                what: "status line",
                expected: 3,
                got: line.len(),
            }),
        }
    }

    /// The status as a decimal number, if it is two digits.
    #[must_use]
    pub fn number(self) -> Option<u8> {
        match self {
            Self::Code([high @ b'0'..=b'9', low @ b'0'..=b'9']) => {
                Some((high - b'0') * 10 + (low - b'0'))
            }
            _ => None,
        }
    }

    /// What it means in a reply to `command`.
    #[must_use]
    pub fn meaning(self, command: Command) -> Meaning {
        match self {
            Self::Plain(b'0') => Meaning::Done,
            Self::Plain(_) => Meaning::OldProtocol,
            Self::Code(code) => self
                .number()
                .map_or_else(|| universal(code), |number| numbered(command, number, code)),
        }
    }
}

impl fmt::Display for StatusCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Plain(byte) => write!(f, "{}", byte.escape_ascii()),
            Self::Code(code) => write!(f, "{}", code.escape_ascii()),
        }
    }
}

/// What a status says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Meaning {
    /// `00`: done.
    Done,
    /// `99` of a stream: a scan follows.
    Data,
    /// Single character other than `0`: the device speaks SCIP 1.1.
    OldProtocol,
    /// The device already is in the state asked for (`BM` 02, `TM0` 02, `TM2` 03, `SS`/`CR` 03, `HS` 02, `DB` 02 and 03).
    AlreadySo,
    /// `BM` 01: the laser is broken.
    LaserMalfunction,
    /// `GD` 10: the laser is off.
    LaserOff,
    /// 10 of SCIP 2.2: not in this state (time adjust, streaming, asleep).
    Denied,
    /// `TM1` 04: not in time adjust.
    NotAdjusting,
    /// A parameter is not a number or out of range.
    BadParameter(Parameter),
    /// The model has no such setting (`SS`, `CR`, `DB` 04, `HS` 03).
    NotSupported,
    /// 21 to 49 of a stream: stopped to verify an error.
    Verifying(u8),
    /// 98 of a stream: the laser proved normal, scans go on.
    Resumed,
    /// 50 to 97: hardware trouble.
    HardwareTrouble(u8),
    /// `0A`: the reply cannot be built.
    CannotReply,
    /// `0B`: short of buffers, or the same command is still under way.
    Busy,
    /// `0C`, `0F`: too few parameters.
    MissingParameters,
    /// `0D`, `0E`: no such command, or not in this mode (time adjust).
    Undefined,
    /// `0G`: the string is too long.
    StringTooLong,
    /// `0H`: the string has a forbidden character.
    StringCharacter,
    /// `0I`: firmware update mode.
    FirmwareUpdate,
    /// `0L`, `0M` of SCIP 2.2: abnormal or unstable. `DB` 05: in error.
    Unstable,
    /// None of the protocol's.
    Unknown([u8; 2]),
}

/// The parameter a status complains about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are the protocol's")]
pub enum Parameter {
    StartNotNumeric,
    EndNotNumeric,
    ClusterNotNumeric,
    EndOutOfRange,
    EndBeforeStart,
    IntervalNotNumeric,
    CountNotNumeric,
    ControlCode,
    NotNumeric,
    OutOfRange,
}

fn numbered(command: Command, number: u8, code: [u8; 2]) -> Meaning {
    use Command as C;
    use Meaning as M;
    use Parameter as P;
    match (command, number) {
        (_, 0) => M::Done,
        (C::Single | C::Stream, 1) => M::BadParameter(P::StartNotNumeric),
        (C::Single | C::Stream, 2) => M::BadParameter(P::EndNotNumeric),
        (C::Single | C::Stream, 3) => M::BadParameter(P::ClusterNotNumeric),
        (C::Single | C::Stream, 4) => M::BadParameter(P::EndOutOfRange),
        (C::Single | C::Stream, 5) => M::BadParameter(P::EndBeforeStart),
        (C::Stream, 6) => M::BadParameter(P::IntervalNotNumeric),
        (C::Stream, 7) => M::BadParameter(P::CountNotNumeric),
        (C::Single, 10) => M::LaserOff,
        (C::Stream, 21..=49) => M::Verifying(number),
        (C::Single, 50..=98) | (C::Stream, 50..=97) => M::HardwareTrouble(number),
        (C::Stream, 98) => M::Resumed,
        (C::Stream, 99) => M::Data,
        (C::LaserOn, 1) => M::LaserMalfunction,
        (C::TimeEnter | C::TimeRead | C::TimeLeave, 1) => M::BadParameter(P::ControlCode),
        (C::LaserOn | C::TimeEnter | C::Sensitivity | C::Rehearsal, 2)
        | (C::TimeLeave | C::BitRate | C::MotorSpeed | C::Rehearsal, 3) => M::AlreadySo,
        (C::Rehearsal, 5) => M::Unstable,
        (C::TimeRead, 4) => M::NotAdjusting,
        (C::BitRate | C::MotorSpeed | C::Sensitivity | C::Rehearsal, 1) => {
            M::BadParameter(P::NotNumeric)
        }
        (C::BitRate | C::MotorSpeed, 2) => M::BadParameter(P::OutOfRange),
        (C::BitRate | C::MotorSpeed | C::Rehearsal, 4) | (C::Sensitivity, 3) => M::NotSupported,
        (_, 10) => M::Denied,
        _ => M::Unknown(code),
    }
}

fn universal(code: [u8; 2]) -> Meaning {
    match &code {
        b"0A" => Meaning::CannotReply,
        b"0B" => Meaning::Busy,
        b"0C" | b"0F" => Meaning::MissingParameters,
        b"0D" | b"0E" => Meaning::Undefined,
        b"0G" => Meaning::StringTooLong,
        b"0H" => Meaning::StringCharacter,
        b"0I" => Meaning::FirmwareUpdate,
        b"0L" | b"0M" => Meaning::Unstable,
        _ => Meaning::Unknown(code),
    }
}

impl fmt::Display for Meaning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Done => f.write_str("done"),
            Self::Data => f.write_str("scan data"),
            Self::OldProtocol => f.write_str("the sensor speaks SCIP 1.1"),
            Self::AlreadySo => f.write_str("already so"),
            Self::LaserMalfunction => f.write_str("the laser is broken"),
            Self::LaserOff => f.write_str("the laser is off"),
            Self::Denied => f.write_str("not possible in the sensor's present state"),
            Self::NotAdjusting => f.write_str("not in time-adjust mode"),
            Self::BadParameter(parameter) => write!(f, "bad parameter ({parameter:?})"),
            Self::NotSupported => f.write_str("not supported by this model"),
            Self::Verifying(number) => write!(f, "stopped to verify an error ({number})"),
            Self::Resumed => f.write_str("resumed, the laser is normal"),
            Self::HardwareTrouble(number) => write!(f, "hardware trouble ({number})"),
            Self::CannotReply => f.write_str("the sensor cannot build the reply"),
            Self::Busy => f.write_str("busy: the same command is under way, or no buffer"),
            Self::MissingParameters => f.write_str("too few parameters"),
            Self::Undefined => f.write_str("undefined command, or not in this mode"),
            Self::StringTooLong => f.write_str("string too long"),
            Self::StringCharacter => f.write_str("forbidden character in the string"),
            Self::FirmwareUpdate => f.write_str("firmware update mode"),
            Self::Unstable => f.write_str("abnormal or unstable state"),
            Self::Unknown(code) => write!(f, "unknown status {}", code.escape_ascii()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn meaning(line: &[u8], command: Command) -> Meaning {
        StatusCode::from_line(line)
            .expect("sum is right")
            .meaning(command)
    }

    #[test]
    fn real_status_lines_mean_what_the_command_says() {
        assert_eq!(meaning(b"00P", Command::Quit), Meaning::Done);
        assert_eq!(meaning(b"02R", Command::LaserOn), Meaning::AlreadySo);
        assert_eq!(meaning(b"03S", Command::MotorSpeed), Meaning::AlreadySo);
        assert_eq!(meaning(b"03S", Command::Sensitivity), Meaning::NotSupported);
        assert_eq!(
            meaning(b"03S", Command::Stream),
            Meaning::BadParameter(Parameter::ClusterNotNumeric)
        );
        assert_eq!(
            meaning(b"0Cc", Command::Sensitivity),
            Meaning::MissingParameters
        );
        assert_eq!(meaning(b"0Ee", Command::SwitchProtocol), Meaning::Undefined);
        assert_eq!(meaning(b"99b", Command::Stream), Meaning::Data);
        assert_eq!(meaning(b"98a", Command::Stream), Meaning::Resumed);
        assert_eq!(meaning(b"E", Command::Quit), Meaning::OldProtocol);
        assert_eq!(meaning(b"0", Command::SwitchProtocol), Meaning::Done);
    }

    #[test]
    fn ranges_of_a_stream() {
        let of = |code: &[u8; 2]| StatusCode::Code(*code).meaning(Command::Stream);
        assert_eq!(of(b"21"), Meaning::Verifying(21));
        assert_eq!(of(b"49"), Meaning::Verifying(49));
        assert_eq!(of(b"50"), Meaning::HardwareTrouble(50));
        assert_eq!(of(b"97"), Meaning::HardwareTrouble(97));
        assert_eq!(of(b"20"), Meaning::Unknown(*b"20"));
    }

    #[test]
    fn damaged_status_lines_are_errors() {
        assert!(matches!(
            StatusCode::from_line(b"00Q"),
            Err(ReplyError::Sum { .. })
        ));
        assert!(matches!(
            StatusCode::from_line(b"00"),
            Err(ReplyError::Length { .. })
        ));
        assert!(matches!(
            StatusCode::from_line(b""),
            Err(ReplyError::Length { .. })
        ));
    }
}
