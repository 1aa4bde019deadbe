//! Which pairs there are: a pair is fixed by the seed, its class of change and its number, whatever else is run.

use super::changes::Change;
use super::places::Kind;
use super::sensor::Sensor;

/// How far off its waypoint the robot stands on the revisit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PoseError {
    /// Nowhere off.
    None,
    /// Up to 5 cm and 2 deg.
    Small,
    /// 5-10 cm and 2-5 deg.
    Large,
}

impl PoseError {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::None, Self::Small, Self::Large];

    /// Its words in tables.
    pub fn word(self) -> &'static str {
        match self {
            Self::None => "0",
            Self::Small => "0-5 cm, 0-2 deg",
            Self::Large => "5-10 cm, 2-5 deg",
        }
    }
}

/// What may be tuned on, and what is kept apart to show whether that carries over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Set {
    /// Anything may be tuned on these.
    Tuned,
    /// Places that nothing is tuned on.
    HeldOutPlaces,
    /// A sensor that nothing is tuned on, in every kind of place.
    HeldOutSensor,
}

impl Set {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Tuned, Self::HeldOutPlaces, Self::HeldOutSensor];

    /// Its word in tables and JSON.
    pub fn word(self) -> &'static str {
        match self {
            Self::Tuned => "tuned",
            Self::HeldOutPlaces => "held_out_places",
            Self::HeldOutSensor => "held_out_sensor",
        }
    }

    /// What names of its pairs begin with.
    fn prefix(self) -> &'static str {
        match self {
            Self::Tuned => "",
            Self::HeldOutPlaces => "places-",
            Self::HeldOutSensor => "rings-",
        }
    }

    fn places(self) -> Vec<Kind> {
        match self {
            Self::Tuned => Kind::TUNED.to_vec(),
            Self::HeldOutPlaces => Kind::HELD_OUT.to_vec(),
            Self::HeldOutSensor => Kind::all().collect(),
        }
    }

    fn sensors(self) -> &'static [Sensor] {
        match self {
            Self::Tuned | Self::HeldOutPlaces => &Sensor::TUNED,
            Self::HeldOutSensor => &[Sensor::Rings],
        }
    }
}

/// What a pair is of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Planned {
    /// What changes.
    pub change: Change,
    /// Number within its class.
    pub number: usize,
    /// Where.
    pub place: Kind,
    /// Seen with what.
    pub sensor: Sensor,
    /// How far off.
    pub pose: PoseError,
    /// Whether anything may be tuned on it.
    pub set: Set,
}

impl Planned {
    /// The pair of this class and number.
    pub fn new(change: Change, number: usize, set: Set) -> Self {
        let (places, sensors) = (set.places(), set.sensors());
        let (column, turn) = (number % places.len(), number / places.len());
        // Turns go through poses and sensors by steps that have no common divisor, so each place meets every
        // combination; shifts by place and class let few pairs already see most of them.
        let class = place_of(change);
        Self {
            change,
            number,
            place: places[column],
            sensor: sensors[(turn + 3 * column + class) % sensors.len()],
            pose: PoseError::ALL[(turn + column + class) % PoseError::ALL.len()],
            set,
        }
    }

    /// Its name, by which it can be run alone.
    pub fn name(&self) -> String {
        format!(
            "{}{}-{}",
            self.set.prefix(),
            self.change.word(),
            self.number
        )
    }

    /// The pair called `name`.
    pub fn named(name: &str) -> Option<Self> {
        // The empty prefix comes first and fits every name: the longest that fits counts.
        let fits = |set: &Set| name.starts_with(set.prefix());
        let set = Set::ALL
            .into_iter()
            .filter(fits)
            .max_by_key(|s| s.prefix().len())?;
        let (class, number) = name.strip_prefix(set.prefix())?.rsplit_once('-')?;
        let number = number.parse().ok()?;
        let change = every_class().find(|c| c.word() == class)?;
        Some(Self::new(change, number, set))
    }

    /// A number of its own, as the stream of its chance.
    pub fn stream(&self) -> u64 {
        let set = Set::ALL.iter().position(|s| *s == self.set).unwrap_or(0) as u64;
        (set << 48) | ((place_of(self.change) as u64) << 32) | self.number as u64
    }
}

/// Place of a class among all.
fn place_of(change: Change) -> usize {
    every_class().position(|c| c == change).unwrap_or(0)
}

fn every_class() -> impl Iterator<Item = Change> {
    std::iter::once(Change::Quiet)
        .chain(Change::LARGE)
        .chain(Change::BALLS)
}

/// How many pairs of which classes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Amounts {
    /// Pairs without change.
    pub quiet: usize,
    /// Pairs of each class of large changes.
    pub large: usize,
    /// Pairs of each kind of ball.
    pub balls: usize,
}

/// The pairs of a run: so many of each set, in the order of [`Set::ALL`].
pub fn plan(amounts: [Amounts; 3]) -> Vec<Planned> {
    let mut all = Vec::new();
    for (amounts, set) in amounts.into_iter().zip(Set::ALL) {
        let of = |change: Change| match change {
            Change::Quiet => amounts.quiet,
            c if c.ball().is_some() => amounts.balls,
            _ => amounts.large,
        };
        all.extend(every_class().flat_map(|c| (0..of(c)).map(move |n| Planned::new(c, n, set))));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::{Amounts, Change, Planned, Set, plan};
    use std::collections::HashSet;

    #[test]
    fn names_lead_back_and_are_their_own() {
        let amounts = Amounts {
            quiet: 40,
            large: 10,
            balls: 5,
        };
        let all = plan([amounts; 3]);
        assert_eq!(all.len(), 3 * (40 + 60 + 15));
        let names: HashSet<String> = all.iter().map(Planned::name).collect();
        let streams: HashSet<u64> = all.iter().map(Planned::stream).collect();
        assert_eq!((names.len(), streams.len()), (all.len(), all.len()));
        for planned in &all {
            assert_eq!(Planned::named(&planned.name()), Some(*planned));
        }
        for wrong in ["", "quiet", "quiet-x", "tree-1", "rings-1"] {
            assert_eq!(Planned::named(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn every_place_meets_every_sensor_in_every_pose() {
        let met: HashSet<_> = (0..180)
            .map(|n| Planned::new(Change::Quiet, n, Set::Tuned))
            .map(|p| (p.place, p.sensor, p.pose))
            .collect();
        assert_eq!(met.len(), 180);
    }
}
