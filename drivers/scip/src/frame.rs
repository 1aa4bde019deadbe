//! Cuts bytes into messages: all lines up to an empty one (scip2 section 3). A line may end in CR LF: serial servers and
//! line disciplines add the CR, which is no character of the protocol.
//!
//! Memory is bounded: a line or message longer than the limits of [`constants`](crate::constants) is dropped, and
//! reading goes on after the next empty line.

use crate::constants::{CR, LF, MAX_LINE_BYTES, MAX_MESSAGE_BYTES};
use crate::encoding::checked_body;
use crate::error::ReplyError;
use crate::status::StatusCode;
use std::time::Duration;

/// One reply; its sums are not checked yet.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ScipMessage {
    /// The lines, each with its LF; the closing empty line is not kept.
    bytes: Vec<u8>,
    /// Instant of the input that carried the first byte.
    pub first_byte_at: Duration,
    /// Instant of the input that carried the closing empty line.
    pub last_byte_at: Duration,
}

impl ScipMessage {
    /// The first complete message in `bytes`.
    #[cfg(test)]
    pub(crate) fn first_in(bytes: &[u8], at: Duration) -> Option<Self> {
        Framer::default().take(&mut &*bytes, at)
    }

    /// Bytes of its lines, each with its LF.
    pub(crate) fn len(&self) -> usize {
        self.bytes.len()
    }

    /// All lines, without their LF.
    pub fn lines(&self) -> impl Iterator<Item = &[u8]> {
        let body = self.bytes.strip_suffix(&[LF]).unwrap_or(&self.bytes);
        body.split(|byte| *byte == LF)
    }

    /// The first line: the request as the device received it.
    #[must_use]
    pub fn echo(&self) -> &[u8] {
        self.lines().next().unwrap_or_default()
    }

    /// The second line, its sum checked unless it is the single character of SCIP 1.1.
    ///
    /// # Errors
    /// [`ReplyError::NoStatus`] if there is none, [`ReplyError::Length`] or [`ReplyError::Sum`] if it is damaged.
    pub fn status(&self) -> Result<StatusCode, ReplyError> {
        let line = self.lines().nth(1).ok_or_else(|| ReplyError::NoStatus {
            echo: self.echo().into(),
        })?;
        status_code(line)
    }

    /// The lines after the status, each still with its sum.
    pub fn body(&self) -> impl Iterator<Item = &[u8]> {
        self.lines().skip(2)
    }
}

/// Reads a status line: one character, or two and their sum.
fn status_code(line: &[u8]) -> Result<StatusCode, ReplyError> {
    match line {
        [plain] => Ok(StatusCode::Plain(*plain)),
        [_, _, _] => match checked_body(line)? {
            [high, low] => Ok(StatusCode::Code([*high, *low])),
            body => Err(ReplyError::Length {
                what: "status line",
                expected: 2,
                got: body.len(),
            }),
        },
        _ => Err(ReplyError::Length {
            what: "status line",
            expected: 3,
            got: line.len(),
        }),
    }
}

/// Collects bytes into [`ScipMessage`]s; holds at most `MAX_MESSAGE_BYTES`.
#[derive(Debug, Default)]
pub struct Framer {
    buffer: Vec<u8>,
    /// Of the line under way, with its CR.
    line_bytes: usize,
    /// The last byte of the line under way was a CR.
    ends_in_cr: bool,
    skipping: bool,
    first_byte_at: Duration,
    overruns: u64,
}

impl Framer {
    /// Consumes `input` up to the end of its first message and returns that, or consumes it all. Call again until `input`
    /// is empty.
    pub fn take(&mut self, input: &mut &[u8], now: Duration) -> Option<ScipMessage> {
        while !input.is_empty() {
            let Some(at) = input.iter().position(|byte| *byte == LF) else {
                self.extend_line(input, now);
                *input = &[];
                return None;
            };
            let (piece, rest) = input.split_at(at);
            self.extend_line(piece, now);
            *input = rest.strip_prefix(&[LF]).unwrap_or(rest);
            if let Some(message) = self.end_line(now) {
                return Some(message);
            }
        }
        None
    }

    /// Drops a half-read message, as after opening the port again.
    pub(crate) fn clear(&mut self) {
        *self = Self {
            overruns: self.overruns,
            ..Self::default()
        };
    }

    /// Whether nothing of a message was read yet.
    pub(crate) fn is_between_messages(&self) -> bool {
        self.buffer.is_empty() && self.line_bytes == 0 && !self.skipping
    }

    /// How many lines or messages were dropped for their length.
    #[must_use]
    pub fn overruns(&self) -> u64 {
        self.overruns
    }

    /// At most `MAX_MESSAGE_BYTES`.
    #[must_use]
    pub fn held_bytes(&self) -> usize {
        self.buffer.len()
    }

    fn extend_line(&mut self, piece: &[u8], now: Duration) {
        self.line_bytes = self.line_bytes.saturating_add(piece.len());
        if let Some(last) = piece.last() {
            self.ends_in_cr = *last == CR;
        }
        if self.skipping || piece.is_empty() {
            return;
        }
        // One more byte for the line's own LF.
        if self.line_bytes > MAX_LINE_BYTES
            || self.buffer.len() + piece.len() + 1 > MAX_MESSAGE_BYTES
        {
            self.buffer = Vec::new();
            self.skipping = true;
            self.overruns += 1;
            return;
        }
        if self.buffer.is_empty() {
            self.first_byte_at = now;
        }
        self.buffer.extend_from_slice(piece);
    }

    fn end_line(&mut self, now: Duration) -> Option<ScipMessage> {
        let has_cr = std::mem::take(&mut self.ends_in_cr);
        if has_cr && !self.skipping {
            self.buffer.pop();
        }
        if std::mem::take(&mut self.line_bytes) > usize::from(has_cr) {
            if !self.skipping {
                self.buffer.push(LF);
            }
            return None;
        }
        self.skipping = false;
        if self.buffer.is_empty() {
            return None;
        }
        let bytes = std::mem::take(&mut self.buffer);
        Some(ScipMessage {
            bytes,
            first_byte_at: self.first_byte_at,
            last_byte_at: now,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn messages(framer: &mut Framer, mut input: &[u8], now: Duration) -> Vec<ScipMessage> {
        let mut all = Vec::new();
        while let Some(message) = framer.take(&mut input, now) {
            all.push(message);
        }
        all
    }

    #[test]
    fn a_message_is_echo_status_and_body() {
        let message =
            ScipMessage::first_in(b"TM1\n00P\n<SfkP\n\n", Duration::ZERO).expect("complete");
        assert_eq!(message.echo(), b"TM1");
        assert_eq!(
            message.status().expect("sum is right"),
            StatusCode::Code(*b"00")
        );
        assert_eq!(message.body().collect::<Vec<_>>(), [b"<SfkP"]);
    }

    #[test]
    fn the_first_byte_keeps_its_instant() {
        let mut framer = Framer::default();
        let at = Duration::from_millis;
        assert!(messages(&mut framer, b"B", at(10)).is_empty());
        assert!(messages(&mut framer, b"M\n02R\n", at(20)).is_empty());
        let got = messages(&mut framer, b"\nQ", at(30));
        assert_eq!(
            (got[0].first_byte_at, got[0].last_byte_at),
            (at(10), at(30))
        );
        let got = messages(&mut framer, b"T\n00P\n\n", at(40));
        assert_eq!(
            (got[0].first_byte_at, got[0].last_byte_at),
            (at(30), at(40))
        );
    }

    #[test]
    fn stray_empty_lines_are_no_messages() {
        let mut framer = Framer::default();
        assert_eq!(
            messages(
                &mut framer,
                b"\n\n\nQT\n00P\n\n\n\nBM\n00P\n\n",
                Duration::ZERO
            )
            .len(),
            2
        );
    }

    #[test]
    fn an_endless_line_is_dropped_and_reading_starts_again_at_the_empty_line() {
        let mut framer = Framer::default();
        for _ in 0..1000 {
            assert!(messages(&mut framer, &[0xFF; 999], Duration::ZERO).is_empty());
            assert!(framer.held_bytes() <= MAX_MESSAGE_BYTES);
        }
        let got = messages(&mut framer, b"x\nQT\n00P\n\nQT\n00P\n\n", Duration::ZERO);
        assert_eq!(got.len(), 1);
        assert_eq!(framer.overruns(), 1);
    }

    #[test]
    fn endless_short_lines_are_dropped_too() {
        // Lines that meet the limit exactly, and lines that step over it.
        for line in [&b"abc\n"[..], b"abcdef\n"] {
            let mut framer = Framer::default();
            for _ in 0..10_000 {
                assert!(messages(&mut framer, line, Duration::ZERO).is_empty());
                assert!(framer.held_bytes() <= MAX_MESSAGE_BYTES);
            }
            assert_eq!(framer.overruns(), 1);
            assert_eq!(
                messages(&mut framer, b"\nQT\n00P\n\n", Duration::ZERO).len(),
                1
            );
        }
    }

    #[test]
    fn a_cr_before_the_lf_is_no_part_of_the_line() {
        let mut framer = Framer::default();
        let stream = b"\r\nQT\r\n00P\r\n\r\nBM\n0\r2R\n\r\n";
        // Whole, and byte by byte: the CR and the LF in different reads.
        let whole = messages(&mut framer, stream, Duration::ZERO);
        let mut single = Vec::new();
        for byte in stream {
            single.extend(messages(&mut framer, &[*byte], Duration::ZERO));
        }
        assert_eq!(whole, single);
        assert_eq!(whole[0].lines().collect::<Vec<_>>(), [&b"QT"[..], b"00P"]);
        let inner: Vec<_> = whole[1].lines().collect();
        assert_eq!(inner, [&b"BM"[..], b"0\r2R"], "only before the LF");
        assert!(framer.is_between_messages());
    }

    #[test]
    fn an_overlong_line_ends_at_the_empty_line_with_cr_too() {
        let mut framer = Framer::default();
        let mut flood = vec![b'x'; 2 * MAX_LINE_BYTES];
        flood.extend_from_slice(b"\r\n\r\nQT\r\n00P\r\n\r\n");
        let got = messages(&mut framer, &flood, Duration::ZERO);
        assert_eq!((got.len(), framer.overruns()), (1, 1));
        assert_eq!(got[0].echo(), b"QT");
    }

    #[test]
    fn nothing_of_a_half_read_message_survives_a_reopened_port() {
        for half in [
            &b"MD0044072501000\n99b\n"[..],
            b"MD00",
            b"QT\r",
            &[b'x'; 999],
        ] {
            let mut framer = Framer::default();
            assert!(messages(&mut framer, half, Duration::ZERO).is_empty());
            assert!(!framer.is_between_messages());
            framer.clear();
            assert!(framer.is_between_messages());
            let got = messages(&mut framer, b"QT\n00P\n\n", Duration::ZERO);
            let [message] = got.as_slice() else {
                panic!("{got:?}")
            };
            assert_eq!(message.lines().collect::<Vec<_>>(), [&b"QT"[..], b"00P"]);
        }
    }

    #[test]
    fn a_message_without_status_says_so() {
        let message = ScipMessage::first_in(b"QT\n\n", Duration::ZERO).expect("complete");
        assert!(matches!(message.status(), Err(ReplyError::NoStatus { .. })));
    }

    #[test]
    fn damaged_status_lines_are_errors() {
        assert_eq!(status_code(b"02R"), Ok(StatusCode::Code(*b"02")));
        assert_eq!(status_code(b"E"), Ok(StatusCode::Plain(b'E')));
        assert!(matches!(status_code(b"00Q"), Err(ReplyError::Sum { .. })));
        assert!(matches!(status_code(b"00"), Err(ReplyError::Length { .. })));
        assert!(matches!(status_code(b""), Err(ReplyError::Length { .. })));
    }
}
