//! `HS`: normal or high sensitivity; firmware 3.2.00 and later. Protocol section 6.

use super::Request;
use crate::error::ReplyError;
use crate::frame::Message;
use crate::status::Command;

/// The request `HS`. "Already set" is success.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SetSensitivity {
    /// As made.
    Normal,
    /// Sees 20 % further, with more false echoes.
    High,
}

impl Request for SetSensitivity {
    type Reply = ();
    const COMMAND: Command = Command::Sensitivity;

    fn line(&self) -> Vec<u8> {
        match self {
            Self::Normal => b"HS0".to_vec(),
            Self::High => b"HS1".to_vec(),
        }
    }

    fn parse(&self, message: &Message) -> Result<(), ReplyError> {
        self.expect_done_or_already(message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Instant;
    use crate::status::Meaning;

    #[test]
    fn the_real_reply_of_old_firmware() {
        let message = Message::first_in(b"HS0\n0Cc\n\n", Instant::ZERO).expect("complete");
        let refused = SetSensitivity::Normal
            .parse(&message)
            .expect_err("3.1.04 does not know it");
        assert_eq!(refused.refusal(), Some(Meaning::MissingParameters));
    }
}
