//! The stamp line and the data lines of a scan (scip2 section 6, data lines).
//!
//! Values are joined, then cut every 64 characters, each piece with its own sum; so a value may straddle two lines.

use super::span::ScanSpan;
use crate::constants::DATA_LINE_CHARACTERS;
use crate::encoding::{checked_body, decode};
use crate::error::ReplyError;
use crate::frame::ScipMessage;
use crate::scan::{LaserScan, ValueCoding};

const STAMP_CHARACTERS: usize = 4;

/// Reads stamp and values of a reply whose status was checked.
pub(super) fn read_scan(
    message: &ScipMessage,
    span: &ScanSpan,
    remaining: u8,
) -> Result<LaserScan, ReplyError> {
    let mut lines = message.body();
    let stamp_ms = read_stamp(lines.next().unwrap_or_default())?;
    let (min_values, max_values) = span.value_counts();
    let (ranges, intensities) = if span.coding == ValueCoding::WithIntensity {
        let values = read_values(lines, ValueCoding::ThreeCharacter.width(), 2 * max_values)?;
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
        let ranges = read_values(lines, span.coding.width(), max_values)?;
        (ranges, Vec::new())
    };
    if ranges.len() < min_values {
        return Err(ReplyError::ValueCount {
            expected: min_values,
            got: ranges.len(),
        });
    }
    Ok(LaserScan {
        first_step: span.first_step,
        cluster: span.cluster.max(1),
        coding: span.coding,
        ranges,
        intensities,
        stamp_ms,
        remaining,
    })
}

/// Reads a stamp line: four characters and their sum; ms, 24 bits.
pub(super) fn read_stamp(line: &[u8]) -> Result<u32, ReplyError> {
    if line.len() != STAMP_CHARACTERS + 1 {
        return Err(ReplyError::Length {
            what: "stamp line",
            expected: STAMP_CHARACTERS + 1,
            got: line.len(),
        });
    }
    decode(checked_body(line)?)
}

/// Reads the data lines: values of `width` characters, at most `limit` of them. Every line but the last must be full.
fn read_values<'a>(
    lines: impl Iterator<Item = &'a [u8]>,
    width: usize,
    limit: usize,
) -> Result<Vec<u32>, ReplyError> {
    let mut characters: Vec<u8> = Vec::with_capacity(limit.saturating_mul(width));
    let mut last_was_short = None;
    for line in lines {
        let body = checked_body(line)?;
        if let Some(got) = last_was_short {
            return Err(ReplyError::Length {
                what: "data line",
                expected: DATA_LINE_CHARACTERS,
                got,
            });
        }
        if body.is_empty() || body.len() > DATA_LINE_CHARACTERS {
            return Err(ReplyError::Length {
                what: "data line",
                expected: DATA_LINE_CHARACTERS,
                got: body.len(),
            });
        }
        last_was_short = (body.len() < DATA_LINE_CHARACTERS).then_some(body.len());
        characters.extend_from_slice(body);
        if characters.len() > limit.saturating_mul(width) {
            return Err(ReplyError::ValueCount {
                expected: limit,
                got: characters.len() / width.max(1),
            });
        }
    }
    let values = characters.chunks_exact(width.max(1));
    if !values.remainder().is_empty() {
        let got = values.remainder().len();
        return Err(ReplyError::Length {
            what: "last value",
            expected: width,
            got,
        });
    }
    values.map(decode).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encoding::{encode, sum};
    use proptest::prelude::*;

    fn cut(characters: &[u8]) -> Vec<Vec<u8>> {
        characters
            .chunks(DATA_LINE_CHARACTERS)
            .map(|piece| [piece, &[sum(piece)]].concat())
            .collect()
    }

    fn read(lines: &[Vec<u8>], width: usize) -> Result<Vec<u32>, ReplyError> {
        read_values(lines.iter().map(Vec::as_slice), width, 1000)
    }

    #[test]
    fn parses_the_recorded_stamp() {
        assert_eq!(read_stamp(b"JUGnD"), Ok(6_968_830));
        assert!(read_stamp(b"JUGnE").is_err());
        assert!(read_stamp(b"JUG4").is_err());
        assert!(read_stamp(b"").is_err());
    }

    #[test]
    fn a_short_line_may_only_be_the_last() {
        let lines = cut(&[b'0'; 128]);
        let short = cut(&[b'0'; 4]).remove(0);
        assert_eq!(read(&lines, 2).map(|values| values.len()), Ok(64));
        assert!(read(&[short, lines[0].clone()], 2).is_err());
    }

    #[test]
    fn a_broken_last_value_is_an_error() {
        assert!(matches!(
            read(&cut(&[b'0'; 65]), 3),
            Err(ReplyError::Length {
                what: "last value",
                ..
            })
        ));
    }

    #[test]
    fn excess_values_are_rejected() {
        let lines = cut(&[b'0'; 66]);
        let read = read_values(lines.iter().map(Vec::as_slice), 3, 21);
        assert!(matches!(
            read,
            Err(ReplyError::ValueCount { expected: 21, .. })
        ));
    }

    proptest! {
        #[test]
        fn values_round_trip(ranges in proptest::collection::vec(0_u32..(1 << 18), 0..800)) {
            let characters: Vec<u8> =
                ranges.iter().flat_map(|value| encode::<3>(*value).expect("18 bits fit")).collect();
            prop_assert_eq!(read(&cut(&characters), 3), Ok(ranges));
        }
    }
}
