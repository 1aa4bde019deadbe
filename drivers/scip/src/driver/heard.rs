//! What was heard while connecting, and what it shows: a laser that cannot be used, or something that is none.

use super::error::ScipError;
use super::laser_line::LaserLine;
use crate::constants::{EXCERPT_BYTES, HEARD_BYTES, MIN_UNPRINTABLE_SHARE};
use crate::error::EscapedBytes;

/// The first and the last bytes heard, and the bytes sent, since the start of connecting.
#[derive(Debug, Default)]
pub(super) struct HeardFromLaser {
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

impl HeardFromLaser {
    pub(super) fn note(&mut self, bytes: &[u8]) {
        self.total = self.total.saturating_add(bytes.len() as u64);
        let unprintable = bytes.iter().filter(|byte| !is_printable(**byte)).count();
        self.unprintable = self.unprintable.saturating_add(unprintable as u64);
        keep_first(&mut self.first, bytes);
        self.last.extend_from_slice(bytes);
        let surplus = self.last.len().saturating_sub(EXCERPT_BYTES);
        self.last.drain(..surplus);
    }

    pub(super) fn note_sent(&mut self, bytes: &[u8]) {
        keep_first(&mut self.sent, bytes);
    }

    pub(super) fn total(&self) -> u64 {
        self.total
    }

    /// The end of what was heard, without the line ends that close it.
    pub(super) fn last(&self) -> EscapedBytes {
        self.last.trim_ascii().into()
    }

    pub(super) fn not_a_laser(&self) -> ScipError {
        let excerpt = self.first.get(..EXCERPT_BYTES).unwrap_or(&self.first);
        ScipError::NotALaser {
            line: self.line(),
            heard: excerpt.into(),
            bytes: self.total,
        }
    }

    /// Bytes came, and most are no text.
    pub(super) fn is_garbage(&self) -> bool {
        self.total > 0 && self.unprintable as f64 >= MIN_UNPRINTABLE_SHARE * self.total as f64
    }

    fn line(&self) -> LaserLine {
        if self.is_garbage() {
            return LaserLine::NotText;
        }
        let lines = || {
            self.first
                .split(|byte| matches!(byte, b'\r' | b'\n'))
                .map(<[u8]>::trim_ascii)
                .filter(|line| !line.is_empty())
        };
        if self.is_loopback() {
            LaserLine::Loopback
        } else if lines().any(is_modem) {
            LaserLine::Modem
        } else if lines().any(is_pan_tilt) {
            LaserLine::PanTilt
        } else if lines().any(is_stream) {
            LaserLine::DeafLaser
        } else {
            LaserLine::OtherText
        }
    }

    /// Whether all that came is what was sent, in the same order, at least half of it.
    fn is_loopback(&self) -> bool {
        let text = |bytes: &[u8]| -> Vec<u8> {
            let ends = |byte: &&u8| !matches!(byte, b'\r' | b'\n');
            bytes.iter().filter(ends).copied().collect()
        };
        let (heard, sent) = (text(&self.first), text(&self.sent));
        !heard.is_empty()
            && 2 * heard.len() >= sent.len()
            && sent.windows(heard.len()).any(|part| part == heard)
    }
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

/// The marker of a reply of the pan-tilt, perhaps after an echo, or its banner.
fn is_pan_tilt(line: &[u8]) -> bool {
    let marked = |line: &[u8]| {
        line == b"*" || line.starts_with(b"* ") || line.starts_with(b"! ") || line == b"!"
    };
    let after_echo = line.iter().position(|byte| *byte == b' ').map(|at| at + 1);
    marked(line)
        || line.starts_with(b"###")
        || after_echo.and_then(|at| line.get(at..)).is_some_and(marked)
}

/// The echo of `MD`, `MS` or `ME` over a scan.
fn is_stream(line: &[u8]) -> bool {
    matches!(line, [b'M', b'D' | b'S' | b'E', digits @ ..]
        if digits.len() == 13 && digits.iter().all(u8::is_ascii_digit))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line_of(sent: &[u8], heard: &[u8]) -> LaserLine {
        let mut bytes = HeardFromLaser::default();
        bytes.note_sent(sent);
        bytes.note(heard);
        bytes.line()
    }

    const SENT: &[u8] = b"QT\nQT\nSCIP2.0\n";

    #[test]
    fn each_kind_of_line_is_known_by_its_bytes() {
        for (heard, line) in [
            (SENT, LaserLine::Loopback),
            (b"T\r\nSCIP2.0\r\n", LaserLine::Loopback),
            (b"QT\r\nERROR\r\n", LaserLine::Modem),
            (b"NO CARRIER\r\n", LaserLine::Modem),
            (b"CONNECT 9600\r\n", LaserLine::Modem),
            (b"OKAY\r\n", LaserLine::OtherText),
            (b"QT\r\n", LaserLine::OtherText),
            (b"QT ! Illegal command\r\n", LaserLine::PanTilt),
            (b"*\r\n", LaserLine::PanTilt),
            (b"\r\n### PAN-TILT CONTROLLER\r\n", LaserLine::PanTilt),
            (b"a*b\r\n", LaserLine::OtherText),
            (b"MD0044072501000\n99b\n", LaserLine::DeafLaser),
            (b"MD0044\n", LaserLine::OtherText),
            (b"MX0044072501000\n", LaserLine::OtherText),
            (b"$GPGGA,1,2,3*47\r\n", LaserLine::OtherText),
            (b"\xf8\x80\x00~~", LaserLine::NotText),
        ] {
            assert_eq!(line_of(SENT, heard), line, "{}", heard.escape_ascii());
        }
    }

    #[test]
    fn single_spoilt_bytes_do_not_make_a_line_unreadable() {
        // Just less than one in ten, then just more.
        let heard = b"QT ! Illegal command\r\n".repeat(5);
        let spoilt = |count| {
            let mut bytes = heard.clone();
            bytes.extend(vec![0xFF; count]);
            line_of(SENT, &bytes)
        };
        assert_eq!(spoilt(12), LaserLine::PanTilt);
        assert_eq!(spoilt(13), LaserLine::NotText);
    }

    #[test]
    fn the_excerpt_is_short_and_memory_is_bounded() {
        let mut bytes = HeardFromLaser::default();
        for _ in 0..100 {
            bytes.note(b"0123456789abcdef\n");
            bytes.note_sent(b"QT\n");
        }
        assert_eq!(bytes.first.len(), HEARD_BYTES);
        assert_eq!((bytes.last.len(), bytes.sent.len()), (EXCERPT_BYTES, 300));
        let text = bytes.not_a_laser().to_string();
        assert!(
            text.starts_with(
                "heard \"0123456789abcdef\\n0123456789abcdef\\n012345\" (1700 bytes): "
            )
        );
        assert_eq!(
            bytes.last().to_string(),
            "\"bcdef\\n0123456789abcdef\\n0123456789abcdef\""
        );
    }
}
