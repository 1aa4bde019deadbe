//! The engines by name.

use std::str::FromStr;

/// Which [`EngineSettings`](super::EngineSettings) are used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Engine {
    /// patrold's own.
    Standard,
    /// The paper's chain made well-posed: the revisit is fitted from the reference; no evidence from rays.
    Paper,
    /// The published recipe to the letter: both visits are fitted alone.
    PaperIndependent,
}

/// A name that is no engine's.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("expected standard, paper or paper-independent, got {0:?}")]
pub struct UnknownEngine(String);

impl Engine {
    /// All, the default first.
    pub const ALL: [Self; 3] = [Self::Standard, Self::Paper, Self::PaperIndependent];

    /// The name in configuration, JSON and tables.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Standard => "standard",
            Self::Paper => "paper",
            Self::PaperIndependent => "paper-independent",
        }
    }
}

impl FromStr for Engine {
    type Err = UnknownEngine;

    fn from_str(name: &str) -> Result<Self, UnknownEngine> {
        let found = Self::ALL.into_iter().find(|engine| engine.as_str() == name);
        found.ok_or_else(|| UnknownEngine(name.to_owned()))
    }
}
