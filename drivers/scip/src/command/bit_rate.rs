//! `SS`: bit rate of the RS-232C. Protocol section 6.
//!
//! The reply comes at the old rate; the change follows it, and the host should wait some 150 ms before it talks at the
//! new one. Over USB it is accepted and acts when the link becomes RS-232C.

use super::Request;
use crate::error::ReplyError;
use crate::frame::Message;
use crate::status::Command;

/// Rates a URG-04LX knows, bits per second (protocol section 2).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are the rates")]
pub enum BitRate {
    B19200,
    B57600,
    B115200,
    B250000,
    B500000,
    B750000,
}

impl BitRate {
    /// Bits per second.
    #[must_use]
    pub fn bits_per_second(self) -> u32 {
        match self {
            Self::B19200 => 19_200,
            Self::B57600 => 57_600,
            Self::B115200 => 115_200,
            Self::B250000 => 250_000,
            Self::B500000 => 500_000,
            Self::B750000 => 750_000,
        }
    }
}

/// The request `SS`. "Already at that rate" is success.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SetBitRate(pub BitRate);

impl Request for SetBitRate {
    type Reply = ();
    const COMMAND: Command = Command::BitRate;

    fn line(&self) -> Vec<u8> {
        format!("SS{:06}", self.0.bits_per_second()).into_bytes()
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
    fn the_rate_has_six_digits() {
        assert_eq!(SetBitRate(BitRate::B115200).to_bytes(), b"SS115200\n");
        assert_eq!(SetBitRate(BitRate::B19200).to_bytes(), b"SS019200\n");
    }

    #[test]
    fn its_statuses() {
        let parse = |bytes: &[u8]| {
            SetBitRate(BitRate::B115200)
                .parse(&Message::first_in(bytes, Instant::ZERO).expect("complete"))
        };
        assert_eq!(parse(b"SS115200\n00P\n\n"), Ok(()));
        assert_eq!(parse(b"SS115200\n03S\n\n"), Ok(()));
        let refused = parse(b"SS115200\n04T\n\n").expect_err("04 is not supported");
        assert_eq!(refused.refusal(), Some(Meaning::NotSupported));
    }
}
