//! The settings that can be made at idle. Protocol section 6.

use super::Request;
use super::bit_rate::SetBitRate;
use super::motor_speed::SetMotorSpeed;
use super::rehearsal::Rehearse;
use super::reset::SoftReset;
use super::sensitivity::SetSensitivity;
use crate::error::ReplyError;
use crate::frame::Message;
use crate::status::Command;

/// One setting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Setting {
    /// `CR`.
    MotorSpeed(SetMotorSpeed),
    /// `HS`.
    Sensitivity(SetSensitivity),
    /// `SS`: on RS-232C the caller changes the line's rate once it is applied, and waits some 150 ms.
    BitRate(SetBitRate),
    /// `DB`.
    Rehearsal(Rehearse),
    /// `RT`: laser off and timer to zero, motor and bit rate kept.
    SoftReset,
}

impl Setting {
    /// Which command makes it.
    #[must_use]
    pub fn command(&self) -> Command {
        match self {
            Self::MotorSpeed(_) => SetMotorSpeed::COMMAND,
            Self::Sensitivity(_) => SetSensitivity::COMMAND,
            Self::BitRate(_) => SetBitRate::COMMAND,
            Self::Rehearsal(_) => Rehearse::COMMAND,
            Self::SoftReset => SoftReset::COMMAND,
        }
    }

    /// The request's bytes.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        match self {
            Self::MotorSpeed(request) => request.to_bytes(),
            Self::Sensitivity(request) => request.to_bytes(),
            Self::BitRate(request) => request.to_bytes(),
            Self::Rehearsal(request) => request.to_bytes(),
            Self::SoftReset => SoftReset.to_bytes(),
        }
    }

    /// Reads the reply.
    ///
    /// # Errors
    /// As [`Request::parse`].
    pub fn parse(&self, message: &Message) -> Result<(), ReplyError> {
        match self {
            Self::MotorSpeed(request) => request.parse(message),
            Self::Sensitivity(request) => request.parse(message),
            Self::BitRate(request) => request.parse(message),
            Self::Rehearsal(request) => request.parse(message),
            Self::SoftReset => SoftReset.parse(message),
        }
    }
}
