//! `RS`: laser off, motor speed and bit rate to default, timer to zero; `RT` of UTM and UST: motor and bit rate stay.
//! Protocol section 6.
//!
//! On RS-232C the host must return to the default bit rate afterwards. It does not leave time adjust.

use super::Request;
use crate::error::ReplyError;
use crate::frame::Message;
use crate::status::Command;

/// The request `RS`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reset;

impl Request for Reset {
    type Reply = ();
    const COMMAND: Command = Command::Reset;

    fn line(&self) -> Vec<u8> {
        b"RS".to_vec()
    }

    fn parse(&self, message: &Message) -> Result<(), ReplyError> {
        self.expect_done(message)
    }
}

/// The request `RT`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SoftReset;

impl Request for SoftReset {
    type Reply = ();
    const COMMAND: Command = Command::SoftReset;

    fn line(&self) -> Vec<u8> {
        b"RT".to_vec()
    }

    fn parse(&self, message: &Message) -> Result<(), ReplyError> {
        self.expect_done(message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Instant;

    #[test]
    fn done_or_refused() {
        let parse =
            |bytes: &[u8]| Reset.parse(&Message::first_in(bytes, Instant::ZERO).expect("complete"));
        assert_eq!(parse(b"RS\n00P\n\n"), Ok(()));
        assert!(parse(b"RS\n0Ee\n\n").is_err());
        let soft = Message::first_in(b"RT\n00P\n\n", Instant::ZERO).expect("complete");
        assert_eq!(SoftReset.parse(&soft), Ok(()));
    }
}
