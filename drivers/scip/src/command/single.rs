//! `GD`, `GS` and `GE`: the latest complete scan, once; the laser must be on. Protocol section 6.
//!
//! ```text
//! GD 0044 0725 01 \n   ->  echo, 00P, stamp + sum, data lines, empty line
//! ```

use super::span::Span;
use super::{Request, blocks};
use crate::error::ReplyError;
use crate::frame::Message;
use crate::scan::{Coding, RawScan};
use crate::status::{Command, Meaning};

/// The request `GD`, `GS` or `GE`, by the span's coding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MeasureOnce(pub Span);

/// Reads stamp and values of a scan reply whose status has been checked.
pub(super) fn scan(message: &Message, span: &Span, remaining: u8) -> Result<RawScan, ReplyError> {
    let mut lines = message.body();
    let stamp_ms = blocks::stamp(lines.next().unwrap_or_default())?;
    let (least, most) = span.value_counts();
    let (ranges, intensities) = if span.coding == Coding::WithIntensity {
        let values = blocks::values(lines, Coding::ThreeCharacter.width(), 2 * most)?;
        let pairs = values.chunks_exact(2);
        if !pairs.remainder().is_empty() {
            return Err(ReplyError::Length {
                what: "last pair of distance and intensity",
                expected: 2,
                got: 1,
            });
        }
        pairs
            .filter_map(|pair| Some((*pair.first()?, *pair.last()?)))
            .unzip()
    } else {
        let ranges = blocks::values(lines, span.coding.width(), most)?;
        (ranges, Vec::new())
    };
    if ranges.len() < least {
        return Err(ReplyError::ValueCount {
            expected: least,
            got: ranges.len(),
        });
    }
    Ok(RawScan {
        first_step: span.first_step,
        cluster: span.cluster.max(1),
        coding: span.coding,
        ranges,
        intensities,
        stamp_ms,
        remaining,
    })
}

impl Request for MeasureOnce {
    type Reply = RawScan;
    const COMMAND: Command = Command::Single;

    fn line(&self) -> Vec<u8> {
        format!("G{}{}", self.0.coding.letter(), self.0.digits()).into_bytes()
    }

    fn parse(&self, message: &Message) -> Result<RawScan, ReplyError> {
        match self.status(message)? {
            Meaning::Done => scan(message, &self.0, 0),
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
    use crate::encoding::sum;

    const FOUR: Span = Span {
        first_step: 44,
        last_step: 47,
        cluster: 1,
        coding: Coding::ThreeCharacter,
    };

    fn reply(echo: &str, data: &str) -> Message {
        let text = format!(
            "{echo}\n00P\nJUGnD\n{data}{}\n\n",
            char::from(sum(data.as_bytes()))
        );
        Message::first_in(text.as_bytes(), Instant::ZERO).expect("complete")
    }

    #[test]
    fn the_request_is_twelve_characters() {
        let full = Span {
            first_step: 44,
            last_step: 725,
            ..FOUR
        };
        assert_eq!(MeasureOnce(full).to_bytes(), b"GD0044072501\n");
        assert_eq!(
            MeasureOnce(Span {
                coding: Coding::TwoCharacter,
                ..full
            })
            .to_bytes(),
            b"GS0044072501\n"
        );
    }

    /// 1000 mm is `0?X`; the request and its pairs.
    #[test]
    fn distance_and_intensity() {
        let request = MeasureOnce(Span {
            last_step: 45,
            coding: Coding::WithIntensity,
            ..FOUR
        });
        assert_eq!(request.to_bytes(), b"GE0044004501\n");
        let scan = request.parse(&reply("GE0044004501", "0?X0nP007000"));
        let scan = scan.expect("two pairs");
        assert_eq!(
            (scan.ranges, scan.intensities),
            (vec![1000, 7], vec![4000, 0])
        );
        let odd = request.parse(&reply("GE0044004501", "0?X0nP007"));
        assert!(matches!(odd, Err(ReplyError::Length { .. })));
    }

    #[test]
    fn both_codings() {
        let scan = MeasureOnce(FOUR)
            .parse(&reply("GD0044004701", "1Dh00000706E"))
            .expect("four values");
        assert_eq!(scan.ranges, [5432, 0, 7, 405]);
        assert_eq!(
            (scan.stamp_ms, scan.first_step, scan.cluster),
            (6_968_830, 44, 1)
        );
        let two = MeasureOnce(Span {
            coding: Coding::TwoCharacter,
            ..FOUR
        });
        assert_eq!(
            two.parse(&reply("GS0044004701", "CB00oo07"))
                .expect("four values")
                .ranges,
            [1234, 0, 4095, 7]
        );
    }

    #[test]
    fn the_value_count_is_the_requested_one() {
        for data in ["1Dh000007", "1Dh00000706E06E"] {
            let error = MeasureOnce(FOUR)
                .parse(&reply("GD0044004701", data))
                .expect_err("three or five values");
            assert!(matches!(error, ReplyError::ValueCount { .. }));
        }
    }

    #[test]
    fn a_partial_last_group_may_be_there_or_not() {
        let clustered = MeasureOnce(Span { cluster: 3, ..FOUR });
        assert_eq!(
            clustered
                .parse(&reply("GD0044004703", "1Dh"))
                .expect("floor")
                .ranges
                .len(),
            1
        );
        assert_eq!(
            clustered
                .parse(&reply("GD0044004703", "1Dh06E"))
                .expect("ceiling")
                .ranges
                .len(),
            2
        );
    }

    #[test]
    fn the_laser_must_be_on() {
        let off = Message::first_in(b"GD0044004701\n10Q\n\n", Instant::ZERO).expect("complete");
        let error = MeasureOnce(FOUR).parse(&off).expect_err("10 is laser off");
        assert_eq!(error.refusal(), Some(Meaning::LaserOff));
    }
}
