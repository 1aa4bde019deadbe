//! The `KEY:value;` lines of `VV`, `PP` and `II` (scip2 section 3, sum rule).
//!
//! Most devices leave the `;` before the sum out of it, some count it, some leave out everything from `<-` on. A line
//! is good if any of the three holds.

use crate::encoding::sum;
use crate::error::ReplyError;
use crate::frame::ScipMessage;
use crate::status::ScipCommand;

/// One line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct KeyedLine<'a> {
    /// Before the first `:`.
    pub(super) key: &'a [u8],
    /// After it, without the closing `;`.
    pub(super) value: &'a [u8],
    /// Whether the sum is right by one of the three rules.
    pub(super) sum: Result<(), ReplyError>,
}

impl<'a> KeyedLine<'a> {
    /// `None` if the line has no `:`.
    pub(super) fn read(line: &'a [u8]) -> Option<Self> {
        let (got, counted) = line.split_last()?;
        let body = counted.strip_suffix(b";").unwrap_or(counted);
        let colon = body.iter().position(|byte| *byte == b':')?;
        let (key, rest) = body.split_at(colon);
        let value = rest.strip_prefix(b":").unwrap_or(rest);
        let comment = body
            .windows(2)
            .position(|pair| pair == b"<-")
            .and_then(|at| body.get(..at));
        let right = sum(body) == *got
            || sum(counted) == *got
            || comment.is_some_and(|text| sum(text) == *got);
        let sum = if right {
            Ok(())
        } else {
            Err(ReplyError::sum(line, sum(body), *got))
        };
        Some(Self { key, value, sum })
    }

    /// The value as text; unprintable bytes are replaced.
    pub(super) fn text(&self) -> String {
        String::from_utf8_lossy(self.value).trim().to_owned()
    }
}

/// The line of `key`. If there are several, the first whose sum is right, else the first.
pub(super) fn find<'a>(message: &'a ScipMessage, key: &str) -> Option<KeyedLine<'a>> {
    let lines = || {
        message
            .body()
            .filter_map(KeyedLine::read)
            .filter(|line| line.key == key.as_bytes())
    };
    lines()
        .find(|line| line.sum.is_ok())
        .or_else(|| lines().next())
}

/// As [`find`], and an error with the keys that are there if this one is not.
pub(super) fn require<'a>(
    message: &'a ScipMessage,
    key: &'static str,
    command: ScipCommand,
) -> Result<KeyedLine<'a>, ReplyError> {
    find(message, key).ok_or_else(|| {
        let keys: Vec<&[u8]> = message
            .body()
            .filter_map(KeyedLine::read)
            .map(|line| line.key)
            .collect();
        ReplyError::MissingKey {
            key,
            command,
            got: keys.join(&b' ').as_slice().into(),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_semicolon_may_count_or_not() {
        let without = KeyedLine::read(b"DMIN:20;4").expect("has a key");
        assert_eq!(
            (without.key, without.value, without.sum),
            (&b"DMIN"[..], &b"20"[..], Ok(()))
        );
        let mut with = b"DMIN:20;".to_vec();
        with.push(sum(&with));
        assert_eq!(KeyedLine::read(&with).expect("has a key").sum, Ok(()));
    }

    #[test]
    fn a_comment_may_count_or_not() {
        let real =
            KeyedLine::read(b"SBPS:19200[bps]<-Default setting by user;A").expect("has a key");
        assert_eq!(real.sum, Ok(()));
        let mut line = b"SBPS:19200[bps]<-Default setting by user;".to_vec();
        line.push(sum(b"SBPS:19200[bps]"));
        assert_eq!(KeyedLine::read(&line).expect("has a key").sum, Ok(()));
    }

    #[test]
    fn wrong_sums_are_errors() {
        let line = KeyedLine::read(b"DMIN:21;4").expect("has a key");
        assert!(matches!(line.sum, Err(ReplyError::Sum { got: b'4', .. })));
        assert_eq!(KeyedLine::read(b"I"), None);
        assert_eq!(KeyedLine::read(b""), None);
    }

    #[test]
    fn the_sum_character_may_itself_be_a_semicolon() {
        let body = (0_u8..64)
            .map(|k| vec![b'K', b':', b'0' + k])
            .find(|body| sum(body) == b';')
            .expect("one of 64");
        let line = [body.as_slice(), b";;"].concat();
        let read = KeyedLine::read(&line).expect("has a key");
        assert_eq!((read.value, read.sum), (&body[2..], Ok(())));
    }
}
