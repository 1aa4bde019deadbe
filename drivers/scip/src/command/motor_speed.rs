//! `CR`: motor speed, so that several sensors do not disturb one another. Protocol section 6.

use super::Request;
use crate::error::ReplyError;
use crate::frame::Message;
use crate::status::Command;

/// The request `CR`. "Already at that speed" is success.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SetMotorSpeed {
    /// The speed set as default.
    Default,
    /// 1 to 10: so many percent below nominal. More is asked for as 10.
    Slower(u8),
    /// The speed it was made with.
    Initial,
}

impl Request for SetMotorSpeed {
    type Reply = ();
    const COMMAND: Command = Command::MotorSpeed;

    fn line(&self) -> Vec<u8> {
        let level = match self {
            Self::Default => 0,
            Self::Slower(level) => (*level).clamp(1, 10),
            Self::Initial => 99,
        };
        format!("CR{level:02}").into_bytes()
    }

    fn parse(&self, message: &Message) -> Result<(), ReplyError> {
        self.expect_done_or_already(message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Instant;

    #[test]
    fn the_real_reply_of_a_sensor_at_its_default() {
        let message = Message::first_in(b"CR00\n03S\n\n", Instant::ZERO).expect("complete");
        assert_eq!(SetMotorSpeed::Default.parse(&message), Ok(()));
        assert_eq!(SetMotorSpeed::Slower(10).to_bytes(), b"CR10\n");
        assert_eq!(SetMotorSpeed::Initial.to_bytes(), b"CR99\n");
    }
}
