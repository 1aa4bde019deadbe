//! Why the emulator cannot start.

use link::LinkError;
use std::net::SocketAddr;

/// Why the emulator cannot start.
#[derive(Debug, thiserror::Error)]
pub enum EmulatorError {
    /// A pseudo-terminal or its link.
    #[error(transparent)]
    Terminal(#[from] LinkError),
    /// The TCP address.
    #[error("{address}: {source}")]
    Listen {
        /// Where it was to listen.
        address: SocketAddr,
        /// The system's error.
        source: std::io::Error,
    },
    /// A thread.
    #[error("no thread for the emulator: {0}")]
    Thread(std::io::Error),
}
