//! `MD`, `MS` and `ME`: scans as they come. Protocol section 6.
//!
//! ```text
//! MD 0044 0725 01 0 00 \n  ->  exact echo, 00P                                acknowledged
//!                              echo with scans remaining, 99b, stamp, data    one per scan
//!                              echo, 21..49 / 98 / 50..97                     unsolicited
//! ```

use super::Request;
use super::single::scan;
use super::span::Span;
use crate::constants::MAX_INTERVAL;
use crate::error::{ReplyError, SensorError};
use crate::frame::Message;
use crate::scan::RawScan;
use crate::status::{Command, Meaning};

/// The request `MD`, `MS` or `ME`, by the span's coding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stream {
    /// Steps, cluster, coding.
    pub span: Span,
    /// Scans left out between two that are sent, 0 to 9.
    pub interval: u8,
    /// Scans wanted, 1 to 99; 0: until `QT`.
    pub count: u8,
}

/// One message of a stream.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StreamReply {
    /// `00`: the request is taken.
    Acknowledged,
    /// `99`: a scan, every sum right.
    Scan(RawScan),
    /// 21 to 49: scans stop while the device verifies an error.
    Verifying(u8),
    /// 98: the laser proved normal, scans go on.
    Resumed,
    /// 50 to 97: hardware trouble.
    Trouble(u8),
}

impl Stream {
    /// Checks that the fields fit their digits.
    ///
    /// # Errors
    /// [`SensorError::Plan`] naming the field.
    pub fn checked(self) -> Result<Self, SensorError> {
        self.span.checked()?;
        if self.interval > MAX_INTERVAL {
            return Err(SensorError::Plan {
                what: "interval",
                expected: "at most 9",
                got: self.interval.into(),
            });
        }
        if self.count > 99 {
            return Err(SensorError::Plan {
                what: "count",
                expected: "at most 99",
                got: self.count.into(),
            });
        }
        Ok(self)
    }

    /// All of the line but the two digits of the count.
    fn head(&self) -> String {
        format!(
            "M{}{}{}",
            self.span.coding.letter(),
            self.span.digits(),
            self.interval
        )
    }

    /// The count field of the echo, if the echo is this request's in all else.
    fn remaining(&self, message: &Message) -> Option<u8> {
        match message.echo().strip_prefix(self.head().as_bytes())? {
            [high @ b'0'..=b'9', low @ b'0'..=b'9'] => Some((high - b'0') * 10 + (low - b'0')),
            _ => None,
        }
    }
}

impl Request for Stream {
    type Reply = StreamReply;
    const COMMAND: Command = Command::Stream;

    fn line(&self) -> Vec<u8> {
        format!("{}{:02}", self.head(), self.count).into_bytes()
    }

    fn is_answered_by(&self, message: &Message) -> bool {
        self.remaining(message).is_some()
    }

    fn parse(&self, message: &Message) -> Result<StreamReply, ReplyError> {
        let meaning = self.status(message)?;
        let remaining = self.remaining(message).unwrap_or_default();
        match meaning {
            Meaning::Done if remaining == self.count => Ok(StreamReply::Acknowledged),
            Meaning::Done => Err(ReplyError::Remaining {
                expected: self.count,
                got: remaining,
            }),
            Meaning::Data if remaining <= self.count.saturating_sub(1) => {
                scan(message, &self.span, remaining).map(StreamReply::Scan)
            }
            Meaning::Data => Err(ReplyError::Remaining {
                expected: self.count.saturating_sub(1),
                got: remaining,
            }),
            Meaning::Verifying(number) => Ok(StreamReply::Verifying(number)),
            Meaning::Resumed => Ok(StreamReply::Resumed),
            Meaning::HardwareTrouble(number) => Ok(StreamReply::Trouble(number)),
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
    use crate::scan::Coding;

    const PAIR: Stream = Stream {
        span: Span {
            first_step: 44,
            last_step: 45,
            cluster: 1,
            coding: Coding::ThreeCharacter,
        },
        interval: 0,
        count: 0,
    };

    fn parse(stream: Stream, text: &str) -> Result<StreamReply, ReplyError> {
        stream.parse(&Message::first_in(text.as_bytes(), Instant::ZERO).expect("complete"))
    }

    #[test]
    fn the_request_is_fifteen_characters() {
        let full = Span {
            last_step: 725,
            ..PAIR.span
        };
        assert_eq!(
            Stream { span: full, ..PAIR }.to_bytes(),
            b"MD0044072501000\n"
        );
        assert_eq!(
            Stream {
                span: full,
                interval: 3,
                count: 99
            }
            .to_bytes(),
            b"MD0044072501399\n"
        );
        let two = Span {
            coding: Coding::TwoCharacter,
            ..full
        };
        assert_eq!(
            Stream { span: two, ..PAIR }.to_bytes(),
            b"MS0044072501000\n"
        );
    }

    #[test]
    fn acknowledgement_scan_and_unsolicited_statuses() {
        assert_eq!(
            parse(PAIR, "MD0044004501000\n00P\n\n"),
            Ok(StreamReply::Acknowledged)
        );
        let Ok(StreamReply::Scan(scan)) = parse(PAIR, "MD0044004501000\n99b\nJUGnD\n1Dh06E8\n\n")
        else {
            panic!("a scan");
        };
        assert_eq!((scan.ranges, scan.stamp_ms), (vec![5432, 405], 6_968_830));
        assert_eq!(
            parse(PAIR, "MD0044004501000\n98a\n\n"),
            Ok(StreamReply::Resumed)
        );
        assert_eq!(
            parse(PAIR, "MD0044004501000\n21S\n\n"),
            Ok(StreamReply::Verifying(21))
        );
        assert_eq!(
            parse(PAIR, "MD0044004501000\n50U\n\n"),
            Ok(StreamReply::Trouble(50))
        );
        assert!(
            parse(PAIR, "MD0044004501000\n04T\n\n").is_err_and(|error| error.refusal().is_some())
        );
    }

    #[test]
    fn the_count_field_tells_the_scans_remaining() {
        let ten = Stream { count: 10, ..PAIR };
        let Ok(StreamReply::Scan(scan)) = parse(ten, "MD0044004501009\n99b\nJUGnD\n1Dh06E8\n\n")
        else {
            panic!("a scan");
        };
        assert_eq!(scan.remaining, 9);
        for text in [
            "MD0044004501010\n99b\nJUGnD\n1Dh06E8\n\n",
            "MD0044004501009\n00P\n\n",
        ] {
            assert!(matches!(
                parse(ten, text),
                Err(ReplyError::Remaining { .. })
            ));
        }
        let endless = parse(PAIR, "MD0044004501001\n99b\nJUGnD\n1Dh06E8\n\n");
        assert!(matches!(
            endless,
            Err(ReplyError::Remaining {
                expected: 0,
                got: 1
            })
        ));
    }

    #[test]
    fn scans_of_another_request_are_not_ours() {
        for text in [
            "MD0044004601000\n99b\n\n",
            "MD00440045010000\n99b\n\n",
            "MD004400450100x\n99b\n\n",
            "QT\n00P\n\n",
        ] {
            assert!(matches!(parse(PAIR, text), Err(ReplyError::Echo { .. })));
        }
    }
}
