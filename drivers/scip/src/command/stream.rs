//! `MD`, `MS` and `ME`: continuous scans (scip2 section 6).
//!
//! ```text
//! MD 0044 0725 01 0 00 \n  ->  exact echo, 00P                                acknowledged
//!                              echo with scans remaining, 99b, stamp, data    one per scan
//!                              echo, 21..49 / 98 / 50..97                     unsolicited
//! ```

use super::request::ScipRequest;
use super::scan_data::read_scan;
use super::span::ScanSpan;
use crate::error::ReplyError;
use crate::frame::ScipMessage;
use crate::scan::LaserScan;
use crate::status::{ScipCommand, StatusMeaning};

/// The request `MD`, `MS` or `ME`, depending on the coding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StreamRequest {
    /// Steps, cluster, coding.
    pub span: ScanSpan,
    /// Scans skipped between two that are sent, 0 to 9.
    pub interval: u8,
    /// Number of scans, 1 to 99; 0: until `QT`.
    pub count: u8,
}

/// One message of a stream.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StreamReply {
    /// `00`: the request is accepted.
    Acknowledged,
    /// `99`.
    Scan(LaserScan),
    /// 21 to 49: scans stop while the device verifies an error.
    Verifying(u8),
    /// 98: verified as normal, scans go on.
    Resumed,
    /// 50 to 97: hardware trouble.
    Trouble(u8),
}

impl StreamRequest {
    /// The line without the two digits of the count.
    fn head(&self) -> String {
        format!(
            "M{}{}{}",
            self.span.coding.letter(),
            self.span.digits(),
            self.interval
        )
    }

    /// The count field of the echo, if the echo matches this request in all else.
    fn remaining(&self, message: &ScipMessage) -> Option<u8> {
        match message.echo().strip_prefix(self.head().as_bytes())? {
            [high @ b'0'..=b'9', low @ b'0'..=b'9'] => Some((high - b'0') * 10 + (low - b'0')),
            _ => None,
        }
    }
}

impl ScipRequest for StreamRequest {
    type Reply = StreamReply;
    const COMMAND: ScipCommand = ScipCommand::Stream;

    fn line(&self) -> Vec<u8> {
        format!("{}{:02}", self.head(), self.count).into_bytes()
    }

    fn is_answered_by(&self, message: &ScipMessage) -> bool {
        self.remaining(message).is_some()
    }

    fn parse(&self, message: &ScipMessage) -> Result<StreamReply, ReplyError> {
        let meaning = self.status(message)?;
        let remaining = self.remaining(message).unwrap_or_default();
        match meaning {
            StatusMeaning::Done if remaining == self.count => Ok(StreamReply::Acknowledged),
            StatusMeaning::Done => Err(ReplyError::Remaining {
                expected: self.count,
                got: remaining,
            }),
            StatusMeaning::Data if remaining <= self.count.saturating_sub(1) => {
                read_scan(message, &self.span, remaining).map(StreamReply::Scan)
            }
            StatusMeaning::Data => Err(ReplyError::Remaining {
                expected: self.count.saturating_sub(1),
                got: remaining,
            }),
            StatusMeaning::Verifying(number) => Ok(StreamReply::Verifying(number)),
            StatusMeaning::Resumed => Ok(StreamReply::Resumed),
            StatusMeaning::HardwareTrouble(number) => Ok(StreamReply::Trouble(number)),
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
    use crate::encoding::sum;
    use crate::scan::ValueCoding;
    use std::time::Duration;

    const PAIR: StreamRequest = StreamRequest {
        span: ScanSpan {
            first_step: 44,
            last_step: 45,
            cluster: 1,
            coding: ValueCoding::ThreeCharacter,
        },
        interval: 0,
        count: 0,
    };

    fn parse(stream: StreamRequest, text: &str) -> Result<StreamReply, ReplyError> {
        stream.parse(&ScipMessage::first_in(text.as_bytes(), Duration::ZERO).expect("complete"))
    }

    #[test]
    fn the_request_is_fifteen_characters() {
        let full = ScanSpan {
            last_step: 725,
            ..PAIR.span
        };
        assert_eq!(
            StreamRequest { span: full, ..PAIR }.to_bytes(),
            b"MD0044072501000\n"
        );
        assert_eq!(
            StreamRequest {
                span: full,
                interval: 3,
                count: 99
            }
            .to_bytes(),
            b"MD0044072501399\n"
        );
        let two = ScanSpan {
            coding: ValueCoding::TwoCharacter,
            ..full
        };
        assert_eq!(
            StreamRequest { span: two, ..PAIR }.to_bytes(),
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
    fn the_count_field_is_the_number_of_scans_remaining() {
        let ten = StreamRequest { count: 10, ..PAIR };
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

    const FOUR: ScanSpan = ScanSpan {
        last_step: 47,
        ..PAIR.span
    };

    /// The scan of a reply with these data, of a stream of this span.
    fn scan(span: ScanSpan, data: &str) -> Result<LaserScan, ReplyError> {
        let stream = StreamRequest { span, ..PAIR };
        let echo = String::from_utf8(stream.line()).expect("ASCII");
        let sum = char::from(sum(data.as_bytes()));
        match parse(stream, &format!("{echo}\n99b\nJUGnD\n{data}{sum}\n\n"))? {
            StreamReply::Scan(scan) => Ok(scan),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn both_codings() {
        let three = scan(FOUR, "1Dh00000706E").expect("four values");
        assert_eq!(three.ranges, [5432, 0, 7, 405]);
        assert_eq!(
            (three.stamp_ms, three.first_step, three.cluster),
            (6_968_830, 44, 1)
        );
        let two = ScanSpan {
            coding: ValueCoding::TwoCharacter,
            ..FOUR
        };
        assert_eq!(
            scan(two, "CB00oo07").expect("four values").ranges,
            [1234, 0, 4095, 7]
        );
    }

    /// 1000 mm is `0?X`.
    #[test]
    fn distance_and_intensity() {
        let span = ScanSpan {
            coding: ValueCoding::WithIntensity,
            ..PAIR.span
        };
        assert_eq!(
            StreamRequest { span, ..PAIR }.to_bytes(),
            b"ME0044004501000\n"
        );
        let pairs = scan(span, "0?X0nP007000").expect("two pairs");
        assert_eq!(
            (pairs.ranges, pairs.intensities),
            (vec![1000, 7], vec![4000, 0])
        );
        assert!(matches!(
            scan(span, "0?X0nP007"),
            Err(ReplyError::Length { .. })
        ));
    }

    #[test]
    fn the_value_count_is_the_requested_one() {
        for data in ["1Dh000007", "1Dh00000706E06E"] {
            let error = scan(FOUR, data).expect_err("three or five values");
            assert!(matches!(error, ReplyError::ValueCount { .. }));
        }
    }

    #[test]
    fn a_partial_last_group_may_be_there_or_not() {
        let clustered = ScanSpan { cluster: 3, ..FOUR };
        for (data, values) in [("1Dh", 1), ("1Dh06E", 2)] {
            assert_eq!(
                scan(clustered, data)
                    .expect("floor or ceiling")
                    .ranges
                    .len(),
                values
            );
        }
    }
}
