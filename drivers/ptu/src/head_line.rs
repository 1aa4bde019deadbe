//! What is on the port in place of a pan-tilt unit, in words.

use std::fmt;

/// What is at the other end of a line on which bytes come, but no version of a pan-tilt unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HeadLine {
    /// The commands themselves come back.
    Loopback,
    /// A modem or radio link in command mode.
    Modem,
    /// The laser.
    Laser,
    /// Replies of a pan-tilt unit, but not to what was asked.
    OtherReplies,
    /// Most bytes are no text: another line rate, or noise.
    NotText,
    /// Text of an unknown device.
    OtherText,
}

impl fmt::Display for HeadLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Loopback => {
                "the commands come back and nothing else does, so the cable or adapter loops its output to its input; connect \
                 and power the unit, and check that transmit and receive are not bridged"
            }
            Self::Modem => {
                "a modem or radio link in command mode answers; this is not the unit's port, or its link must be set up first"
            }
            Self::Laser => "the laser answers here; exchange the two ports in the configuration",
            Self::OtherReplies => {
                "a pan-tilt unit answers, but not what it is asked; stop other programs that use the port, then power-cycle \
                 the unit"
            }
            Self::NotText => {
                "these bytes are no text, so the line rate is not the unit's (9600 after power-up), or the line picks up \
                 noise; set the unit's rate, check cable and ground"
            }
            Self::OtherText => {
                "an unknown device answers; check that this is the unit's port and that no other program uses it"
            }
        })
    }
}
