//! The pairs: each is fixed by the seed, its class of change and its number, whatever else is run.

use super::changes::ChangeClass;
use super::places::PlaceKind;
use super::sensor::SensorKind;

/// Class of the distance between the robot and its waypoint on the revisit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PoseErrorClass {
    /// None.
    None,
    /// Up to 5 cm and 2 deg.
    Small,
    /// 5-10 cm and 2-5 deg.
    Large,
    /// 10-20 cm and 5-8 deg: only where a run asks for it.
    Wide,
    /// 20-30 cm and 8-15 deg: only where a run asks for it.
    Widest,
}

impl PoseErrorClass {
    /// All classes.
    pub const ALL: [Self; 5] = [
        Self::None,
        Self::Small,
        Self::Large,
        Self::Wide,
        Self::Widest,
    ];

    /// Those of the plan: how a robot that works stops at its waypoint.
    const PLANNED: [Self; 3] = [Self::None, Self::Small, Self::Large];

    /// The name in tables and JSON.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::None => "0",
            Self::Small => "0-5 cm, 0-2 deg",
            Self::Large => "5-10 cm, 2-5 deg",
            Self::Wide => "10-20 cm, 5-8 deg",
            Self::Widest => "20-30 cm, 8-15 deg",
        }
    }
}

/// What parameters may be tuned on, and what is held out to show whether that generalises.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PairSet {
    /// Parameters may be tuned on these.
    Tuned,
    /// Places on which nothing is tuned.
    HeldOutPlaces,
    /// A sensor on which nothing is tuned, in every kind of place.
    HeldOutSensor,
}

impl PairSet {
    /// All sets.
    pub const ALL: [Self; 3] = [Self::Tuned, Self::HeldOutPlaces, Self::HeldOutSensor];

    /// The name in tables and JSON.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Tuned => "tuned",
            Self::HeldOutPlaces => "held_out_places",
            Self::HeldOutSensor => "held_out_sensor",
        }
    }

    /// Prefix of the names of its pairs.
    fn prefix(self) -> &'static str {
        match self {
            Self::Tuned => "",
            Self::HeldOutPlaces => "places-",
            Self::HeldOutSensor => "rings-",
        }
    }

    fn places(self) -> Vec<PlaceKind> {
        match self {
            Self::Tuned => PlaceKind::TUNED.to_vec(),
            Self::HeldOutPlaces => PlaceKind::HELD_OUT.to_vec(),
            Self::HeldOutSensor => PlaceKind::all().collect(),
        }
    }

    fn sensors(self) -> &'static [SensorKind] {
        match self {
            Self::Tuned | Self::HeldOutPlaces => &SensorKind::TUNED,
            Self::HeldOutSensor => &[SensorKind::Rings],
        }
    }
}

/// The plan of a pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairPlan {
    /// Class of the change.
    pub change: ChangeClass,
    /// Number within its class.
    pub number: usize,
    /// Kind of place.
    pub place: PlaceKind,
    /// Sensor.
    pub sensor: SensorKind,
    /// Class of the pose error.
    pub pose_error: PoseErrorClass,
    /// Set that it belongs to.
    pub set: PairSet,
}

impl PairPlan {
    /// The pair of this class and number.
    pub fn new(change: ChangeClass, number: usize, set: PairSet) -> Self {
        let (places, sensors) = (set.places(), set.sensors());
        let (column, round) = (number % places.len(), number / places.len());
        // The numbers of sensors and pose errors have no common divisor, so each place gets every combination; the
        // shifts by place and class let few pairs already have most of them.
        let class = class_index(change);
        Self {
            change,
            number,
            place: places[column],
            sensor: sensors[(round + 3 * column + class) % sensors.len()],
            pose_error: PoseErrorClass::PLANNED
                [(round + column + class) % PoseErrorClass::PLANNED.len()],
            set,
        }
    }

    /// The name by which it can be run alone.
    pub fn name(&self) -> String {
        format!(
            "{}{}-{}",
            self.set.prefix(),
            self.change.as_str(),
            self.number
        )
    }

    /// The pair called `name`.
    pub fn from_name(name: &str) -> Option<Self> {
        // The empty prefix fits every name: the longest that fits counts.
        let fits = |set: &PairSet| name.starts_with(set.prefix());
        let set = PairSet::ALL
            .into_iter()
            .filter(fits)
            .max_by_key(|s| s.prefix().len())?;
        let (class, number) = name.strip_prefix(set.prefix())?.rsplit_once('-')?;
        let number = number.parse().ok()?;
        let change = all_classes().find(|c| c.as_str() == class)?;
        Some(Self::new(change, number, set))
    }

    /// The random stream of a further visit to its place, unique among pairs and visits.
    pub(crate) fn visit_stream(&self, visit: u32) -> u64 {
        // The sets end below bit 50, and a run has fewer than 2^13 visits to a place.
        (u64::from(visit) + 1) << 50 | self.rng_stream()
    }

    /// Its random stream, unique among pairs.
    pub fn rng_stream(&self) -> u64 {
        let set = PairSet::ALL
            .iter()
            .position(|s| *s == self.set)
            .unwrap_or(0) as u64;
        (set << 48) | ((class_index(self.change) as u64) << 32) | self.number as u64
    }
}

fn class_index(change: ChangeClass) -> usize {
    all_classes().position(|c| c == change).unwrap_or(0)
}

fn all_classes() -> impl Iterator<Item = ChangeClass> {
    std::iter::once(ChangeClass::Quiet)
        .chain(ChangeClass::LARGE)
        .chain(ChangeClass::BALLS)
}

/// Numbers of pairs by class.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PairCounts {
    /// Pairs without change.
    pub quiet: usize,
    /// Pairs of each class of large changes.
    pub large: usize,
    /// Pairs of each kind of ball.
    pub balls: usize,
}

/// The pairs of a run: so many of each set, in the order of [`PairSet::ALL`].
pub fn plan(counts: [PairCounts; 3]) -> Vec<PairPlan> {
    let mut all = Vec::new();
    for (counts, set) in counts.into_iter().zip(PairSet::ALL) {
        let count = |change: ChangeClass| match change {
            ChangeClass::Quiet => counts.quiet,
            c if c.ball().is_some() => counts.balls,
            _ => counts.large,
        };
        all.extend(
            all_classes().flat_map(|c| (0..count(c)).map(move |n| PairPlan::new(c, n, set))),
        );
    }
    all
}

#[cfg(test)]
mod tests {
    use super::{ChangeClass, PairCounts, PairPlan, PairSet, plan};
    use std::collections::HashSet;

    #[test]
    fn names_and_streams_are_unique_and_names_parse() {
        let counts = PairCounts {
            quiet: 40,
            large: 10,
            balls: 5,
        };
        let all = plan([counts; 3]);
        assert_eq!(all.len(), 3 * (40 + 60 + 15));
        let names: HashSet<String> = all.iter().map(PairPlan::name).collect();
        let streams: HashSet<u64> = all.iter().map(PairPlan::rng_stream).collect();
        assert_eq!((names.len(), streams.len()), (all.len(), all.len()));
        for plan in &all {
            assert_eq!(PairPlan::from_name(&plan.name()), Some(*plan));
        }
        for wrong in ["", "quiet", "quiet-x", "tree-1", "rings-1"] {
            assert_eq!(PairPlan::from_name(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn every_place_has_every_sensor_with_every_pose_error() {
        let combinations: HashSet<_> = (0..180)
            .map(|n| PairPlan::new(ChangeClass::Quiet, n, PairSet::Tuned))
            .map(|p| (p.place, p.sensor, p.pose_error))
            .collect();
        assert_eq!(combinations.len(), 180);
    }
}
