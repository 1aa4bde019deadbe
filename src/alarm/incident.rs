//! An alarm as an incident: one change at one waypoint, from the first visit that saw it to the last.

use nalgebra::Point3;
use patrold_engine::novelty::NoveltyKind;
use std::fmt;
use std::str::FromStr;

/// State of an alarm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum AlarmState {
    /// Not acknowledged.
    Open,
    /// Acknowledged; the change is still there.
    Acknowledged,
    /// A later visit did not see the change, or the place was taught again.
    Cleared,
}

impl AlarmState {
    /// As in the database and in JSON.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Open => "open",
            Self::Acknowledged => "acknowledged",
            Self::Cleared => "cleared",
        }
    }
}

impl fmt::Display for AlarmState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

impl FromStr for AlarmState {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        [Self::Open, Self::Acknowledged, Self::Cleared]
            .into_iter()
            .find(|state| state.as_str() == text)
            .ok_or_else(|| format!("expected open, acknowledged or cleared, got {text:?}"))
    }
}

/// A novelty, as far as needed to recognize it in a later visit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    /// Appeared or disappeared.
    pub kind: NoveltyKind,
    /// Centre in the waypoint's reference frame, metres.
    pub centre: Point3<f64>,
}

/// A standing alarm: one that is not cleared.
#[derive(Debug, Clone, PartialEq)]
pub struct Incident {
    /// Number of the alarm.
    pub id: i64,
    /// Novelties of its visits.
    pub sightings: Vec<Sighting>,
}
