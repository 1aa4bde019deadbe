//! Errors of the devices. Each text is one line: device, port, what happened, what to do.

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
    /// Section of its configuration keys, and its name in the event log.
    pub const fn section(self) -> &'static str {
        match self {
            Self::Laser => "laser",
            Self::Head => "ptu",
        }
    }

    /// Configuration key of the required unit.
    pub(super) const fn unit_key(self) -> &'static str {
        match self {
            Self::Laser => "laser.serial",
            Self::Head => "ptu.version",
        }
    }

    /// Configuration key of its port.
    pub const fn port_key(self) -> &'static str {
        match self {
            Self::Laser => "laser.port",
            Self::Head => "ptu.port",
        }
    }
}

/// A failure of a device.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DeviceError {
    /// The port cannot be opened, or its transport failed.
    #[error("{device} ({setting}): {source}")]
    Port {
        /// The failed device.
        device: Device,
        /// The key of its port, and where it was set.
        setting: String,
        /// With the port's name and what to do.
        source: PortError,
    },
    /// Another unit is connected than the configuration requires.
    #[error(
        "{device} on {port} is {got}, but {expected} is required ({setting}): plug in the right one or change the configuration"
    )]
    OtherUnit {
        /// The failed device.
        device: Device,
        /// Name of its port.
        port: String,
        /// The key of the required unit, and where it was set.
        setting: String,
        /// Required unit.
        expected: String,
        /// Unit found.
        got: String,
    },
    /// No reply at any line rate.
    #[error(
        "{device} on {port} is silent: check its power and cable, and that this is its port ({setting}; {detail})"
    )]
    Silent {
        /// The failed device.
        device: Device,
        /// Name of its port.
        port: String,
        /// The key of its port, and where it was set.
        setting: String,
        /// The driver's error.
        detail: String,
    },
    /// Something answers that cannot be used: another device, another line rate, a unit that is too old.
    #[error("{device} on {port} ({setting}): {detail}")]
    WrongDevice {
        /// The failed device.
        device: Device,
        /// Name of its port.
        port: String,
        /// The key of its port, and where it was set.
        setting: String,
        /// The driver's error: what was heard, what it is, what to do.
        detail: String,
        /// It is text, which says more than the garbage of a wrong line rate.
        readable: bool,
    },
    /// Communication failed, or the device reports a fault.
    #[error("{device} on {port}: {detail}; reconnecting, power-cycle it if this repeats")]
    Fault {
        /// The failed device.
        device: Device,
        /// Name of its port.
        port: String,
        /// The driver's error.
        detail: String,
    },
    /// The device did not reconnect in time.
    #[error("{device} on {port} is not connected: {detail}")]
    NotConnected {
        /// The failed device.
        device: Device,
        /// Name of its port.
        port: String,
        /// Its last state.
        detail: String,
    },
    /// The device timed out.
    #[error(
        "{device} on {port} did not finish {what} in {limit_s} s: power-cycle it if this repeats"
    )]
    Overdue {
        /// The failed device.
        device: Device,
        /// Name of its port.
        port: String,
        /// Operation.
        what: &'static str,
        /// Time limit, seconds.
        limit_s: u64,
    },
    /// The head's position is not trusted; there is no sweep.
    #[error(
        "pan-tilt on {port}: its position is not trusted ({detail}); home it before the next sweep"
    )]
    PositionLost {
        /// Name of its port.
        port: String,
        /// Reason.
        detail: String,
    },
    /// An axis stopped before its target.
    #[error(
        "pan-tilt on {port}: {axis} stopped at {at_steps} on its way to {target_steps}: is it blocked or overloaded? Home it before the next sweep"
    )]
    Stalled {
        /// Name of its port.
        port: String,
        /// `pan` or `tilt`.
        axis: &'static str,
        /// Last position, counts.
        at_steps: i32,
        /// Target, counts.
        target_steps: i32,
    },
    /// The request has angles out of reach.
    #[error(
        "pan-tilt on {port} reaches {axis} {low_deg:.1} to {high_deg:.1} deg, not {wanted}: change it ({setting})"
    )]
    OutOfReach {
        /// Name of its port.
        port: String,
        /// `pan` or `tilt`.
        axis: &'static str,
        /// Smallest angle within reach, degrees.
        low_deg: f64,
        /// Largest angle within reach, degrees.
        high_deg: f64,
        /// Requested angles.
        wanted: String,
        /// The keys to change, and where they were set.
        setting: String,
    },
    /// The laser's timer was reset or jumped during a sweep: its timestamps are useless.
    #[error("laser on {port}: its timer {what} during the sweep, which is void; take another")]
    TimerLost {
        /// Name of its port.
        port: String,
        /// What happened to the timer.
        what: String,
    },
    /// A device refused a command.
    #[error("{device} on {port} refused {command}: {detail}")]
    Refused {
        /// The failed device.
        device: Device,
        /// Name of its port.
        port: String,
        /// The command.
        command: String,
        /// Its reply.
        detail: String,
    },
    /// The caller cancelled; the laser is off and the head has stopped.
    #[error("cancelled; the laser is off and the head has stopped")]
    Cancelled,
    /// The operating system refused a thread.
    #[error("cannot start a thread for the {device}: {detail}")]
    NoThread {
        /// The failed device.
        device: Device,
        /// System error.
        detail: String,
    },
}

impl DeviceError {
    /// Whether the device is just absent: trying again soon is cheap and moves nothing.
    pub const fn is_absence(&self) -> bool {
        matches!(self, Self::Port { .. })
    }

    /// How much it says about the device; silence and garbage may just be a wrong line rate.
    pub(super) fn specificity(&self) -> u8 {
        match self {
            Self::OtherUnit { .. } => 5,
            Self::Port { .. } => 4,
            Self::Silent { .. } => 0,
            Self::WrongDevice {
                readable: false, ..
            } => 1,
            Self::WrongDevice { readable: true, .. } => 2,
            _ => 3,
        }
    }

    /// Why the head may be elsewhere than at its counts after this error of a move. Losses of the port and notices of the head
    /// say so themselves.
    pub(super) fn contradicts_position(&self) -> Option<&'static str> {
        match self {
            Self::Stalled { .. } => Some("an axis stalled"),
            Self::Overdue {
                device: Device::Head,
                ..
            } => Some("a move did not end"),
            Self::Refused {
                device: Device::Head,
                ..
            } => Some("it refused a command"),
            _ => None,
        }
    }
}

/// Why a port cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PortError {
    /// No such port.
    #[error("{0}")]
    NoSuchPort(String),
    /// Several ports match the name.
    #[error("{0}")]
    Several(String),
    /// Another program has it open.
    #[error("{0}")]
    Busy(String),
    /// This user may not open it.
    #[error("{0}")]
    NotPermitted(String),
    /// It was unplugged.
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
            E::Ambiguous { .. } => Self::Several(text),
            E::Busy { .. } => Self::Busy(text),
            E::PermissionDenied { .. } | E::NoNetwork { .. } => Self::NotPermitted(text),
            E::Disconnected { .. } | E::TimedOut { .. } => Self::Gone(text),
            E::Replay { .. } | E::Io { .. } => Self::Other(text),
        }
    }
}
