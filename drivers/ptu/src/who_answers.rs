//! What was heard while connecting to something that is no pan-tilt unit, and what it shows.

use crate::error::HeadError;
use crate::head_line::HeadLine;
use crate::reply::{self, ReplyOutcome};
use heard::{HeardBytes, is_modem_code, is_scan_echo};

/// Why nothing was connected.
pub(crate) fn not_a_head(heard: &HeardBytes) -> HeadError {
    if heard.total() == 0 {
        return HeadError::Silent;
    }
    HeadError::NotAHead {
        line: line(heard),
        heard: heard.beginning().escape_ascii().to_string(),
        bytes_heard: heard.total(),
    }
}

fn line(heard: &HeardBytes) -> HeadLine {
    let any = |is_such: fn(&[u8]) -> bool| heard.lines().any(is_such);
    // The laser before the loopback: after an echo its `E` looks like the beginning of the next `ED`.
    if heard.is_garbage() {
        HeadLine::NotText
    } else if any(is_laser) || has_old_status(heard) {
        HeadLine::Laser
    } else if heard.is_loopback() {
        HeadLine::Loopback
    } else if any(|line| is_modem_code(line.trim_ascii())) {
        HeadLine::Modem
    } else if any(is_reply) {
        HeadLine::OtherReplies
    } else {
        HeadLine::OtherText
    }
}

/// A status of SCIP 1.1: a single character after an echo, all of whose words were sent, now or by an earlier attempt.
fn has_old_status(heard: &HeardBytes) -> bool {
    let words = |bytes: &[u8]| -> Vec<Vec<u8>> {
        let words = bytes.split(u8::is_ascii_whitespace);
        words
            .filter(|w| !w.is_empty())
            .map(<[u8]>::to_vec)
            .collect()
    };
    let sent = words(heard.sent());
    let lines: Vec<&[u8]> = heard.lines().collect();
    lines.windows(2).any(|pair| {
        matches!(pair[1], b"E" | b"0") && words(pair[0]).iter().all(|word| sent.contains(word))
    })
}

fn is_reply(line: &[u8]) -> bool {
    matches!(
        reply::parse(line).outcome,
        ReplyOutcome::Success(_) | ReplyOutcome::Refusal(_)
    )
}

/// A status line of SCIP: two characters and their sum, low six bits plus 0x30; or the echo of a stream of scans.
fn is_laser(line: &[u8]) -> bool {
    match line {
        [a @ b'0'..=b'9', b @ (b'0'..=b'9' | b'A'..=b'Z'), sum] => {
            (a.wrapping_add(*b) & 0x3F) + 0x30 == *sum
        }
        _ => is_scan_echo(line),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of two attempts.
    const SENT: &[u8] = b"   ED FT V   \rED FT V ";

    fn error_of(heard: &[u8]) -> HeadError {
        let mut bytes = HeardBytes::default();
        bytes.note_sent(SENT);
        bytes.note(heard);
        not_a_head(&bytes)
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
    fn the_message_says_how_the_line_began_and_how_much_came() {
        let text = error_of(b"0123456789abcdef\r\n").to_string();
        let beginning = "heard \"0123456789abcdef\\r\\n\" (18 bytes): an unknown device";
        assert!(text.starts_with(beginning), "{text}");
    }
}
