//! `RS`: laser off, motor speed and bit rate to default, timer to zero (scip2 section 6).
//!
//! On RS-232C the host must return to the default bit rate afterwards. It does not leave time adjust.

use super::request::ScipRequest;
use crate::error::ReplyError;
use crate::frame::ScipMessage;
use crate::status::ScipCommand;

/// The request `RS`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ResetLaser;

impl ScipRequest for ResetLaser {
    type Reply = ();
    const COMMAND: ScipCommand = ScipCommand::Reset;

    fn line(&self) -> Vec<u8> {
        b"RS".to_vec()
    }

    fn parse(&self, message: &ScipMessage) -> Result<(), ReplyError> {
        self.expect_done(message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn done_or_refused() {
        let parse = |bytes: &[u8]| {
            ResetLaser.parse(&ScipMessage::first_in(bytes, Duration::ZERO).expect("complete"))
        };
        assert_eq!(parse(b"RS\n00P\n\n"), Ok(()));
        assert!(parse(b"RS\n0Ee\n\n").is_err());
    }
}
