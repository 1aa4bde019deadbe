//! Errors of a link, by what the user has to do about them.

use std::io;

use crate::holder::holders;

/// An error of a transport. Every variant names its port or address.
#[derive(Debug, thiserror::Error)]
pub enum LinkError {
    /// No device under this name.
    #[error(
        "no device at {name}: check that it is plugged in and powered, and that the configured port is right ({detail})"
    )]
    NotFound {
        /// Path or address.
        name: String,
        /// The system's message.
        detail: String,
    },
    /// A name by identity that several devices match.
    #[error(
        "{name} matches several devices: {matching}; add the serial number of the right one, or name its port by where it is plugged in (/dev/serial/by-path)"
    )]
    Ambiguous {
        /// The name.
        name: String,
        /// The devices that match.
        matching: String,
    },
    /// Another process holds the port.
    #[error(
        "{name} is in use by {by}: stop it, or keep it off this port (the udev rules keep ModemManager off), and try again"
    )]
    Busy {
        /// Path of the port.
        name: String,
        /// The program, if this user may see it.
        by: String,
    },
    /// The port exists, but this user may not open it.
    #[error(
        "no permission for {name}: add the user to the group that owns it (often `dialout`) or install the udev rules"
    )]
    PermissionDenied {
        /// Path of the port.
        name: String,
    },
    /// The system refuses this process the network.
    #[error(
        "no network for {name} ({detail}): the unit of the service closes it; the drop-in laser-tcp.conf opens it for one address"
    )]
    NoNetwork {
        /// Address.
        name: String,
        /// The system's message.
        detail: String,
    },
    /// The device, its adapter or the peer has gone; the link must be opened anew.
    #[error("{name} has gone ({detail}): unplugged, powered off, or closed by the other side")]
    Disconnected {
        /// Path or address.
        name: String,
        /// The system's message.
        detail: String,
    },
    /// A write did not finish in time.
    #[error("{name}: write timed out after {written} of {wanted} bytes")]
    TimedOut {
        /// Path or address.
        name: String,
        /// Bytes written before the timeout.
        written: usize,
        /// Bytes to be written.
        wanted: usize,
    },
    /// A dialogue differed from the replayed transcript.
    #[error("replay of {name}: {fault}")]
    Replay {
        /// Name of the replay.
        name: String,
        /// The difference.
        fault: ReplayFault,
    },
    /// Any other error of the system.
    #[error("{name}: {source}")]
    Io {
        /// Path or address.
        name: String,
        /// The system's error.
        source: io::Error,
    },
}

/// How a dialogue differed from its transcript. Bytes are shown with escapes.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ReplayFault {
    /// The host wrote something else.
    #[error("expected the host to write {expected:?}, got {got:?}")]
    Mismatch {
        /// What the transcript has next.
        expected: String,
        /// What the host wrote.
        got: String,
    },
    /// The host wrote more than the transcript holds.
    #[error("the transcript is over, but the host wrote {got:?}")]
    Extra {
        /// What was written.
        got: String,
    },
    /// The dialogue ended before the transcript.
    #[error(
        "the dialogue ended with {writes_left} bytes not written and {reads_left} bytes not read"
    )]
    Unplayed {
        /// Bytes the host should still have written.
        writes_left: usize,
        /// Bytes the host should still have read.
        reads_left: usize,
    },
}

/// Error numbers of Linux that mean a lost device: EIO, ENXIO, EBADF, ENODEV.
const DISCONNECT_ERRNOS: [i32; 4] = [5, 6, 9, 19];
/// Error numbers of Linux by which a sandbox refuses a connection: EPERM (IPAddressDeny=), EAFNOSUPPORT (RestrictAddressFamilies=).
const NO_NETWORK_ERRNOS: [i32; 2] = [1, 97];

impl LinkError {
    /// Classifies an error of an open or connect.
    pub(crate) fn on_open(name: &str, source: io::Error) -> Self {
        let name = name.to_owned();
        match source.kind() {
            io::ErrorKind::NotFound
            | io::ErrorKind::ConnectionRefused
            | io::ErrorKind::AddrNotAvailable => Self::NotFound {
                name,
                detail: source.to_string(),
            },
            io::ErrorKind::PermissionDenied => Self::PermissionDenied { name },
            io::ErrorKind::ResourceBusy | io::ErrorKind::WouldBlock => Self::busy(&name),
            // A node whose device is gone.
            _ if source
                .raw_os_error()
                .is_some_and(|errno| DISCONNECT_ERRNOS.contains(&errno)) =>
            {
                Self::NotFound {
                    name,
                    detail: source.to_string(),
                }
            }
            _ => Self::Io { name, source },
        }
    }

    /// Classifies an error of a connection by TCP.
    pub(crate) fn on_connect(address: &str, source: io::Error) -> Self {
        match source.raw_os_error() {
            Some(errno) if NO_NETWORK_ERRNOS.contains(&errno) => Self::NoNetwork {
                name: address.to_owned(),
                detail: source.to_string(),
            },
            _ => Self::on_open(address, source),
        }
    }

    /// The port is in use; looks up by whom.
    pub(crate) fn busy(name: &str) -> Self {
        let holders = holders(name);
        let by = if holders.is_empty() {
            format!("another program (`sudo fuser {name}` shows which)")
        } else {
            holders.join(", ")
        };
        Self::Busy {
            name: name.to_owned(),
            by,
        }
    }

    /// Classifies an error of a read or write on an open link.
    pub(crate) fn on_transfer(name: &str, source: io::Error) -> Self {
        let gone = matches!(
            source.kind(),
            io::ErrorKind::BrokenPipe
                | io::ErrorKind::UnexpectedEof
                | io::ErrorKind::NotConnected
                | io::ErrorKind::ConnectionReset
                | io::ErrorKind::ConnectionAborted
        ) || source
            .raw_os_error()
            .is_some_and(|errno| DISCONNECT_ERRNOS.contains(&errno));
        if gone {
            Self::disconnected(name, source.to_string())
        } else {
            Self::Io {
                name: name.to_owned(),
                source,
            }
        }
    }

    pub(crate) fn disconnected(name: &str, detail: impl Into<String>) -> Self {
        Self::Disconnected {
            name: name.to_owned(),
            detail: detail.into(),
        }
    }
}
