//! Transports for the two devices (serial port, TCP, pseudo-terminal), the clock of their time limits, and recorded dialogues.
//!
//! A driver turns bytes and instants into actions; a [`Link`] carries the bytes. Only this crate opens device nodes.

mod clock;
mod detect;
mod error;
mod holder;
mod link;
mod pty;
mod recorder;
mod replay;
mod serial;
mod tcp;
mod transcript;
mod usb;

pub use clock::{Clock, Pacer};
pub use detect::{detect_ports, socket_link};
pub use error::{LinkError, ReplayFault};
pub use holder::holders;
pub use link::Link;
pub use pty::PseudoTerminal;
pub use recorder::Recorder;
pub use replay::Replay;
pub use serial::SerialLink;
pub use tcp::TcpLink;
pub use transcript::{Direction, Transcript, TranscriptEntry, TranscriptError};
pub use usb::{DetectedPort, UsbDevice, UsbName, UsbNameError};
