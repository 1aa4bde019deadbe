//! What is on the port in place of a laser, in words.

use std::fmt;

/// What is at the other end of a line on which bytes come, but no reply of a laser.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LaserLine {
    /// The requests themselves come back.
    Loopback,
    /// A modem or radio link in command mode.
    Modem,
    /// The pan-tilt unit.
    PanTilt,
    /// A laser that sends scans and takes no request.
    DeafLaser,
    /// Most bytes are no text: another line rate, or noise.
    NotText,
    /// Text of an unknown device.
    OtherText,
}

impl fmt::Display for LaserLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Loopback => {
                "the requests come back and nothing else does, so the cable or adapter loops its output to its input; \
                 connect the sensor, and check that transmit and receive are not bridged"
            }
            Self::Modem => {
                "a modem or radio link in command mode answers; this is not the sensor's port, or its link must be set up first"
            }
            Self::PanTilt => {
                "the pan-tilt unit answers here; exchange the two ports in the configuration"
            }
            Self::DeafLaser => {
                "a sensor sends scans but takes no request; check the wire that carries requests to it, then power-cycle it"
            }
            Self::NotText => {
                "these bytes are no text, so the line rate is not the sensor's (a URG-04LX starts at 19200), or the line \
                 picks up noise; set the sensor's rate, check cable and ground"
            }
            Self::OtherText => {
                "an unknown device answers; check that this is the sensor's port and that no other program uses it"
            }
        })
    }
}
