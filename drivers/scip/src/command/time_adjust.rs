//! `TM0`, `TM1`, `TM2`: enter time adjust, read the timer, leave (scip2 sections 5, 6 and 8).
//!
//! Entering turns the laser off. In this mode every other command gets `0E`; only `TM2` leaves it.

use super::request::ScipRequest;
use super::scan_data::read_stamp;
use crate::error::ReplyError;
use crate::frame::ScipMessage;
use crate::status::{ScipCommand, StatusMeaning};

/// The request `TM0`. "Already in the mode" is success.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct EnterTimeAdjust;

impl ScipRequest for EnterTimeAdjust {
    type Reply = ();
    const COMMAND: ScipCommand = ScipCommand::TimeEnter;

    fn line(&self) -> Vec<u8> {
        b"TM0".to_vec()
    }

    fn parse(&self, message: &ScipMessage) -> Result<(), ReplyError> {
        self.expect_done_or_already(message)
    }
}

/// The request `TM1`; its reply is the timer, ms, 24 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ReadTimer;

impl ScipRequest for ReadTimer {
    type Reply = u32;
    const COMMAND: ScipCommand = ScipCommand::TimeRead;

    fn line(&self) -> Vec<u8> {
        b"TM1".to_vec()
    }

    fn parse(&self, message: &ScipMessage) -> Result<u32, ReplyError> {
        match self.status(message)? {
            StatusMeaning::Done => read_stamp(message.body().next().unwrap_or_default()),
            meaning => Err(ReplyError::Refused {
                command: Self::COMMAND,
                meaning,
            }),
        }
    }
}

/// The request `TM2`. "Not in the mode" is success.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct LeaveTimeAdjust;

impl ScipRequest for LeaveTimeAdjust {
    type Reply = ();
    const COMMAND: ScipCommand = ScipCommand::TimeLeave;

    fn line(&self) -> Vec<u8> {
        b"TM2".to_vec()
    }

    fn parse(&self, message: &ScipMessage) -> Result<(), ReplyError> {
        self.expect_done_or_already(message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encoding::decode;
    use std::time::Duration;

    fn message(bytes: &[u8]) -> ScipMessage {
        ScipMessage::first_in(bytes, Duration::ZERO).expect("complete")
    }

    #[test]
    fn parses_the_recorded_exchange() {
        assert_eq!(EnterTimeAdjust.parse(&message(b"TM0\n00P\n\n")), Ok(()));
        assert_eq!(
            ReadTimer.parse(&message(b"TM1\n00P\n<SfkP\n\n")),
            Ok(decode(b"<Sfk").expect("valid"))
        );
        assert_eq!(LeaveTimeAdjust.parse(&message(b"TM2\n00P\n\n")), Ok(()));
    }

    #[test]
    fn already_in_and_already_out() {
        assert_eq!(EnterTimeAdjust.parse(&message(b"TM0\n02R\n\n")), Ok(()));
        assert_eq!(LeaveTimeAdjust.parse(&message(b"TM2\n03S\n\n")), Ok(()));
        let outside = ReadTimer
            .parse(&message(b"TM1\n04T\n\n"))
            .expect_err("04 is outside the mode");
        assert_eq!(outside.refusal(), Some(StatusMeaning::NotAdjusting));
    }

    #[test]
    fn damaged_times_are_no_times() {
        assert!(matches!(
            ReadTimer.parse(&message(b"TM1\n00P\n<SfjP\n\n")),
            Err(ReplyError::Sum { .. })
        ));
        assert!(matches!(
            ReadTimer.parse(&message(b"TM1\n00P\n\n")),
            Err(ReplyError::Length { .. })
        ));
    }
}
