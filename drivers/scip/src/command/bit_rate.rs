//! `SS`: the bit rate of the serial line (scip2 section 6). The reply comes at the old rate; the change follows it.

use super::request::ScipRequest;
use crate::error::ReplyError;
use crate::frame::ScipMessage;
use crate::status::ScipCommand;

/// The request `SS` with its rate, bit/s.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct SetBitRate(pub(crate) u32);

impl ScipRequest for SetBitRate {
    type Reply = ();
    const COMMAND: ScipCommand = ScipCommand::BitRate;

    fn line(&self) -> Vec<u8> {
        format!("SS{:06}", self.0).into_bytes()
    }

    fn parse(&self, message: &ScipMessage) -> Result<(), ReplyError> {
        self.expect_done(message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::status::StatusMeaning;
    use std::time::Duration;

    #[test]
    fn the_rate_has_six_digits_and_every_status_but_00_is_a_refusal() {
        let request = SetBitRate(57_600);
        assert_eq!(request.to_bytes(), b"SS057600\n");
        let parse = |status: &str| {
            let text = format!("SS057600\n{status}\n\n");
            let message = ScipMessage::first_in(text.as_bytes(), Duration::ZERO);
            request.parse(&message.expect("complete"))
        };
        assert_eq!(parse("00P"), Ok(()));
        for status in ["01Q", "02R", "03S", "04T", "0Ee"] {
            let refused = parse(status).expect_err(status).refusal();
            assert!(refused.is_some_and(|meaning| meaning != StatusMeaning::Done));
        }
    }
}
