//! An alarm as an incident: one change of one place, from the first visit that saw it to the last.

use nalgebra::Point3;
use patrold_engine::novelty::Kind;
use std::fmt;
use std::str::FromStr;

/// Where an alarm stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum State {
    /// Raised; nobody has said that they saw it.
    Open,
    /// Somebody saw it; the change is still there.
    Acknowledged,
    /// The place was seen without the change since, or was taught anew.
    Cleared,
}

impl State {
    /// The word that stands in the database and in JSON.
    pub fn word(self) -> &'static str {
        match self {
            Self::Open => "open",
            Self::Acknowledged => "acknowledged",
            Self::Cleared => "cleared",
        }
    }
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())
    }
}

impl FromStr for State {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        [Self::Open, Self::Acknowledged, Self::Cleared]
            .into_iter()
            .find(|state| state.word() == word)
            .ok_or_else(|| format!("expected open, acknowledged or cleared, got {word:?}"))
    }
}

/// One thing that came or went, as far as recognising it again goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    /// Came or went.
    pub kind: Kind,
    /// Its centre in the waypoint's reference frame, metres.
    pub centre: Point3<f64>,
}

/// An alarm that is not cleared.
#[derive(Debug, Clone, PartialEq)]
pub struct Incident {
    /// Its number in the log.
    pub id: i64,
    /// What its visits have seen so far.
    pub sightings: Vec<Sighting>,
}
