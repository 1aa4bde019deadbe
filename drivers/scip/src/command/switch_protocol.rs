//! `SCIP2.0`: leaves SCIP 1.1, in which a URG-04LX starts up (scip2 sections 3, 6 and 9).
//!
//! ```text
//! SCIP2.0\n  ->  SCIP2.0\n0\n\n      switched (one character, no sum)
//!                SCIP2.0\n0Ee\n\n    undefined command: the device is in SCIP 2.0 already
//! ```

use super::request::ScipRequest;
use crate::error::ReplyError;
use crate::frame::ScipMessage;
use crate::status::{ScipCommand, StatusMeaning};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct SwitchProtocol;

impl ScipRequest for SwitchProtocol {
    type Reply = ();
    const COMMAND: ScipCommand = ScipCommand::SwitchProtocol;

    fn line(&self) -> Vec<u8> {
        b"SCIP2.0".to_vec()
    }

    /// After either answer the device is in SCIP 2.0.
    fn parse(&self, message: &ScipMessage) -> Result<(), ReplyError> {
        match self.status(message)? {
            StatusMeaning::Done | StatusMeaning::Undefined => Ok(()),
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
    use std::time::Duration;

    #[test]
    fn both_answers_are_success() {
        for reply in [
            &b"SCIP2.0\n0\n\n"[..],
            b"SCIP2.0\n0Ee\n\n",
            b"SCIP2.0\n00P\n\n",
        ] {
            let message = ScipMessage::first_in(reply, Duration::ZERO).expect("complete");
            assert_eq!(SwitchProtocol.parse(&message), Ok(()));
        }
        let message = ScipMessage::first_in(b"SCIP2.0\nE\n\n", Duration::ZERO).expect("complete");
        assert!(SwitchProtocol.parse(&message).is_err());
    }
}
