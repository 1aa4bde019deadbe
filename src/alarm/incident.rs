//! An incident: one thing that came or went at one waypoint, from the first visit that saw it to the last.

use super::sighting::Sighting;
use patrold_engine::mixture::Gaussian;
use patrold_engine::novelty::WatchedPlace;
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

/// What a visit is to an incident.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Relation {
    /// It saw the thing for the first time.
    Raised,
    /// It saw it again, as it was.
    Seen,
    /// It saw it in another place.
    Moved,
    /// It saw it in its place with another size: most probably the same thing.
    Changed,
    /// It saw its place without it.
    Gone,
    /// It saw it again after it was gone.
    Back,
}

impl Relation {
    /// Those after which later sightings are compared with this one.
    pub const ANCHORS: [Self; 4] = [Self::Raised, Self::Moved, Self::Changed, Self::Back];

    /// As in the database and in JSON.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Raised => "raised",
            Self::Seen => "seen",
            Self::Moved => "moved",
            Self::Changed => "changed",
            Self::Gone => "gone",
            Self::Back => "back",
        }
    }

    /// The state of an incident after it. What was acknowledged is a thing in its place: moved or back, it is open again.
    pub fn state_after(self, before: AlarmState) -> AlarmState {
        match self {
            Self::Raised | Self::Moved | Self::Back => AlarmState::Open,
            Self::Seen | Self::Changed => before,
            Self::Gone => AlarmState::Cleared,
        }
    }

    /// Whether later sightings are compared with this one.
    pub fn sets_anchor(self) -> bool {
        Self::ANCHORS.contains(&self)
    }
}

impl FromStr for Relation {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        [
            Self::Raised,
            Self::Seen,
            Self::Moved,
            Self::Changed,
            Self::Gone,
            Self::Back,
        ]
        .into_iter()
        .find(|relation| relation.as_str() == text)
        .ok_or_else(|| format!("expected a relation of a visit to an alarm, got {text:?}"))
    }
}

/// An incident as the rule needs it: not cleared, or gone and perhaps back.
#[derive(Debug, Clone, PartialEq)]
pub struct Incident {
    /// Number of the alarm.
    pub id: i64,
    /// Its state.
    pub state: AlarmState,
    /// The thing as it was when it was raised, or last moved, changed or came back. Later sightings are compared with this
    /// one, so that small steps add up.
    pub anchor: Sighting,
}

impl Incident {
    /// Where a visit has to look for it.
    pub fn place(&self) -> WatchedPlace {
        WatchedPlace {
            kind: self.anchor.kind,
            moments: Gaussian {
                mean: self.anchor.centre,
                covariance: self.anchor.spread,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{AlarmState, Relation};

    #[test]
    fn every_text_is_read_back_and_no_other() {
        let relations = ["raised", "seen", "moved", "changed", "gone", "back"];
        for text in relations {
            assert_eq!(text.parse().map(Relation::as_str), Ok(text));
        }
        let states = ["open", "acknowledged", "cleared"];
        for text in states {
            assert_eq!(text.parse().map(AlarmState::as_str), Ok(text));
        }
        for text in ["", "Raised", "opened"] {
            let relation = text.parse::<Relation>().expect_err(text);
            let state = text.parse::<AlarmState>().expect_err(text);
            assert!(relation.contains(text) && state.contains(text));
        }
    }

    #[test]
    fn what_is_moved_or_back_is_open_again_and_what_is_gone_is_cleared() {
        use AlarmState::{Acknowledged, Cleared, Open};
        for (relation, of_open, of_acknowledged, sets_anchor) in [
            (Relation::Raised, Open, Open, true),
            (Relation::Seen, Open, Acknowledged, false),
            (Relation::Moved, Open, Open, true),
            (Relation::Changed, Open, Acknowledged, true),
            (Relation::Gone, Cleared, Cleared, false),
            (Relation::Back, Open, Open, true),
        ] {
            assert_eq!(relation.state_after(Open), of_open, "{relation:?}");
            assert_eq!(
                relation.state_after(Acknowledged),
                of_acknowledged,
                "{relation:?}"
            );
            assert_eq!(relation.sets_anchor(), sets_anchor, "{relation:?}");
        }
    }
}
