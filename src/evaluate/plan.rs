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
    /// Whether nothing may be tuned on it.
    pub held_out: bool,
}

impl Planned {
    /// The pair of this class and number.
    pub fn new(change: Change, number: usize, held_out: bool) -> Self {
        let places: Vec<Kind> = Kind::ALL
            .into_iter()
            .filter(|k| k.held_out() == held_out)
            .collect();
        let column = number % places.len().max(1);
        let turn = number / places.len().max(1);
        let place = places.get(column).copied().unwrap_or(Kind::Office);
        // Turns are coprime ways through poses and sensors, so each place meets every combination; shifts by place and
        // class let few pairs already see most of them.
        let class = every_class().position(|c| c == change).unwrap_or(0);
        let pose = PoseError::ALL[(turn + column + class) % PoseError::ALL.len()];
        let sensor = Sensor::ALL[(turn + 3 * column + class) % Sensor::ALL.len()];
        Self {
            change,
            number,
            place,
            sensor,
            pose,
            held_out,
        }
    }

    /// Its name, by which it can be run alone.
    pub fn name(&self) -> String {
        let held = if self.held_out { "held-" } else { "" };
        format!("{held}{}-{}", self.change.word(), self.number)
    }

    /// The pair called `name`.
    pub fn named(name: &str) -> Option<Self> {
        let (held_out, rest) = match name.strip_prefix("held-") {
            Some(rest) => (true, rest),
            None => (false, name),
        };
        let (class, number) = rest.rsplit_once('-')?;
        let number = number.parse().ok()?;
        let change = every_class().find(|c| c.word() == class)?;
        Some(Self::new(change, number, held_out))
    }

    /// A number of its own, as the stream of its chance.
    pub fn stream(&self) -> u64 {
        let class = every_class().position(|c| c == self.change).unwrap_or(0) as u64;
        let held = u64::from(self.held_out);
        (held << 48) | (class << 32) | self.number as u64
    }
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

/// The pairs of a run.
pub fn plan(tuned: Amounts, held_out: Amounts) -> Vec<Planned> {
    let mut all = Vec::new();
    for (amounts, held) in [(tuned, false), (held_out, true)] {
        let of = |change: Change| match change {
            Change::Quiet => amounts.quiet,
            c if c.ball().is_some() => amounts.balls,
            _ => amounts.large,
        };
        all.extend(every_class().flat_map(|c| (0..of(c)).map(move |n| Planned::new(c, n, held))));
    }
    all
}
