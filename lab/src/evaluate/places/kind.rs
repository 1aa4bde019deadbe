//! The kinds of place by name.

use super::{canteen, corridor, hall, lab, office, ramp, storeroom, workshop};
use crate::evaluate::draw::Draw;
use crate::evaluate::place::Place;

/// A kind of place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Desks, chairs, shelves, windows.
    Office,
    /// Long, narrow, doors at its sides.
    Corridor,
    /// Benches on thin legs, full of equipment.
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

impl Kind {
    /// Those that anything may be tuned on.
    pub const TUNED: [Self; 6] = [
        Self::Office,
        Self::Corridor,
        Self::Lab,
        Self::Storeroom,
        Self::Ramp,
        Self::Hall,
    ];
    /// Those that nothing is ever tuned on.
    pub const HELD_OUT: [Self; 2] = [Self::Workshop, Self::Canteen];

    /// All of them.
    pub fn all() -> impl Iterator<Item = Self> {
        Self::TUNED.into_iter().chain(Self::HELD_OUT)
    }

    /// Its word on the command line and in tables.
    pub fn word(self) -> &'static str {
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

    /// A place of this kind; `None` where chance left no room for the robot.
    pub fn build(self, draw: &mut Draw) -> Option<Place> {
        match self {
            Self::Office => office::build(draw),
            Self::Corridor => corridor::build(draw),
            Self::Lab => lab::build(draw),
            Self::Storeroom => storeroom::build(draw),
            Self::Ramp => ramp::build(draw),
            Self::Hall => hall::build(draw),
            Self::Workshop => workshop::build(draw),
            Self::Canteen => canteen::build(draw),
        }
    }
}
