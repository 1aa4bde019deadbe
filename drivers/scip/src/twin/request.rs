//! Bytes into request lines, and what a line asks for (protocol sections 3 and 6).

use super::constants::{MAX_LINE, MAX_STRING};
use super::profile::Generation;
use super::scanning::Coding;
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

/// The commands of SCIP2.0 and SCIP2.2 that some sensor knows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Command {
    Version,
    Parameters,
    Status,
    LaserOn,
    Quit,
    Reset,
    /// `RT`: reset that leaves motor and bit rate.
    SoftReset,
    Reboot,
    /// `%ST`.
    State,
    /// `%SL`.
    Sleep,
    Time,
    BitRate,
    MotorSpeed,
    Sensitivity,
    Rehearsal,
    /// `GD`, `GS`, `GE`, `HD`, `HE`.
    Latest,
    /// `MD`, `MS`, `ME`, `ND`, `NE`.
    Stream,
}

impl Command {
    /// Asks about the sensor and changes nothing.
    pub(super) fn is_question(self) -> bool {
        matches!(
            self,
            Self::Version | Self::Parameters | Self::Status | Self::State
        )
    }
}

/// Which sensors know a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Since {
    All,
    /// The URG only.
    Urg,
    /// From the UTM on.
    Top,
    Ethernet,
}

impl Since {
    fn includes(self, generation: Generation) -> bool {
        match self {
            Self::All => true,
            Self::Urg => generation == Generation::Urg,
            Self::Top => generation.has_intensity(),
            Self::Ethernet => generation.is_ethernet(),
        }
    }
}

/// Name, meaning, exact width of the parameters, and who knows it (sections 6 and 10).
const COMMANDS: [(&[u8], Command, usize, Since); 25] = [
    (b"VV", Command::Version, 0, Since::All),
    (b"PP", Command::Parameters, 0, Since::All),
    (b"II", Command::Status, 0, Since::All),
    (b"BM", Command::LaserOn, 0, Since::All),
    (b"QT", Command::Quit, 0, Since::All),
    (b"RS", Command::Reset, 0, Since::All),
    (b"TM", Command::Time, 1, Since::All),
    (b"SS", Command::BitRate, 6, Since::All),
    (b"CR", Command::MotorSpeed, 2, Since::All),
    (b"HS", Command::Sensitivity, 1, Since::Urg),
    (b"DB", Command::Rehearsal, 2, Since::Urg),
    (b"GD", Command::Latest, 10, Since::All),
    (b"GS", Command::Latest, 10, Since::All),
    (b"MD", Command::Stream, 13, Since::All),
    (b"MS", Command::Stream, 13, Since::All),
    (b"GE", Command::Latest, 10, Since::Top),
    (b"ME", Command::Stream, 13, Since::Top),
    (b"RT", Command::SoftReset, 0, Since::Top),
    (b"HD", Command::Latest, 10, Since::Ethernet),
    (b"HE", Command::Latest, 10, Since::Ethernet),
    (b"ND", Command::Stream, 13, Since::Ethernet),
    (b"NE", Command::Stream, 13, Since::Ethernet),
    (b"RB", Command::Reboot, 0, Since::Ethernet),
    (b"%ST", Command::State, 0, Since::Ethernet),
    (b"%SL", Command::Sleep, 0, Since::Ethernet),
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

    /// The name: two characters, three of a name that begins with `%`.
    fn name(&self) -> &[u8] {
        let length = if self.body().first() == Some(&b'%') {
            3
        } else {
            2
        };
        self.body().get(..length).unwrap_or_default()
    }

    /// The parameters.
    pub(super) fn parameters(&self) -> &[u8] {
        self.body().get(self.name().len()..).unwrap_or_default()
    }

    /// From the semicolon on, if there is a string.
    pub(super) fn tail(&self) -> &[u8] {
        self.line.get(self.body..).unwrap_or_default()
    }

    /// How a measuring command wants its values.
    pub(super) fn coding(&self) -> Coding {
        Coding::of(self.name())
    }

    fn entry(&self) -> Option<&'static (&'static [u8], Command, usize, Since)> {
        let name = self.name();
        COMMANDS.iter().find(|(known, ..)| *known == name)
    }

    /// Whether it asks for intensity or several echoes, which a sensor without them may not survive (section 10).
    pub(super) fn is_foreign_measurement(&self, generation: Generation) -> bool {
        self.entry().is_some_and(|(_, command, _, since)| {
            matches!(command, Command::Latest | Command::Stream) && !since.includes(generation)
        })
    }

    /// Whether this is one of the time commands, which do not wait for a tick.
    pub(super) fn is_time(&self) -> bool {
        matches!(self.entry(), Some((_, Command::Time, ..)))
    }

    /// Whether a second one of these, sent before the first is answered, is a repeat. `TM0` and `TM1` are different
    /// commands here, and `QT` is always welcome.
    pub(super) fn repeats(&self, earlier: &Request) -> bool {
        match (self.entry(), earlier.entry()) {
            // Twice is how a restart is asked for.
            (Some((_, Command::Quit | Command::Reboot, ..)), _) => false,
            (Some((_, Command::Time, ..)), Some((_, Command::Time, ..))) => {
                self.body() == earlier.body()
            }
            (Some((name, ..)), Some((before, ..))) => name == before,
            _ => false,
        }
    }

    /// What is asked for, of a sensor of this generation.
    ///
    /// # Errors
    /// The universal statuses, in this order: 0G or 0H for the string, 0B for a line that does not fit, 0E for a name
    /// nobody knows, 0C for too few parameters (0H in SCIP2.2), 0D for too many.
    pub(super) fn command(&self, generation: Generation) -> Result<Command, Status> {
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
        let (_, command, width, _) = self
            .entry()
            .filter(|(.., since)| since.includes(generation))
            .ok_or(Status::UNDEFINED)?;
        match self.parameters().len().cmp(width) {
            std::cmp::Ordering::Less if generation.is_ethernet() => Err(Status::TOO_SHORT),
            std::cmp::Ordering::Less => Err(Status::TOO_FEW_PARAMETERS),
            std::cmp::Ordering::Greater => Err(Status::TOO_MANY_PARAMETERS),
            std::cmp::Ordering::Equal => Ok(*command),
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
        command_of(Generation::Urg, line)
    }

    fn command_of(generation: Generation, line: &str) -> Result<Command, Status> {
        lines(format!("{line}\n").as_bytes())
            .remove(0)
            .command(generation)
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
    fn each_generation_knows_its_own() {
        use Generation::{Ethernet, Top, Urg};
        for (line, command, urg, top, ethernet) in [
            ("ME0000108001000", Command::Stream, false, true, true),
            ("GE0000108001", Command::Latest, false, true, true),
            ("RT", Command::SoftReset, false, true, true),
            ("HS1", Command::Sensitivity, true, false, false),
            ("DB03", Command::Rehearsal, true, false, false),
            ("ND0000108001000", Command::Stream, false, false, true),
            ("HE0000108001", Command::Latest, false, false, true),
            ("RB", Command::Reboot, false, false, true),
            ("%ST", Command::State, false, false, true),
            ("%SL", Command::Sleep, false, false, true),
        ] {
            for (generation, knows) in [(Urg, urg), (Top, top), (Ethernet, ethernet)] {
                let expected = if knows {
                    Ok(command)
                } else {
                    Err(Status::UNDEFINED)
                };
                assert_eq!(
                    command_of(generation, line),
                    expected,
                    "{line} {generation:?}"
                );
            }
        }
        assert_eq!(command_of(Ethernet, "%S"), Err(Status::UNDEFINED));
        assert_eq!(command_of(Ethernet, "GD000"), Err(Status::TOO_SHORT));
    }

    #[test]
    fn a_long_line_keeps_its_first_bytes_only() {
        let found = lines(format!("{}\nVV\n", "A".repeat(100_000)).as_bytes());
        assert_eq!(found[0].line().len(), MAX_LINE);
        assert_eq!(found[1].command(Generation::Urg), Ok(Command::Version));
    }

    #[test]
    fn decimals() {
        assert_eq!(decimal(b"0044"), Some(44));
        assert_eq!(decimal(b"00a4"), None);
        assert_eq!(decimal(b""), None);
        assert_eq!(decimal(b"99999999999"), None);
    }
}
