//! `BM` and `QT`: laser on, laser off. Protocol section 6.

use super::Request;
use crate::error::ReplyError;
use crate::frame::Message;
use crate::status::Command;

/// The request `BM`: laser on, for single scans. "Already on" is success.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LaserOn;

impl Request for LaserOn {
    type Reply = ();
    const COMMAND: Command = Command::LaserOn;

    fn line(&self) -> Vec<u8> {
        b"BM".to_vec()
    }

    fn parse(&self, message: &Message) -> Result<(), ReplyError> {
        self.expect_done_or_already(message)
    }
}

/// The request `QT`: laser off, streaming ends. The scan in flight may come before its reply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Quit;

impl Request for Quit {
    type Reply = ();
    const COMMAND: Command = Command::Quit;

    fn line(&self) -> Vec<u8> {
        b"QT".to_vec()
    }

    fn parse(&self, message: &Message) -> Result<(), ReplyError> {
        self.expect_done(message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Instant;
    use crate::status::Meaning;

    #[test]
    fn on_already_on_and_broken() {
        let parse = |bytes: &[u8]| {
            LaserOn.parse(&Message::first_in(bytes, Instant::ZERO).expect("complete"))
        };
        assert_eq!(parse(b"BM\n00P\n\n"), Ok(()));
        assert_eq!(parse(b"BM\n02R\n\n"), Ok(()));
        let broken = parse(b"BM\n01Q\n\n").expect_err("01 is a malfunction");
        assert_eq!(broken.refusal(), Some(Meaning::LaserMalfunction));
        assert!(matches!(
            parse(b"QT\n00P\n\n"),
            Err(ReplyError::Echo { .. })
        ));
    }

    #[test]
    fn quit_is_answered_by_its_own_echo() {
        let message = Message::first_in(b"QT\n00P\n\n", Instant::ZERO).expect("complete");
        assert_eq!(Quit.parse(&message), Ok(()));
    }
}
