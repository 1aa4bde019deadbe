//! What was heard while connecting to something that is no pan-tilt unit, and what it shows.

use crate::constants::{EXCERPT_BYTES, HEARD_BYTES, MIN_UNPRINTABLE_SHARE};
use crate::error::HeadError;
use crate::head_line::HeadLine;
use crate::reply::{self, ReplyOutcome};

/// The first bytes heard, and the bytes sent, since the start of connecting.
#[derive(Debug, Default)]
pub(crate) struct HeardFromHead {
    first: Vec<u8>,
    sent: Vec<u8>,
    total: u64,
    unprintable: u64,
}

fn is_printable(byte: u8) -> bool {
    matches!(byte, 0x20..0x7F | b'\r' | b'\n' | b'\t')
}

impl HeardFromHead {
    pub(crate) fn note(&mut self, byte: u8) {
        self.total = self.total.saturating_add(1);
        self.unprintable = self
            .unprintable
            .saturating_add(u64::from(!is_printable(byte)));
        if self.first.len() < HEARD_BYTES {
            self.first.push(byte);
        }
    }

    pub(crate) fn note_sent(&mut self, bytes: &[u8]) {
        let room = HEARD_BYTES.saturating_sub(self.sent.len());
        self.sent.extend(bytes.iter().take(room));
    }

    /// Why nothing was connected.
    pub(crate) fn error(&self) -> HeadError {
        if self.total == 0 {
            return HeadError::Silent;
        }
        let excerpt = self.first.get(..EXCERPT_BYTES).unwrap_or(&self.first);
        HeadError::NotAHead {
            line: self.line(),
            heard: excerpt.escape_ascii().to_string(),
            bytes_heard: self.total,
        }
    }

    /// Bytes came, and most are no text.
    pub(crate) fn is_garbage(&self) -> bool {
        self.total > 0 && self.unprintable as f64 >= MIN_UNPRINTABLE_SHARE * self.total as f64
    }

    fn line(&self) -> HeadLine {
        if self.is_garbage() {
            return HeadLine::NotText;
        }
        let lines: Vec<&[u8]> = self
            .first
            .split(|byte| matches!(byte, b'\r' | b'\n'))
            .filter(|line| !line.trim_ascii().is_empty())
            .collect();
        // The laser before the loopback: after an echo its `E` looks like the beginning of the next `ED`.
        if lines.iter().any(|line| is_laser(line)) || self.has_old_status(&lines) {
            HeadLine::Laser
        } else if self.is_loopback() {
            HeadLine::Loopback
        } else if lines.iter().any(|line| is_modem(line.trim_ascii())) {
            HeadLine::Modem
        } else if lines.iter().any(|line| is_reply(line)) {
            HeadLine::OtherReplies
        } else {
            HeadLine::OtherText
        }
    }

    /// A status of SCIP 1.1: a single character after an echo, all of whose words were sent, now or by an earlier attempt.
    fn has_old_status(&self, lines: &[&[u8]]) -> bool {
        let words = |bytes: &[u8]| -> Vec<Vec<u8>> {
            let words = bytes.split(u8::is_ascii_whitespace);
            words
                .filter(|w| !w.is_empty())
                .map(<[u8]>::to_vec)
                .collect()
        };
        let sent = words(&self.sent);
        lines.windows(2).any(|pair| {
            matches!(pair[1], b"E" | b"0") && words(pair[0]).iter().all(|word| sent.contains(word))
        })
    }

    /// Whether all that came is what was sent, in the same order, at least half of it. Spaces and line ends do not count.
    fn is_loopback(&self) -> bool {
        let text = |bytes: &[u8]| -> Vec<u8> {
            let letters = bytes.iter().filter(|byte| !byte.is_ascii_whitespace());
            letters.copied().collect()
        };
        let (heard, sent) = (text(&self.first), text(&self.sent));
        !heard.is_empty()
            && 2 * heard.len() >= sent.len()
            && sent.windows(heard.len()).any(|part| part == heard)
    }
}

fn is_reply(line: &[u8]) -> bool {
    matches!(
        reply::parse(line).outcome,
        ReplyOutcome::Success(_) | ReplyOutcome::Refusal(_)
    )
}

/// Result codes of the AT command set.
fn is_modem(line: &[u8]) -> bool {
    const CODES: [&[u8]; 7] = [
        b"OK",
        b"ERROR",
        b"NO CARRIER",
        b"NO DIALTONE",
        b"BUSY",
        b"RING",
        b"+++",
    ];
    CODES.contains(&line) || line.starts_with(b"CONNECT ") || line.starts_with(b"AT+")
}

/// A status line of SCIP: two characters and their sum, low six bits plus 0x30; or the echo of a stream of scans.
fn is_laser(line: &[u8]) -> bool {
    match line {
        [a @ b'0'..=b'9', b @ (b'0'..=b'9' | b'A'..=b'Z'), sum] => {
            (a.wrapping_add(*b) & 0x3F) + 0x30 == *sum
        }
        [b'M', b'D' | b'S' | b'E', digits @ ..] => {
            digits.len() == 13 && digits.iter().all(u8::is_ascii_digit)
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of two attempts.
    const SENT: &[u8] = b"   ED FT V   \rED FT V ";

    fn error_of(heard: &[u8]) -> HeadError {
        let mut bytes = HeardFromHead::default();
        bytes.note_sent(SENT);
        heard.iter().for_each(|byte| bytes.note(*byte));
        bytes.error()
    }

    fn line_of(heard: &[u8]) -> HeadLine {
        match error_of(heard) {
            HeadError::NotAHead { line, .. } => line,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn each_kind_of_line_is_known_by_its_bytes() {
        for (heard, line) in [
            (SENT, HeadLine::Loopback),
            (b"FT V   \rED", HeadLine::Loopback),
            (b"FT V", HeadLine::OtherText),
            (b"ED FT V\r\nERROR\r\n", HeadLine::Modem),
            (b"NO CARRIER\r\n", HeadLine::Modem),
            (b"CONNECT 9600\r\n", HeadLine::Modem),
            (b"OKAY\r\n", HeadLine::OtherText),
            (b"V\r\n", HeadLine::OtherText),
            (b"   ED FT V\n0Ee\n\n", HeadLine::Laser),
            (b"   ED FT V\n0Ef\n\n", HeadLine::OtherText),
            (b"   ED FT V\nE\n\n", HeadLine::Laser),
            (b"FT V    ED FT V\n0\n\n", HeadLine::Laser),
            (b"hello\nE\n\n", HeadLine::OtherText),
            (b"MD0044072501000\n99b\n", HeadLine::Laser),
            (b"MD00440725010001\n", HeadLine::OtherText),
            (b"V ! Illegal command\r\n", HeadLine::OtherReplies),
            (b"*\r\n", HeadLine::OtherReplies),
            (b"$GPGGA,1,2,3\r\n", HeadLine::OtherText),
            (b"\xf8\x80\x00~~", HeadLine::NotText),
        ] {
            assert_eq!(line_of(heard), line, "{}", heard.escape_ascii());
        }
        assert_eq!(error_of(b""), HeadError::Silent);
    }

    #[test]
    fn single_spoilt_bytes_do_not_make_a_line_unreadable() {
        let spoilt = |count| {
            let mut bytes = b"V ! Illegal command\r\n".repeat(5);
            bytes.extend(vec![0xFF; count]);
            line_of(&bytes)
        };
        // Just less than one in ten of 105 and them, then just more.
        assert_eq!(spoilt(11), HeadLine::OtherReplies);
        assert_eq!(spoilt(12), HeadLine::NotText);
    }

    #[test]
    fn the_excerpt_is_short_and_memory_is_bounded() {
        let mut bytes = HeardFromHead::default();
        for _ in 0..100 {
            b"0123456789abcdef\r\n"
                .iter()
                .for_each(|byte| bytes.note(*byte));
            bytes.note_sent(SENT);
        }
        assert_eq!((bytes.first.len(), bytes.sent.len()), (512, 512));
        let text = bytes.error().to_string();
        let excerpt = "heard \"0123456789abcdef\\r\\n0123456789abcdef\\r\\n0123\" (1800 bytes): an unknown device";
        assert!(text.starts_with(excerpt), "{text}");
    }
}
