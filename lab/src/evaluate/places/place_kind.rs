//! The kinds of place by name.

use super::{canteen, corridor, hall, lab, office, ramp, storeroom, workshop};
use crate::evaluate::place::SimulatedPlace;
use crate::evaluate::seeded_rng::SeededRng;

/// A kind of place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PlaceKind {
    /// Desks, chairs, shelves, windows.
    Office,
    /// Long, narrow, doors at its sides.
    Corridor,
    /// Tables on thin legs, full of equipment.
    Lab,
    /// Shelves with goods.
    Storeroom,
    /// Two levels joined by a ramp or stairs.
    Ramp,
    /// Large, with few features and a ceiling out of reach.
    Hall,
    /// Machines, leaning boards. Held out.
    Workshop,
    /// Round tables, many chairs, a glass front. Held out.
    Canteen,
}

impl PlaceKind {
    /// Those on which parameters may be tuned.
    pub const TUNED: [Self; 6] = [
        Self::Office,
        Self::Corridor,
        Self::Lab,
        Self::Storeroom,
        Self::Ramp,
        Self::Hall,
    ];
    /// Those on which nothing is ever tuned.
    pub const HELD_OUT: [Self; 2] = [Self::Workshop, Self::Canteen];

    /// All kinds, the held-out ones last.
    pub fn all() -> impl Iterator<Item = Self> {
        Self::TUNED.into_iter().chain(Self::HELD_OUT)
    }

    /// The name on the command line and in tables.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Office => "office",
            Self::Corridor => "corridor",
            Self::Lab => "lab",
            Self::Storeroom => "storeroom",
            Self::Ramp => "ramp",
            Self::Hall => "hall",
            Self::Workshop => "workshop",
            Self::Canteen => "canteen",
        }
    }

    /// A random place of this kind; `None` where there is no room for the robot.
    pub fn build(self, rng: &mut SeededRng) -> Option<SimulatedPlace> {
        match self {
            Self::Office => office::build(rng),
            Self::Corridor => corridor::build(rng),
            Self::Lab => lab::build(rng),
            Self::Storeroom => storeroom::build(rng),
            Self::Ramp => ramp::build(rng),
            Self::Hall => hall::build(rng),
            Self::Workshop => workshop::build(rng),
            Self::Canteen => canteen::build(rng),
        }
    }
}
