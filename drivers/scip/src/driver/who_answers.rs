//! What was heard while connecting, and what it shows: a laser that cannot be used, or something that is none.

use super::error::ScipError;
use super::laser_line::LaserLine;
use heard::{HeardBytes, is_modem_code, is_scan_echo};

/// Why connecting failed, though bytes came that are no laser's.
pub(super) fn not_a_laser(heard: &HeardBytes) -> ScipError {
    ScipError::NotALaser {
        line: line(heard),
        heard: heard.beginning().into(),
        bytes: heard.total(),
    }
}

fn line(heard: &HeardBytes) -> LaserLine {
    let any = |is_such: fn(&[u8]) -> bool| heard.lines().any(|line| is_such(line.trim_ascii()));
    if heard.is_garbage() {
        LaserLine::NotText
    } else if heard.is_loopback() {
        LaserLine::Loopback
    } else if any(is_modem_code) {
        LaserLine::Modem
    } else if any(is_pan_tilt) {
        LaserLine::PanTilt
    } else if any(is_scan_echo) {
        LaserLine::DeafLaser
    } else {
        LaserLine::OtherText
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn line_of(sent: &[u8], heard: &[u8]) -> LaserLine {
        let mut bytes = HeardBytes::default();
        bytes.note_sent(sent);
        bytes.note(heard);
        line(&bytes)
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
    fn the_message_says_how_the_line_began_and_how_much_came() {
        let mut bytes = HeardBytes::default();
        bytes.note(b"0123456789abcdef\n");
        let text = not_a_laser(&bytes).to_string();
        assert!(
            text.starts_with("heard \"0123456789abcdef\\n\" (17 bytes): "),
            "{text}"
        );
    }
}
