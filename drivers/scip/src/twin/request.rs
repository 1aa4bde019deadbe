//! Bytes into request lines, and what a line asks for (protocol sections 3 and 6).

use super::constants::{MAX_LINE, MAX_STRING};
use super::state::Status;

/// Cuts the byte stream into lines of bounded length. LF, CR or both end a line; an empty one is nobody's business.
#[derive(Debug, Clone, Default)]
pub(super) struct LineReader {
    line: Vec<u8>,
    overlong: bool,
}

impl LineReader {
    /// Takes one byte; hands back the request that it ends.
    pub(super) fn push(&mut self, byte: u8) -> Option<Request> {
        if byte != b'\n' && byte != b'\r' {
            if self.line.len() < MAX_LINE {
                self.line.push(byte);
            } else {
                self.overlong = true;
            }
            return None;
        }
        let overlong = std::mem::take(&mut self.overlong);
        let line = std::mem::take(&mut self.line);
        (!line.is_empty()).then(|| Request::new(line, overlong))
    }

    /// Forgets an unfinished line.
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }
}

/// The commands of SCIP2.0 that some URG-04LX knows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Command {
    Version,
    Parameters,
    Status,
    LaserOn,
    Quit,
    Reset,
    Time,
    BitRate,
    MotorSpeed,
    Sensitivity,
    Rehearsal,
    /// `GD`, `GS`.
    Latest,
    /// `MD`, `MS`.
    Stream,
}

/// Name, meaning and exact width of the parameters (section 6).
const COMMANDS: [([u8; 2], Command, usize); 15] = [
    (*b"VV", Command::Version, 0),
    (*b"PP", Command::Parameters, 0),
    (*b"II", Command::Status, 0),
    (*b"BM", Command::LaserOn, 0),
    (*b"QT", Command::Quit, 0),
    (*b"RS", Command::Reset, 0),
    (*b"TM", Command::Time, 1),
    (*b"SS", Command::BitRate, 6),
    (*b"CR", Command::MotorSpeed, 2),
    (*b"HS", Command::Sensitivity, 1),
    (*b"DB", Command::Rehearsal, 2),
    (*b"GD", Command::Latest, 10),
    (*b"GS", Command::Latest, 10),
    (*b"MD", Command::Stream, 13),
    (*b"MS", Command::Stream, 13),
];

/// One request line, as it came.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Request {
    line: Vec<u8>,
    body: usize,
    overlong: bool,
}

impl Request {
    fn new(line: Vec<u8>, overlong: bool) -> Self {
        let body = line
            .iter()
            .position(|byte| *byte == b';')
            .unwrap_or(line.len());
        Self {
            line,
            body,
            overlong,
        }
    }

    /// The whole line, without its terminator: what is echoed.
    pub(super) fn line(&self) -> &[u8] {
        &self.line
    }

    /// Name and parameters.
    pub(super) fn body(&self) -> &[u8] {
        self.line.get(..self.body).unwrap_or_default()
    }

    /// The parameters.
    pub(super) fn parameters(&self) -> &[u8] {
        self.body().get(2..).unwrap_or_default()
    }

    /// From the semicolon on, if there is a string.
    pub(super) fn tail(&self) -> &[u8] {
        self.line.get(self.body..).unwrap_or_default()
    }

    /// Whether values come in two characters (`GS`, `MS`).
    pub(super) fn two_characters(&self) -> bool {
        self.line.get(1) == Some(&b'S')
    }

    fn entry(&self) -> Option<(Command, usize)> {
        let name = self.body().get(..2)?;
        COMMANDS
            .iter()
            .find(|(known, ..)| known == name)
            .map(|(_, command, width)| (*command, *width))
    }

    /// Whether this is one of the time commands, which do not wait for a tick.
    pub(super) fn is_time(&self) -> bool {
        matches!(self.entry(), Some((Command::Time, _)))
    }

    /// Whether a second one of these, sent before the first is answered, is a repeat. `TM0` and `TM1` are different
    /// commands here, and `QT` is always welcome.
    pub(super) fn repeats(&self, earlier: &Request) -> bool {
        match (self.entry(), earlier.entry()) {
            (Some((Command::Quit, _)), _) => false,
            (Some((Command::Time, _)), Some((Command::Time, _))) => self.body() == earlier.body(),
            (Some(_), Some(_)) => self.line.get(..2) == earlier.line.get(..2),
            _ => false,
        }
    }

    /// What is asked for.
    ///
    /// # Errors
    /// The universal statuses, in this order: 0G or 0H for the string, 0B for a line that does not fit, 0E for a name
    /// nobody knows, 0C for too few parameters, 0D for too many.
    pub(super) fn command(&self) -> Result<Command, Status> {
        let string = self.tail().get(1..).unwrap_or_default();
        if string.len() > MAX_STRING {
            return Err(Status::STRING_TOO_LONG);
        }
        if self.overlong {
            return Err(Status::BUFFER_SHORTAGE);
        }
        if !string
            .iter()
            .all(|byte| byte.is_ascii_alphanumeric() || b" ._+@".contains(byte))
        {
            return Err(Status::STRING_CHARACTER);
        }
        let (command, width) = self.entry().ok_or(Status::UNDEFINED)?;
        match self.parameters().len().cmp(&width) {
            std::cmp::Ordering::Less => Err(Status::TOO_FEW_PARAMETERS),
            std::cmp::Ordering::Greater => Err(Status::TOO_MANY_PARAMETERS),
            std::cmp::Ordering::Equal => Ok(command),
        }
    }
}

/// A decimal number of digits only.
pub(super) fn decimal(digits: &[u8]) -> Option<u32> {
    if digits.is_empty() {
        return None;
    }
    digits.iter().try_fold(0u32, |value, digit| {
        let digit = digit.is_ascii_digit().then(|| u32::from(digit - b'0'))?;
        value.checked_mul(10)?.checked_add(digit)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(bytes: &[u8]) -> Vec<Request> {
        let mut reader = LineReader::default();
        bytes.iter().filter_map(|byte| reader.push(*byte)).collect()
    }

    fn command(line: &str) -> Result<Command, Status> {
        lines(format!("{line}\n").as_bytes()).remove(0).command()
    }

    #[test]
    fn any_terminator_ends_a_line_and_bare_ones_are_nothing() {
        let found = lines(b"\n\nVV\nPP\rII\r\n\r\nQT");
        let found: Vec<&[u8]> = found.iter().map(Request::line).collect();
        assert_eq!(found, [&b"VV"[..], b"PP", b"II"]);
    }

    #[test]
    fn universal_statuses() {
        assert_eq!(command("VV"), Ok(Command::Version));
        assert_eq!(command("VV;abc 1._+@"), Ok(Command::Version));
        assert_eq!(command("VV;1234567890123456"), Ok(Command::Version));
        assert_eq!(
            command("VV;12345678901234567"),
            Err(Status::STRING_TOO_LONG)
        );
        assert_eq!(
            command(&format!("VV;{}", "x".repeat(500))),
            Err(Status::STRING_TOO_LONG)
        );
        assert_eq!(command("VV;a-b"), Err(Status::STRING_CHARACTER));
        assert_eq!(command("VV;a;b"), Err(Status::STRING_CHARACTER));
        assert_eq!(command(&"V".repeat(500)), Err(Status::BUFFER_SHORTAGE));
        assert_eq!(command("XY"), Err(Status::UNDEFINED));
        assert_eq!(command("V"), Err(Status::UNDEFINED));
        assert_eq!(command("SCIP2.0"), Err(Status::UNDEFINED));
        assert_eq!(command("RT"), Err(Status::UNDEFINED));
        assert_eq!(command("ME0044072501000"), Err(Status::UNDEFINED));
        assert_eq!(command("GD004407250"), Err(Status::TOO_FEW_PARAMETERS));
        assert_eq!(command("GD00440725011"), Err(Status::TOO_MANY_PARAMETERS));
        assert_eq!(command("BM1"), Err(Status::TOO_MANY_PARAMETERS));
    }

    #[test]
    fn a_long_line_keeps_its_first_bytes_only() {
        let found = lines(format!("{}\nVV\n", "A".repeat(100_000)).as_bytes());
        assert_eq!(found[0].line().len(), MAX_LINE);
        assert_eq!(found[1].command(), Ok(Command::Version));
    }

    #[test]
    fn decimals() {
        assert_eq!(decimal(b"0044"), Some(44));
        assert_eq!(decimal(b"00a4"), None);
        assert_eq!(decimal(b""), None);
        assert_eq!(decimal(b"99999999999"), None);
    }
}
