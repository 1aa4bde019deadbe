//! The driver's commands, and what each status means for each of them (scip2 section 6).

use std::fmt;

/// The commands that the driver sends. An unsupported one can leave a URG-04LX unresponsive until a power cycle (scip2
/// section 13), so intensity is asked for only where the model is known to have it, and multiple echoes never.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ScipCommand {
    /// `SCIP2.0`: leave SCIP 1.1.
    SwitchProtocol,
    /// `VV`: version.
    Version,
    /// `PP`: parameters.
    Parameters,
    /// `II`: state.
    Info,
    /// `QT`: laser off, stop streaming.
    Quit,
    /// `RS`: reset.
    Reset,
    /// `TM0`: enter time adjust.
    TimeEnter,
    /// `TM1`: read the timer.
    TimeRead,
    /// `TM2`: leave time adjust.
    TimeLeave,
    /// `SS`: bit rate of the serial line.
    BitRate,
    /// `MD`, `MS`, `ME`: scans as they come.
    Stream,
}

impl fmt::Display for ScipCommand {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::SwitchProtocol => "SCIP2.0",
            Self::Version => "VV",
            Self::Parameters => "PP",
            Self::Info => "II",
            Self::Quit => "QT",
            Self::Reset => "RS",
            Self::TimeEnter => "TM0",
            Self::TimeRead => "TM1",
            Self::TimeLeave => "TM2",
            Self::BitRate => "SS",
            Self::Stream => "MD/MS/ME",
        })
    }
}

/// The status of a reply, as on the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StatusCode {
    /// One character without a sum: SCIP 1.1, and the answer to `SCIP2.0`.
    Plain(u8),
    /// Two characters whose sum was right.
    Code([u8; 2]),
}

impl StatusCode {
    /// The status as a decimal number, if it is two digits.
    fn number(self) -> Option<u8> {
        match self {
            Self::Code([high @ b'0'..=b'9', low @ b'0'..=b'9']) => {
                Some((high - b'0') * 10 + (low - b'0'))
            }
            _ => None,
        }
    }

    /// What it means in a reply to `command`.
    pub(crate) fn meaning(self, command: ScipCommand) -> StatusMeaning {
        match self {
            Self::Plain(b'0') => StatusMeaning::Done,
            Self::Plain(_) => StatusMeaning::OldProtocol,
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

/// What a status means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StatusMeaning {
    /// `00`: done.
    Done,
    /// `99` of a stream: a scan follows.
    Data,
    /// Single character other than `0`: the device speaks SCIP 1.1.
    OldProtocol,
    /// The device already is in the state asked for (`TM0` 02, `TM2` 03).
    AlreadySo,
    /// 10 of SCIP 2.2: not in this state (time adjust, streaming, asleep).
    Denied,
    /// `TM1` 04: not in time adjust.
    NotAdjusting,
    /// A parameter is not a number or out of range.
    BadParameter(ParameterError),
    /// 21 to 49 of a stream: stopped to verify an error.
    Verifying(u8),
    /// 98 of a stream: verified as normal, scans go on.
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
    /// `0L`, `0M` of SCIP 2.2: abnormal or unstable.
    Unstable,
    /// A status that the protocol does not define.
    Unknown([u8; 2]),
}

/// The parameter that a status rejects.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are the protocol's")]
pub enum ParameterError {
    StartNotNumeric,
    EndNotNumeric,
    ClusterNotNumeric,
    EndOutOfRange,
    EndBeforeStart,
    IntervalNotNumeric,
    CountNotNumeric,
    ControlCode,
}

fn numbered(command: ScipCommand, number: u8, code: [u8; 2]) -> StatusMeaning {
    use ParameterError as P;
    use ScipCommand as C;
    use StatusMeaning as M;
    match (command, number) {
        (_, 0) => M::Done,
        (C::Stream, 1) => M::BadParameter(P::StartNotNumeric),
        (C::Stream, 2) => M::BadParameter(P::EndNotNumeric),
        (C::Stream, 3) => M::BadParameter(P::ClusterNotNumeric),
        (C::Stream, 4) => M::BadParameter(P::EndOutOfRange),
        (C::Stream, 5) => M::BadParameter(P::EndBeforeStart),
        (C::Stream, 6) => M::BadParameter(P::IntervalNotNumeric),
        (C::Stream, 7) => M::BadParameter(P::CountNotNumeric),
        (C::Stream, 21..=49) => M::Verifying(number),
        (C::Stream, 50..=97) => M::HardwareTrouble(number),
        (C::Stream, 98) => M::Resumed,
        (C::Stream, 99) => M::Data,
        (C::TimeEnter | C::TimeRead | C::TimeLeave, 1) => M::BadParameter(P::ControlCode),
        (C::TimeEnter, 2) | (C::TimeLeave, 3) => M::AlreadySo,
        (C::TimeRead, 4) => M::NotAdjusting,
        (_, 10) => M::Denied,
        _ => M::Unknown(code),
    }
}

fn universal(code: [u8; 2]) -> StatusMeaning {
    match &code {
        b"0A" => StatusMeaning::CannotReply,
        b"0B" => StatusMeaning::Busy,
        b"0C" | b"0F" => StatusMeaning::MissingParameters,
        b"0D" | b"0E" => StatusMeaning::Undefined,
        b"0G" => StatusMeaning::StringTooLong,
        b"0H" => StatusMeaning::StringCharacter,
        b"0I" => StatusMeaning::FirmwareUpdate,
        b"0L" | b"0M" => StatusMeaning::Unstable,
        _ => StatusMeaning::Unknown(code),
    }
}

impl fmt::Display for StatusMeaning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Done => f.write_str("done"),
            Self::Data => f.write_str("scan data"),
            Self::OldProtocol => f.write_str("the sensor speaks SCIP 1.1"),
            Self::AlreadySo => f.write_str("already so"),
            Self::Denied => f.write_str("not possible in the sensor's present state"),
            Self::NotAdjusting => f.write_str("not in time-adjust mode"),
            Self::BadParameter(parameter) => write!(f, "bad parameter ({parameter:?})"),
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

    #[test]
    fn a_status_means_what_its_command_says() {
        let code = |code: &[u8; 2], command| StatusCode::Code(*code).meaning(command);
        assert_eq!(code(b"00", ScipCommand::Quit), StatusMeaning::Done);
        assert_eq!(
            code(b"02", ScipCommand::TimeEnter),
            StatusMeaning::AlreadySo
        );
        assert_eq!(
            code(b"03", ScipCommand::TimeLeave),
            StatusMeaning::AlreadySo
        );
        assert_eq!(
            code(b"04", ScipCommand::TimeRead),
            StatusMeaning::NotAdjusting
        );
        assert_eq!(
            code(b"03", ScipCommand::Stream),
            StatusMeaning::BadParameter(ParameterError::ClusterNotNumeric)
        );
        assert_eq!(
            code(b"0C", ScipCommand::Stream),
            StatusMeaning::MissingParameters
        );
        assert_eq!(
            code(b"0E", ScipCommand::SwitchProtocol),
            StatusMeaning::Undefined
        );
        assert_eq!(code(b"99", ScipCommand::Stream), StatusMeaning::Data);
        assert_eq!(code(b"98", ScipCommand::Stream), StatusMeaning::Resumed);
        let plain = |byte, command| StatusCode::Plain(byte).meaning(command);
        assert_eq!(plain(b'E', ScipCommand::Quit), StatusMeaning::OldProtocol);
        assert_eq!(
            plain(b'0', ScipCommand::SwitchProtocol),
            StatusMeaning::Done
        );
    }

    #[test]
    fn ranges_of_a_stream() {
        let of = |code: &[u8; 2]| StatusCode::Code(*code).meaning(ScipCommand::Stream);
        assert_eq!(of(b"21"), StatusMeaning::Verifying(21));
        assert_eq!(of(b"49"), StatusMeaning::Verifying(49));
        assert_eq!(of(b"50"), StatusMeaning::HardwareTrouble(50));
        assert_eq!(of(b"97"), StatusMeaning::HardwareTrouble(97));
        assert_eq!(of(b"20"), StatusMeaning::Unknown(*b"20"));
    }
}
