//! `QT`: laser off (scip2 section 6).

use super::request::ScipRequest;
use crate::error::ReplyError;
use crate::frame::ScipMessage;
use crate::status::ScipCommand;

/// The request `QT`. It ends streaming; the scan in flight may come before its reply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Quit;

impl ScipRequest for Quit {
    type Reply = ();
    const COMMAND: ScipCommand = ScipCommand::Quit;

    fn line(&self) -> Vec<u8> {
        b"QT".to_vec()
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
    fn quit_is_answered_by_its_own_echo() {
        let parse = |bytes: &[u8]| {
            Quit.parse(&ScipMessage::first_in(bytes, Duration::ZERO).expect("complete"))
        };
        assert_eq!(parse(b"QT\n00P\n\n"), Ok(()));
        assert!(matches!(
            parse(b"RS\n00P\n\n"),
            Err(ReplyError::Echo { .. })
        ));
    }
}
