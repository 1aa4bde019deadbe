//! Cuts bytes into request lines and reads them (scip2 sections 3 and 6).

use super::constants::{MAX_LINE, MAX_STRING};
use super::profile::LaserGeneration;
use super::status::ReplyStatus;
use super::window::ReplyCoding;

/// Cuts the byte stream into lines of bounded length. LF, CR or both end a line; empty lines are skipped.
#[derive(Debug, Clone, Default)]
pub(super) struct RequestReader {
    line: Vec<u8>,
    overlong: bool,
}

impl RequestReader {
    /// Takes one byte; returns the request that it ends.
    pub(super) fn push(&mut self, byte: u8) -> Option<RequestLine> {
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
        (!line.is_empty()).then(|| RequestLine::new(line, overlong))
    }

    /// Drops an unfinished line.
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }
}

/// The commands that at least one of the emulated models knows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum EmulatedCommand {
    Version,
    Parameters,
    Info,
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
    SimulateFailure,
    /// `GD`, `GS`, `GE`, `HD`, `HE`.
    Latest,
    /// `MD`, `MS`, `ME`, `ND`, `NE`.
    Stream,
}

impl EmulatedCommand {
    /// Whether it changes nothing.
    pub(super) fn is_query(self) -> bool {
        matches!(
            self,
            Self::Version | Self::Parameters | Self::Info | Self::State
        )
    }
}

/// Which models know a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Availability {
    All,
    Urg,
    /// UTM and Ethernet models.
    TopUrg,
    Ethernet,
}

impl Availability {
    fn includes(self, generation: LaserGeneration) -> bool {
        match self {
            Self::All => true,
            Self::Urg => generation == LaserGeneration::Urg,
            Self::TopUrg => generation.has_intensity(),
            Self::Ethernet => generation.is_ethernet(),
        }
    }
}

/// Name, command, exact width of the parameters, models (scip2 sections 6 and 10).
const COMMANDS: [(&[u8], EmulatedCommand, usize, Availability); 25] = [
    (b"VV", EmulatedCommand::Version, 0, Availability::All),
    (b"PP", EmulatedCommand::Parameters, 0, Availability::All),
    (b"II", EmulatedCommand::Info, 0, Availability::All),
    (b"BM", EmulatedCommand::LaserOn, 0, Availability::All),
    (b"QT", EmulatedCommand::Quit, 0, Availability::All),
    (b"RS", EmulatedCommand::Reset, 0, Availability::All),
    (b"TM", EmulatedCommand::Time, 1, Availability::All),
    (b"SS", EmulatedCommand::BitRate, 6, Availability::All),
    (b"CR", EmulatedCommand::MotorSpeed, 2, Availability::All),
    (b"HS", EmulatedCommand::Sensitivity, 1, Availability::Urg),
    (
        b"DB",
        EmulatedCommand::SimulateFailure,
        2,
        Availability::Urg,
    ),
    (b"GD", EmulatedCommand::Latest, 10, Availability::All),
    (b"GS", EmulatedCommand::Latest, 10, Availability::All),
    (b"MD", EmulatedCommand::Stream, 13, Availability::All),
    (b"MS", EmulatedCommand::Stream, 13, Availability::All),
    (b"GE", EmulatedCommand::Latest, 10, Availability::TopUrg),
    (b"ME", EmulatedCommand::Stream, 13, Availability::TopUrg),
    (b"RT", EmulatedCommand::SoftReset, 0, Availability::TopUrg),
    (b"HD", EmulatedCommand::Latest, 10, Availability::Ethernet),
    (b"HE", EmulatedCommand::Latest, 10, Availability::Ethernet),
    (b"ND", EmulatedCommand::Stream, 13, Availability::Ethernet),
    (b"NE", EmulatedCommand::Stream, 13, Availability::Ethernet),
    (b"RB", EmulatedCommand::Reboot, 0, Availability::Ethernet),
    (b"%ST", EmulatedCommand::State, 0, Availability::Ethernet),
    (b"%SL", EmulatedCommand::Sleep, 0, Availability::Ethernet),
];

/// One request line as received.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct RequestLine {
    line: Vec<u8>,
    body: usize,
    overlong: bool,
}

impl RequestLine {
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

    /// The line without its terminator, as echoed.
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

    pub(super) fn coding(&self) -> ReplyCoding {
        ReplyCoding::from_command_name(self.name())
    }

    fn entry(&self) -> Option<&'static (&'static [u8], EmulatedCommand, usize, Availability)> {
        let name = self.name();
        COMMANDS.iter().find(|(known, ..)| *known == name)
    }

    /// Whether it asks for intensity or multiple echoes that the model lacks (scip2 section 10).
    pub(super) fn is_unsupported_measurement(&self, generation: LaserGeneration) -> bool {
        self.entry().is_some_and(|(_, command, _, availability)| {
            matches!(command, EmulatedCommand::Latest | EmulatedCommand::Stream)
                && !availability.includes(generation)
        })
    }

    /// `TM` commands do not wait for a tick.
    pub(super) fn is_time(&self) -> bool {
        matches!(self.entry(), Some((_, EmulatedCommand::Time, ..)))
    }

    /// Whether it repeats an `earlier` request that is not answered yet. `TM0` and `TM1` count as different commands, `QT`
    /// never as a repeat.
    pub(super) fn repeats(&self, earlier: &RequestLine) -> bool {
        match (self.entry(), earlier.entry()) {
            // A restart takes two `RB`.
            (Some((_, EmulatedCommand::Quit | EmulatedCommand::Reboot, ..)), _) => false,
            (Some((_, EmulatedCommand::Time, ..)), Some((_, EmulatedCommand::Time, ..))) => {
                self.body() == earlier.body()
            }
            (Some((name, ..)), Some((before, ..))) => name == before,
            _ => false,
        }
    }

    /// The command, for a model of this generation.
    ///
    /// # Errors
    /// The universal statuses, in this order: 0G or 0H for the string, 0B for a line that does not fit, 0E for an
    /// unknown name, 0C for too few parameters (0H in SCIP2.2), 0D for too many.
    pub(super) fn command(
        &self,
        generation: LaserGeneration,
    ) -> Result<EmulatedCommand, ReplyStatus> {
        let string = self.tail().get(1..).unwrap_or_default();
        if string.len() > MAX_STRING {
            return Err(ReplyStatus::STRING_TOO_LONG);
        }
        if self.overlong {
            return Err(ReplyStatus::BUFFER_SHORTAGE);
        }
        if !string
            .iter()
            .all(|byte| byte.is_ascii_alphanumeric() || b" ._+@".contains(byte))
        {
            return Err(ReplyStatus::STRING_CHARACTER);
        }
        let (_, command, width, _) = self
            .entry()
            .filter(|(.., availability)| availability.includes(generation))
            .ok_or(ReplyStatus::UNDEFINED)?;
        match self.parameters().len().cmp(width) {
            std::cmp::Ordering::Less if generation.is_ethernet() => Err(ReplyStatus::TOO_SHORT),
            std::cmp::Ordering::Less => Err(ReplyStatus::TOO_FEW_PARAMETERS),
            std::cmp::Ordering::Greater => Err(ReplyStatus::TOO_MANY_PARAMETERS),
            std::cmp::Ordering::Equal => Ok(*command),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(bytes: &[u8]) -> Vec<RequestLine> {
        let mut reader = RequestReader::default();
        bytes.iter().filter_map(|byte| reader.push(*byte)).collect()
    }

    fn command(line: &str) -> Result<EmulatedCommand, ReplyStatus> {
        command_of(LaserGeneration::Urg, line)
    }

    fn command_of(generation: LaserGeneration, line: &str) -> Result<EmulatedCommand, ReplyStatus> {
        lines(format!("{line}\n").as_bytes())
            .remove(0)
            .command(generation)
    }

    #[test]
    fn any_terminator_ends_a_line_and_bare_ones_are_nothing() {
        let found = lines(b"\n\nVV\nPP\rII\r\n\r\nQT");
        let found: Vec<&[u8]> = found.iter().map(RequestLine::line).collect();
        assert_eq!(found, [&b"VV"[..], b"PP", b"II"]);
    }

    #[test]
    fn universal_statuses() {
        assert_eq!(command("VV"), Ok(EmulatedCommand::Version));
        assert_eq!(command("VV;abc 1._+@"), Ok(EmulatedCommand::Version));
        assert_eq!(command("VV;1234567890123456"), Ok(EmulatedCommand::Version));
        assert_eq!(
            command("VV;12345678901234567"),
            Err(ReplyStatus::STRING_TOO_LONG)
        );
        assert_eq!(
            command(&format!("VV;{}", "x".repeat(500))),
            Err(ReplyStatus::STRING_TOO_LONG)
        );
        assert_eq!(command("VV;a-b"), Err(ReplyStatus::STRING_CHARACTER));
        assert_eq!(command("VV;a;b"), Err(ReplyStatus::STRING_CHARACTER));
        assert_eq!(command(&"V".repeat(500)), Err(ReplyStatus::BUFFER_SHORTAGE));
        assert_eq!(command("XY"), Err(ReplyStatus::UNDEFINED));
        assert_eq!(command("V"), Err(ReplyStatus::UNDEFINED));
        assert_eq!(command("SCIP2.0"), Err(ReplyStatus::UNDEFINED));
        assert_eq!(command("RT"), Err(ReplyStatus::UNDEFINED));
        assert_eq!(command("ME0044072501000"), Err(ReplyStatus::UNDEFINED));
        assert_eq!(command("GD004407250"), Err(ReplyStatus::TOO_FEW_PARAMETERS));
        assert_eq!(
            command("GD00440725011"),
            Err(ReplyStatus::TOO_MANY_PARAMETERS)
        );
        assert_eq!(command("BM1"), Err(ReplyStatus::TOO_MANY_PARAMETERS));
    }

    #[test]
    fn each_generation_knows_its_own() {
        use LaserGeneration::{Ethernet, TopUrg, Urg};
        for (line, command, urg, top, ethernet) in [
            (
                "ME0000108001000",
                EmulatedCommand::Stream,
                false,
                true,
                true,
            ),
            ("GE0000108001", EmulatedCommand::Latest, false, true, true),
            ("RT", EmulatedCommand::SoftReset, false, true, true),
            ("HS1", EmulatedCommand::Sensitivity, true, false, false),
            ("DB03", EmulatedCommand::SimulateFailure, true, false, false),
            (
                "ND0000108001000",
                EmulatedCommand::Stream,
                false,
                false,
                true,
            ),
            ("HE0000108001", EmulatedCommand::Latest, false, false, true),
            ("RB", EmulatedCommand::Reboot, false, false, true),
            ("%ST", EmulatedCommand::State, false, false, true),
            ("%SL", EmulatedCommand::Sleep, false, false, true),
        ] {
            for (generation, knows) in [(Urg, urg), (TopUrg, top), (Ethernet, ethernet)] {
                let expected = if knows {
                    Ok(command)
                } else {
                    Err(ReplyStatus::UNDEFINED)
                };
                assert_eq!(
                    command_of(generation, line),
                    expected,
                    "{line} {generation:?}"
                );
            }
        }
        assert_eq!(command_of(Ethernet, "%S"), Err(ReplyStatus::UNDEFINED));
        assert_eq!(command_of(Ethernet, "GD000"), Err(ReplyStatus::TOO_SHORT));
    }

    #[test]
    fn a_long_line_keeps_its_first_bytes_only() {
        let found = lines(format!("{}\nVV\n", "A".repeat(100_000)).as_bytes());
        assert_eq!(found[0].line().len(), MAX_LINE);
        assert_eq!(
            found[1].command(LaserGeneration::Urg),
            Ok(EmulatedCommand::Version)
        );
    }
}
