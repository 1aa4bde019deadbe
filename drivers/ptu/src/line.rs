//! From bytes to lines and notices (ptu-d46 section 2).
//!
//! A notice (`!P`) has no line end of its own and may stand before, between or within other replies, so it is taken out of the stream
//! at its second byte. Lines end with CR, LF or both; empty lines are dropped.

use std::time::Duration;

use crate::Axis;
use crate::constants::MAX_LINE_BYTES;

/// An unsolicited message of the unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Notice {
    /// `!P`, `!T`: a limit switch or stop.
    Limit(Axis),
    /// `!D`: the cable between controller and head was disconnected.
    Cable,
    /// `#P` `#T` `$P` `$T`: position and speed triggers, which this driver never sets.
    Trigger,
}

/// A complete line without its line end and without notices.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ReplyLine {
    pub(crate) bytes: Vec<u8>,
    /// When the reply began: at `*` or `!`, else at the line's first byte.
    pub(crate) reply_at: Duration,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Token {
    Notice(Notice),
    Line(ReplyLine),
    /// A line exceeded [`MAX_LINE_BYTES`] and is discarded up to its end.
    Overlong,
}

/// Collects bytes; holds at most [`MAX_LINE_BYTES`] of them.
#[derive(Debug, Default)]
pub(crate) struct ReplyBuffer {
    bytes: Vec<u8>,
    reply_at: Option<Duration>,
    marker_seen: bool,
    skipping: bool,
}

impl ReplyBuffer {
    /// Whether nothing of a line was read yet.
    pub(crate) fn is_between_lines(&self) -> bool {
        self.bytes.is_empty() && !self.skipping
    }

    pub(crate) fn clear(&mut self) {
        *self = Self::default();
    }

    pub(crate) fn push(&mut self, byte: u8, at: Duration) -> Option<Token> {
        if matches!(byte, b'\r' | b'\n') {
            let line = ReplyLine {
                bytes: std::mem::take(&mut self.bytes),
                reply_at: self.reply_at.unwrap_or(at),
            };
            let usable = !self.skipping && !line.bytes.is_empty();
            self.clear();
            return usable.then_some(Token::Line(line));
        }
        if let Some(notice) = self.bytes.last().and_then(|last| notice(*last, byte)) {
            self.bytes.pop();
            if self.bytes.is_empty() {
                self.reply_at = None;
                self.marker_seen = false;
            }
            return Some(Token::Notice(notice));
        }
        if self.skipping {
            // Only the last byte is kept, so that notices are still seen.
            self.bytes.clear();
            self.bytes.push(byte);
            return None;
        }
        if self.reply_at.is_none() || (!self.marker_seen && matches!(byte, b'*' | b'!')) {
            self.reply_at = Some(at);
            self.marker_seen = matches!(byte, b'*' | b'!');
        }
        self.bytes.push(byte);
        if self.bytes.len() > MAX_LINE_BYTES {
            self.clear();
            self.skipping = true;
            return Some(Token::Overlong);
        }
        None
    }
}

fn notice(first: u8, second: u8) -> Option<Notice> {
    match (first, second) {
        (b'!', b'P') => Some(Notice::Limit(Axis::Pan)),
        (b'!', b'T') => Some(Notice::Limit(Axis::Tilt)),
        (b'!', b'D') => Some(Notice::Cable),
        (b'#' | b'$', b'P' | b'T') => Some(Notice::Trigger),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tokens(bytes: &[u8]) -> Vec<Token> {
        let mut buffer = ReplyBuffer::default();
        let at = |i: usize| Duration::from_millis(i as u64);
        bytes
            .iter()
            .enumerate()
            .filter_map(|(i, byte)| buffer.push(*byte, at(i)))
            .collect()
    }

    fn line(text: &str, at_ms: u64) -> Token {
        Token::Line(ReplyLine {
            bytes: text.into(),
            reply_at: Duration::from_millis(at_ms),
        })
    }

    #[test]
    fn every_line_end_ends_a_line_once() {
        for end in ["\r", "\n", "\r\n"] {
            let stream = format!("* 1{end}* 2{end}");
            let second = 3 + end.len() as u64;
            assert_eq!(
                tokens(stream.as_bytes()),
                [line("* 1", 0), line("* 2", second)],
                "{end:?}"
            );
        }
    }

    #[test]
    fn notices_are_taken_from_anywhere() {
        let (pan, tilt) = (
            Token::Notice(Notice::Limit(Axis::Pan)),
            Token::Notice(Notice::Limit(Axis::Tilt)),
        );
        assert_eq!(
            tokens(b"!P"),
            std::slice::from_ref(&pan),
            "a notice needs no line end"
        );
        let reset = [
            tilt.clone(),
            tilt.clone(),
            pan.clone(),
            pan.clone(),
            line("*", 8),
        ];
        assert_eq!(tokens(b"!T!T!P!P*\r\n"), reset);
        assert_eq!(tokens(b"* 1!P00\r\n"), [pan, line("* 100", 0)]);
        assert_eq!(
            tokens(b"!D#P$T"),
            [
                Token::Notice(Notice::Cable),
                Token::Notice(Notice::Trigger),
                Token::Notice(Notice::Trigger)
            ]
        );
        assert_eq!(
            tokens(b"! Pan speed cannot exceed\r"),
            [line("! Pan speed cannot exceed", 0)]
        );
    }

    #[test]
    fn the_reply_begins_at_its_marker_not_at_the_echo() {
        assert_eq!(tokens(b"PP * 22\r\n"), [line("PP * 22", 3)]);
    }

    #[test]
    fn an_overlong_line_is_discarded_up_to_its_end() {
        let mut stream = vec![0xff; 10_000];
        stream.extend_from_slice(b"!P\r\n* 5\r\n");
        let got = tokens(&stream);
        assert_eq!(got.len(), 3);
        assert_eq!(got[0], Token::Overlong);
        assert_eq!(got[1], Token::Notice(Notice::Limit(Axis::Pan)));
        assert!(matches!(&got[2], Token::Line(l) if l.bytes == b"* 5"));
    }
}
