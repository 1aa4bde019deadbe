//! Transports for the two devices: serial port, TCP, pseudo-terminal, and transcripts of dialogues.
//!
//! A driver turns bytes and instants into actions; a [`Link`] is where the bytes come from. This is the only place of the
//! project that opens a device node.

mod clock;
mod error;
mod holder;
mod pty;
mod record;
mod replay;
mod serial;
mod tcp;
mod transcript;
mod usb;

pub use clock::Clock;
pub use error::LinkError;
pub use holder::holders;
pub use pty::PseudoTerminal;
pub use record::Recorder;
pub use replay::{Replay, ReplayFault};
pub use serial::SerialLink;
pub use tcp::TcpLink;
pub use transcript::{Direction, Entry, Transcript, TranscriptError};
pub use usb::{BadUsbName, Candidate, UsbDevice, UsbName, candidates};

use std::time::Duration;

/// A byte pipe to one device: blocking, with a time limit on every call.
pub trait Link: Send {
    /// Reads what has come, waiting at most `timeout` for the first byte. 0 means that nothing came in time.
    ///
    /// # Errors
    /// [`LinkError::Disconnected`] if the device or its adapter has gone, [`LinkError::Io`] for the rest.
    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Result<usize, LinkError>;

    /// Hands all of `bytes` to the transport within `timeout`.
    ///
    /// # Errors
    /// [`LinkError::TimedOut`] if the transport took only a part in time (the part is named),
    /// [`LinkError::Disconnected`] if the device has gone, [`LinkError::Io`] for the rest.
    fn write_all(&mut self, bytes: &[u8], timeout: Duration) -> Result<(), LinkError>;

    /// The path or address the link was opened with, for messages.
    fn name(&self) -> &str;
}

impl<L: Link + ?Sized> Link for Box<L> {
    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Result<usize, LinkError> {
        (**self).read(buffer, timeout)
    }

    fn write_all(&mut self, bytes: &[u8], timeout: Duration) -> Result<(), LinkError> {
        (**self).write_all(bytes, timeout)
    }

    fn name(&self) -> &str {
        (**self).name()
    }
}
