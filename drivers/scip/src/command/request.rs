//! What every request has in common.

use crate::constants::LF;
use crate::error::ReplyError;
use crate::frame::ScipMessage;
use crate::status::{ScipCommand, StatusMeaning};

/// A request to the device.
pub trait ScipRequest {
    /// The content of a good reply.
    type Reply;
    /// For the meaning of statuses, and for errors.
    const COMMAND: ScipCommand;

    /// The request's line without its LF. The reply's first line echoes it.
    fn line(&self) -> Vec<u8>;

    /// Reads the reply and checks its sums.
    ///
    /// # Errors
    /// [`ReplyError::Echo`] if the message answers another request, [`ReplyError::Refused`] for an error status, others
    /// for damage.
    fn parse(&self, message: &ScipMessage) -> Result<Self::Reply, ReplyError>;

    /// The bytes to send.
    fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = self.line();
        bytes.push(LF);
        bytes
    }

    /// Whether the message echoes this request.
    fn is_answered_by(&self, message: &ScipMessage) -> bool {
        message.echo() == self.line()
    }

    /// Checks the echo and returns what the status means.
    ///
    /// # Errors
    /// [`ReplyError::Echo`] for another request's reply, others for a damaged status line.
    fn status(&self, message: &ScipMessage) -> Result<StatusMeaning, ReplyError> {
        if !self.is_answered_by(message) {
            return Err(ReplyError::Echo {
                expected: self.line().as_slice().into(),
                got: message.echo().into(),
            });
        }
        Ok(message.status()?.meaning(Self::COMMAND))
    }

    /// Checks the echo, and that the status is `00`.
    ///
    /// # Errors
    /// As [`ScipRequest::status`], and [`ReplyError::Refused`] for any other status.
    fn expect_done(&self, message: &ScipMessage) -> Result<(), ReplyError> {
        match self.status(message)? {
            StatusMeaning::Done => Ok(()),
            meaning => Err(ReplyError::Refused {
                command: Self::COMMAND,
                meaning,
            }),
        }
    }

    /// Checks the echo, and that the device is in the requested state, whether it already was or not.
    ///
    /// # Errors
    /// As [`ScipRequest::status`], and [`ReplyError::Refused`] for any other status.
    fn expect_done_or_already(&self, message: &ScipMessage) -> Result<(), ReplyError> {
        match self.status(message)? {
            StatusMeaning::Done | StatusMeaning::AlreadySo => Ok(()),
            meaning => Err(ReplyError::Refused {
                command: Self::COMMAND,
                meaning,
            }),
        }
    }
}
