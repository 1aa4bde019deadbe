//! Why and how a stopped stream is restarted.

/// Why a stream is restarted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RecoveryCause {
    /// No data in time.
    Silence,
    /// Too many damaged messages in a row.
    Damage,
    /// The request to stream was not acknowledged.
    NotAcknowledged,
}

impl std::fmt::Display for RecoveryCause {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Silence => "no data",
            Self::Damage => "damaged data",
            Self::NotAcknowledged => "not acknowledged",
        })
    }
}

/// How a stream is restarted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RecoveryStep {
    /// `QT`, then the stream again.
    Quit,
    /// `RS`, then the stream again; the timer restarts at zero.
    Reset,
}
