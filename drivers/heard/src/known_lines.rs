//! Lines that say what a device is, whichever was expected.

/// Whether a line is a result code of the AT command set, or its commands' own echo.
#[must_use]
pub fn is_modem_code(line: &[u8]) -> bool {
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

/// Whether a line is the echo of `MD`, `MS` or `ME` that a streaming laser sends over each scan (docs/protocols/scip2.md section
/// 5).
#[must_use]
pub fn is_scan_echo(line: &[u8]) -> bool {
    matches!(line, [b'M', b'D' | b'S' | b'E', digits @ ..]
        if digits.len() == 13 && digits.iter().all(u8::is_ascii_digit))
}

#[cfg(test)]
mod tests {
    use super::{is_modem_code, is_scan_echo};

    #[test]
    fn modem_codes_are_whole_lines() {
        for line in ["OK", "ERROR", "NO CARRIER", "CONNECT 9600", "AT+GMI"] {
            assert!(is_modem_code(line.as_bytes()), "{line}");
        }
        for line in ["OKAY", "00P", "CONNECTED", "* ERROR", ""] {
            assert!(!is_modem_code(line.as_bytes()), "{line}");
        }
    }

    #[test]
    fn echoes_of_scans_have_thirteen_digits() {
        for line in ["MD0044072501000", "MS0044072501099", "ME0000076803000"] {
            assert!(is_scan_echo(line.as_bytes()), "{line}");
        }
        for line in [
            "MD004407250100",
            "MD00440725010001",
            "MX0044072501000",
            "MD004407250100a",
        ] {
            assert!(!is_scan_echo(line.as_bytes()), "{line}");
        }
    }
}
