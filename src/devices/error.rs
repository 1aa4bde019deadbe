//! What can go wrong with the devices. Each is one line: which device, which port, what happened, what to do.

use std::fmt;

/// One of the two devices.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Device {
    /// The laser range finder.
    Laser,
    /// The pan-tilt head.
    Head,
}

impl fmt::Display for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Laser => "laser",
            Self::Head => "pan-tilt",
        })
    }
}

impl Device {
    /// The configuration key of the unit that it has to be.
    pub const fn unit_key(self) -> &'static str {
        match self {
            Self::Laser => "laser.serial",
            Self::Head => "ptu.version",
        }
    }

    /// The configuration key of its port.
    pub const fn port_key(self) -> &'static str {
        match self {
            Self::Laser => "laser.port",
            Self::Head => "ptu.port",
        }
    }
}

/// A device that does not do its part.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DeviceError {
    /// The port cannot be opened, or its transport broke.
    #[error("{device} ({key}): {source}", key = .device.port_key())]
    Port {
        /// Which device.
        device: Device,
        /// Why, with the port's name and what to do.
        source: PortError,
    },
    /// Another unit hangs there than the one that the configuration names.
    #[error(
        "{device} on {port} is {got}, but {key} asks for {expected}: plug in the right one or change the configuration"
    )]
    OtherUnit {
        /// Which device.
        device: Device,
        /// Its port.
        port: String,
        /// The configuration key that names the unit.
        key: &'static str,
        /// The unit asked for.
        expected: String,
        /// What it says of itself.
        got: String,
    },
    /// Nothing came back at any rate.
    #[error("{device} on {port} is silent: check its power and cable, and that {key} is its port ({detail})", key = .device.port_key())]
    Silent {
        /// Which device.
        device: Device,
        /// Its port.
        port: String,
        /// What the driver tried.
        detail: String,
    },
    /// Something answers, but not as this device would.
    #[error("{port} answers, but not as the {device} would: are {key} and the other port exchanged, or the baud rate wrong? ({detail})", key = .device.port_key())]
    WrongDevice {
        /// Which device.
        device: Device,
        /// Its port.
        port: String,
        /// What the driver heard.
        detail: String,
    },
    /// The dialogue broke, or the device says that it is broken.
    #[error(
        "{device} on {port}: {detail}; it is being connected anew, power-cycle it if this repeats"
    )]
    Fault {
        /// Which device.
        device: Device,
        /// Its port.
        port: String,
        /// The driver's words.
        detail: String,
    },
    /// The device is away and did not come back in time.
    #[error("{device} on {port} is not connected: {detail}")]
    NotConnected {
        /// Which device.
        device: Device,
        /// Its port.
        port: String,
        /// The last thing known about it.
        detail: String,
    },
    /// The device took too long.
    #[error(
        "{device} on {port} did not finish {what} in {limit_s} s: power-cycle it if this repeats"
    )]
    Overdue {
        /// Which device.
        device: Device,
        /// Its port.
        port: String,
        /// What was waited for.
        what: &'static str,
        /// How long, seconds.
        limit_s: u64,
    },
    /// The head's position is not to be trusted; nothing was measured.
    #[error(
        "pan-tilt on {port}: its position is not trusted ({detail}); home it before the next sweep"
    )]
    PositionLost {
        /// The head's port.
        port: String,
        /// Why.
        detail: String,
    },
    /// An axis did not follow its command.
    #[error(
        "pan-tilt on {port}: {axis} stopped at {at_steps}, on its way to {target_steps}: is it blocked, or overloaded? Home it before the next sweep"
    )]
    Stalled {
        /// The head's port.
        port: String,
        /// `pan` or `tilt`.
        axis: &'static str,
        /// Where it was last, counts.
        at_steps: i32,
        /// Where it should have gone, counts.
        target_steps: i32,
    },
    /// The plan asks for angles the head cannot reach.
    #[error(
        "pan-tilt on {port} reaches {axis} {low_deg:.1} to {high_deg:.1} deg, {wanted} asked for: change {key}"
    )]
    OutOfReach {
        /// The head's port.
        port: String,
        /// `pan` or `tilt`.
        axis: &'static str,
        /// Least angle within reach, degrees.
        low_deg: f64,
        /// Greatest angle within reach, degrees.
        high_deg: f64,
        /// What was asked for.
        wanted: String,
        /// The configuration keys to change.
        key: &'static str,
    },
    /// The laser's timer went back to zero or jumped in the middle of a sweep: its instants say nothing any more.
    #[error(
        "laser on {port}: its timer {what} in the middle of the sweep, the sweep is void; take another"
    )]
    TimerLost {
        /// The laser's port.
        port: String,
        /// What happened to the timer.
        what: String,
    },
    /// A device refused a command.
    #[error("{device} on {port} refused {command}: {detail}")]
    Refused {
        /// Which device.
        device: Device,
        /// Its port.
        port: String,
        /// What was asked.
        command: String,
        /// Its words.
        detail: String,
    },
    /// The caller cancelled; the laser is off and the head stands.
    #[error("cancelled; the laser is off and the head stands")]
    Cancelled,
    /// The system gave no thread.
    #[error("no thread for the {device}: {detail}")]
    NoThread {
        /// Which device.
        device: Device,
        /// The system's words.
        detail: String,
    },
}

impl DeviceError {
    /// Whether the device is just not there: looking again soon costs nothing and moves nothing.
    pub const fn is_absence(&self) -> bool {
        matches!(self, Self::Port { .. })
    }
}

/// Why a port cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PortError {
    /// Nothing is there.
    #[error("{0}")]
    NoSuchPort(String),
    /// Several devices go by that name.
    #[error("{0}")]
    Several(String),
    /// Somebody else has it.
    #[error("{0}")]
    Busy(String),
    /// This user may not.
    #[error("{0}")]
    NotPermitted(String),
    /// It went away.
    #[error("{0}")]
    Gone(String),
    /// Anything else.
    #[error("{0}")]
    Other(String),
}

impl From<link::LinkError> for PortError {
    fn from(error: link::LinkError) -> Self {
        use link::LinkError as E;
        let text = error.to_string();
        match error {
            E::NotFound { .. } => Self::NoSuchPort(text),
            E::Several { .. } => Self::Several(text),
            E::Busy { .. } => Self::Busy(text),
            E::PermissionDenied { .. } => Self::NotPermitted(text),
            E::Disconnected { .. } | E::TimedOut { .. } => Self::Gone(text),
            E::Replay { .. } | E::Io { .. } => Self::Other(text),
        }
    }
}
