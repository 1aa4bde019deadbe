//! What every request has.

use crate::constants::LF;
use crate::error::ReplyError;
use crate::frame::Message;
use crate::status::{Command, Meaning};

/// A request: its bytes out, its reply in.
pub trait Request {
    /// What the reply holds.
    type Reply;
    /// Which command it is, for statuses and errors.
    const COMMAND: Command;

    /// The request's line without its LF. The reply's first line echoes it.
    fn line(&self) -> Vec<u8>;

    /// Reads the reply, sums and all.
    ///
    /// # Errors
    /// [`ReplyError::Echo`] if the message answers another request, [`ReplyError::Refused`] for an error status, others
    /// for damage.
    fn parse(&self, message: &Message) -> Result<Self::Reply, ReplyError>;

    /// The bytes to send.
    fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = self.line();
        bytes.push(LF);
        bytes
    }

    /// Whether the message echoes this request.
    fn is_answered_by(&self, message: &Message) -> bool {
        message.echo() == self.line()
    }

    /// Checks the echo and gives what the status means.
    ///
    /// # Errors
    /// [`ReplyError::Echo`] for another request's reply, others for a damaged status line.
    fn status(&self, message: &Message) -> Result<Meaning, ReplyError> {
        if !self.is_answered_by(message) {
            return Err(ReplyError::Echo {
                expected: self.line().as_slice().into(),
                got: message.echo().into(),
            });
        }
        Ok(message.status()?.meaning(Self::COMMAND))
    }

    /// Checks the echo, and that the status says done.
    ///
    /// # Errors
    /// As [`Request::status`], and [`ReplyError::Refused`] for any other status.
    fn expect_done(&self, message: &Message) -> Result<(), ReplyError> {
        match self.status(message)? {
            Meaning::Done => Ok(()),
            meaning => Err(ReplyError::Refused {
                command: Self::COMMAND,
                meaning,
            }),
        }
    }

    /// Checks the echo, and that the device is in the state asked for, now or before.
    ///
    /// # Errors
    /// As [`Request::status`], and [`ReplyError::Refused`] for any other status.
    fn expect_done_or_already(&self, message: &Message) -> Result<(), ReplyError> {
        match self.status(message)? {
            Meaning::Done | Meaning::AlreadySo => Ok(()),
            meaning => Err(ReplyError::Refused {
                command: Self::COMMAND,
                meaning,
            }),
        }
    }
}
