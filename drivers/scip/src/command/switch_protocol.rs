//! `SCIP2.0`: leaves SCIP 1.1, in which a URG-04LX wakes up. Protocol sections 3, 6 and 9.
//!
//! ```text
//! SCIP2.0\n  ->  SCIP2.0\n0\n\n      switched (one character, no sum)
//!                SCIP2.0\n0Ee\n\n    there is no such command, for the device speaks 2.0 already
//! ```

use super::Request;
use crate::error::ReplyError;
use crate::frame::Message;
use crate::status::{Command, Meaning};

/// The request `SCIP2.0`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SwitchProtocol;

impl Request for SwitchProtocol {
    type Reply = ();
    const COMMAND: Command = Command::SwitchProtocol;

    fn line(&self) -> Vec<u8> {
        b"SCIP2.0".to_vec()
    }

    /// Both answers mean that SCIP 2.0 is spoken from now on.
    fn parse(&self, message: &Message) -> Result<(), ReplyError> {
        match self.status(message)? {
            Meaning::Done | Meaning::Undefined => Ok(()),
            meaning => Err(ReplyError::Refused {
                command: Self::COMMAND,
                meaning,
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Instant;

    #[test]
    fn both_answers_are_success() {
        for reply in [
            &b"SCIP2.0\n0\n\n"[..],
            b"SCIP2.0\n0Ee\n\n",
            b"SCIP2.0\n00P\n\n",
        ] {
            let message = Message::first_in(reply, Instant::ZERO).expect("complete");
            assert_eq!(SwitchProtocol.parse(&message), Ok(()));
        }
        let message = Message::first_in(b"SCIP2.0\nE\n\n", Instant::ZERO).expect("complete");
        assert!(SwitchProtocol.parse(&message).is_err());
    }
}
