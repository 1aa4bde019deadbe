//! What can go wrong on a link, by what the reader has to do about it.

use std::io;

use crate::holder::holders;
use crate::replay::ReplayFault;

/// A fault of a transport. Every variant names the port or address it happened on.
#[derive(Debug, thiserror::Error)]
pub enum LinkError {
    /// Nothing is there under this name.
    #[error(
        "no device at {name}: check that it is plugged in and powered, and that the configured port is right ({detail})"
    )]
    NotFound {
        /// Path or address.
        name: String,
        /// What the system said.
        detail: String,
    },
    /// A name by identity that several devices go by.
    #[error(
        "{name} fits several devices: {fitting}; add the serial number of the right one, or name its port by where it is plugged in (/dev/serial/by-path)"
    )]
    Several {
        /// The name.
        name: String,
        /// All that fit.
        fitting: String,
    },
    /// Another process holds the port.
    #[error(
        "{name} is in use by {by}: stop it, or keep it off this port (the udev rules keep ModemManager off), and try again"
    )]
    Busy {
        /// Path of the port.
        name: String,
        /// Which program, as far as this user may know.
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
    /// The device, its adapter or the peer has gone; the link must be opened anew.
    #[error("{name} has gone ({detail}): unplugged, powered off, or closed by the other side")]
    Disconnected {
        /// Path or address.
        name: String,
        /// What the system said.
        detail: String,
    },
    /// A write was not taken in time.
    #[error("{name} took only {written} of {wanted} bytes in time")]
    TimedOut {
        /// Path or address.
        name: String,
        /// Bytes taken before the time was over.
        written: usize,
        /// Bytes that should have been taken.
        wanted: usize,
    },
    /// A dialogue left the transcript it is played against.
    #[error("replay of {name}: {fault}")]
    Replay {
        /// Name of the replay.
        name: String,
        /// Where the dialogue left the transcript.
        fault: ReplayFault,
    },
    /// Anything else the system reported.
    #[error("{name}: {source}")]
    Io {
        /// Path or address.
        name: String,
        /// The system's error.
        source: io::Error,
    },
}

/// The system's error numbers that mean "the device has gone" (Linux): EIO, ENXIO, EBADF, ENODEV.
const GONE_ERRNO: [i32; 4] = [5, 6, 9, 19];

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
            // A node whose driver has no device behind it any more.
            _ if source
                .raw_os_error()
                .is_some_and(|errno| GONE_ERRNO.contains(&errno)) =>
            {
                Self::NotFound {
                    name,
                    detail: source.to_string(),
                }
            }
            _ => Self::Io { name, source },
        }
    }

    /// Somebody has the port; who, is looked up.
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
            .is_some_and(|errno| GONE_ERRNO.contains(&errno));
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
