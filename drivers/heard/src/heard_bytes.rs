//! The bytes themselves, of bounded memory.

use crate::constants::{EXCERPT_BYTES, HEARD_BYTES, MIN_UNPRINTABLE_SHARE};

/// The first and the last bytes heard, and the first bytes sent, since the start of connecting.
#[derive(Debug, Default)]
pub struct HeardBytes {
    first: Vec<u8>,
    last: Vec<u8>,
    sent: Vec<u8>,
    total: u64,
    unprintable: u64,
}

fn is_printable(byte: u8) -> bool {
    matches!(byte, 0x20..0x7F | b'\r' | b'\n' | b'\t')
}

fn keep_first(kept: &mut Vec<u8>, bytes: &[u8]) {
    let room = HEARD_BYTES.saturating_sub(kept.len());
    kept.extend(bytes.iter().take(room));
}

impl HeardBytes {
    /// Bytes that came.
    pub fn note(&mut self, bytes: &[u8]) {
        self.total = self.total.saturating_add(bytes.len() as u64);
        let unprintable = bytes.iter().filter(|byte| !is_printable(**byte)).count();
        self.unprintable = self.unprintable.saturating_add(unprintable as u64);
        keep_first(&mut self.first, bytes);
        self.last.extend_from_slice(bytes);
        let surplus = self.last.len().saturating_sub(EXCERPT_BYTES);
        self.last.drain(..surplus);
    }

    /// Bytes that the driver sent.
    pub fn note_sent(&mut self, bytes: &[u8]) {
        keep_first(&mut self.sent, bytes);
    }

    /// Number of all bytes that came.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.total
    }

    /// What was sent first.
    #[must_use]
    pub fn sent(&self) -> &[u8] {
        &self.sent
    }

    /// The beginning of what came, for a message.
    #[must_use]
    pub fn beginning(&self) -> &[u8] {
        self.first.get(..EXCERPT_BYTES).unwrap_or(&self.first)
    }

    /// The end of what came, for a message, without the line ends that close it.
    #[must_use]
    pub fn end(&self) -> &[u8] {
        self.last.trim_ascii()
    }

    /// The first lines, spaces around them kept; none of them is blank.
    pub fn lines(&self) -> impl Iterator<Item = &[u8]> {
        self.first
            .split(|byte| matches!(byte, b'\r' | b'\n'))
            .filter(|line| !line.trim_ascii().is_empty())
    }

    /// Bytes came, and too many of them are no text.
    #[must_use]
    pub fn is_garbage(&self) -> bool {
        self.total > 0 && self.unprintable as f64 >= MIN_UNPRINTABLE_SHARE * self.total as f64
    }

    /// Whether all that came is what was sent, in the same order, at least half of it. Spaces and line ends do not count.
    #[must_use]
    pub fn is_loopback(&self) -> bool {
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

#[cfg(test)]
mod tests {
    use super::{EXCERPT_BYTES, HEARD_BYTES, HeardBytes};

    fn heard(sent: &[u8], came: &[u8]) -> HeardBytes {
        let mut bytes = HeardBytes::default();
        bytes.note_sent(sent);
        bytes.note(came);
        bytes
    }

    #[test]
    fn excerpts_are_short_and_memory_is_bounded() {
        let mut bytes = HeardBytes::default();
        for _ in 0..100 {
            bytes.note(b"0123456789abcdef\n");
            bytes.note_sent(b"QT\n");
        }
        assert_eq!(bytes.first.len(), HEARD_BYTES);
        assert_eq!((bytes.last.len(), bytes.sent().len()), (EXCERPT_BYTES, 300));
        assert_eq!(bytes.total(), 1700);
        assert_eq!(
            bytes.beginning(),
            b"0123456789abcdef\n0123456789abcdef\n012345"
        );
        assert_eq!(bytes.end(), b"bcdef\n0123456789abcdef\n0123456789abcdef");
    }

    #[test]
    fn a_tenth_of_bytes_that_no_text_has_is_garbage() {
        let spoilt = |count| [b"text\t\r\n".repeat(13).as_slice(), &vec![0xF8; count]].concat();
        assert!(!heard(b"", &spoilt(10)).is_garbage(), "10 of 101");
        assert!(heard(b"", &spoilt(11)).is_garbage(), "11 of 102");
        assert!(!heard(b"", b"").is_garbage());
    }

    #[test]
    fn a_loopback_returns_at_least_half_of_what_was_sent_and_nothing_else() {
        let is_loopback = |came: &[u8]| heard(b"QT\nSCIP2.0\n", came).is_loopback();
        assert!(is_loopback(b"QT\r\nSCIP2.0\r\n"));
        assert!(is_loopback(b"SCIP2"), "five of nine letters");
        assert!(!is_loopback(b"SCIP"), "four of nine");
        assert!(!is_loopback(b"SCIP2.0\n00P"));
        assert!(!is_loopback(b"SCIP2.0 QT"));
        assert!(!is_loopback(b"\r\n"));
    }

    #[test]
    fn blank_lines_are_none() {
        let bytes = heard(b"", b"\r\n  \r\n * a\r\nb");
        assert_eq!(bytes.lines().collect::<Vec<_>>(), [&b" * a"[..], b"b"]);
    }
}
