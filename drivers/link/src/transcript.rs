//! Transcripts: a dialogue as text, one line per chunk of bytes.
//!
//! ```text
//! # PTU-D46 on /dev/ttyUSB0
//! 0.000000 > "PP "
//! 0.013250 < "* -1234\r\n"
//! ```
//! Time in seconds since the start; `>` from host to device, `<` back; bytes in quotes, with `\r \n \t \\ \"`, and `\xNN` for what is
//! not printable. Lines that start with `#` are comments; empty lines are ignored.

use std::fmt::{self, Write as _};
use std::str::FromStr;
use std::time::Duration;

/// Direction of bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// From the host to the device, `>`.
    ToDevice,
    /// From the device to the host, `<`.
    ToHost,
}

/// One line of a transcript.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum TranscriptEntry {
    /// Bytes on the line.
    Bytes {
        /// Time since the start, written in whole microseconds.
        at: Duration,
        /// Their direction.
        direction: Direction,
        /// As sent.
        bytes: Vec<u8>,
    },
    /// A comment, one line.
    Comment(String),
}

/// A recorded dialogue.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Transcript {
    /// The lines in order.
    pub entries: Vec<TranscriptEntry>,
}

/// A line that is not valid in a transcript.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("transcript line {line}: expected {expected}, got {got:?}")]
pub struct TranscriptError {
    /// Line number, from 1.
    pub line: usize,
    /// What is valid there.
    pub expected: &'static str,
    /// The line.
    pub got: String,
}

impl fmt::Display for TranscriptEntry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Comment(text) => {
                // Each line of a comment gets its own `#`.
                let mut lines = text.lines();
                write!(f, "# {}", lines.next().unwrap_or(""))?;
                lines.try_for_each(|line| write!(f, "\n# {line}"))
            }
            Self::Bytes {
                at,
                direction,
                bytes,
            } => {
                let arrow = if *direction == Direction::ToDevice {
                    '>'
                } else {
                    '<'
                };
                write!(f, "{}.{:06} {arrow} \"", at.as_secs(), at.subsec_micros())?;
                bytes.iter().try_for_each(|byte| escape(*byte, f))?;
                f.write_char('"')
            }
        }
    }
}

fn escape(byte: u8, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    match byte {
        b'\r' => f.write_str("\\r"),
        b'\n' => f.write_str("\\n"),
        b'\t' => f.write_str("\\t"),
        b'\\' => f.write_str("\\\\"),
        b'"' => f.write_str("\\\""),
        0x20..=0x7e => f.write_char(char::from(byte)),
        _ => write!(f, "\\x{byte:02x}"),
    }
}

fn unescape(text: &str) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.bytes();
    while let Some(byte) = rest.next() {
        bytes.push(match byte {
            b'"' => return None,
            b'\\' => match rest.next()? {
                b'r' => b'\r',
                b'n' => b'\n',
                b't' => b'\t',
                b'\\' => b'\\',
                b'"' => b'"',
                b'x' => {
                    let high = char::from(rest.next()?).to_digit(16)?;
                    let low = char::from(rest.next()?).to_digit(16)?;
                    u8::try_from(high * 16 + low).ok()?
                }
                _ => return None,
            },
            0x20..=0x7e => byte,
            _ => return None,
        });
    }
    Some(bytes)
}

fn parse_time(text: &str) -> Option<Duration> {
    let (seconds, micros) = text.split_once('.')?;
    if micros.len() != 6 || !micros.bytes().all(|b| b.is_ascii_digit()) {
        return None;
    }
    Some(Duration::from_secs(seconds.parse().ok()?) + Duration::from_micros(micros.parse().ok()?))
}

fn parse_entry(line: &str) -> Result<TranscriptEntry, &'static str> {
    if let Some(text) = line.strip_prefix('#') {
        return Ok(TranscriptEntry::Comment(
            text.strip_prefix(' ').unwrap_or(text).to_owned(),
        ));
    }
    let (time, rest) = line
        .split_once(' ')
        .ok_or("a time, a direction and quoted bytes")?;
    let at = parse_time(time).ok_or("seconds with six decimals")?;
    let (direction, quoted) = match rest.split_once(' ') {
        Some((">", quoted)) => (Direction::ToDevice, quoted),
        Some(("<", quoted)) => (Direction::ToHost, quoted),
        _ => return Err("`>` or `<` after the time"),
    };
    let inner = quoted
        .strip_prefix('"')
        .and_then(|q| q.strip_suffix('"'))
        .ok_or("bytes between quotes")?;
    let bytes =
        unescape(inner).ok_or("printable bytes and the escapes \\r \\n \\t \\\\ \\\" \\xNN")?;
    Ok(TranscriptEntry::Bytes {
        at,
        direction,
        bytes,
    })
}

impl fmt::Display for Transcript {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.entries
            .iter()
            .try_for_each(|entry| writeln!(f, "{entry}"))
    }
}

impl FromStr for Transcript {
    type Err = TranscriptError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let lines = text
            .lines()
            .enumerate()
            .filter(|(_, line)| !line.trim().is_empty());
        let entries = lines
            .map(|(index, line)| {
                parse_entry(line).map_err(|expected| TranscriptError {
                    line: index + 1,
                    expected,
                    got: line.to_owned(),
                })
            })
            .collect::<Result<_, _>>()?;
        Ok(Self { entries })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::{Just, Strategy, any, prop_oneof, proptest};

    fn entry() -> impl Strategy<Value = TranscriptEntry> {
        let direction = prop_oneof![Just(Direction::ToDevice), Just(Direction::ToHost)];
        let bytes = (
            0u64..1 << 50,
            direction,
            proptest::collection::vec(any::<u8>(), 0..80),
        )
            .prop_map(|(us, direction, bytes)| TranscriptEntry::Bytes {
                at: Duration::from_micros(us),
                direction,
                bytes,
            });
        prop_oneof![bytes, "[ -~]{0,40}".prop_map(TranscriptEntry::Comment)]
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_back(entries in proptest::collection::vec(entry(), 0..20)) {
            let transcript = Transcript { entries };
            proptest::prop_assert_eq!(transcript.to_string().parse::<Transcript>(), Ok(transcript));
        }

        #[test]
        fn no_text_makes_it_panic(text in "\\PC{0,200}") {
            let _ = text.parse::<Transcript>();
        }
    }

    #[test]
    fn the_form_is_as_documented() {
        let text = "# PTU-D46\n0.000000 > \"PP \"\n0.013250 < \"* -1234\\r\\n\"\n1.000001 < \"\\xff\\\"\\\\\"\n";
        let transcript: Transcript = text.parse().expect("a transcript");
        assert_eq!(transcript.to_string(), text);
        assert_eq!(transcript.entries.len(), 4);
        assert!(
            matches!(&transcript.entries[3], TranscriptEntry::Bytes { bytes, .. } if bytes == b"\xff\"\\")
        );
    }

    #[test]
    fn faults_name_their_line() {
        let error = "# ok\n\n0.5 > \"x\"\n"
            .parse::<Transcript>()
            .expect_err("five decimals are missing");
        assert_eq!(error.line, 3);
        for bad in [
            "0.000000 ? \"x\"",
            "0.000000 > x",
            "0.000000 > \"\\q\"",
            "0.000000 > \"\\x4\"",
            "zero",
        ] {
            assert!(bad.parse::<Transcript>().is_err(), "{bad}");
        }
    }
}
