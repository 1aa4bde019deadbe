//! The kinds of place by name.

use super::{corridor, hall, office, storeroom};
use crate::evaluate::draw::Draw;
use crate::evaluate::place::Place;

/// A kind of place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Desks, chairs, shelves, windows.
    Office,
    /// Long, narrow, doors at its sides.
    Corridor,
    /// Rows of shelves with goods.
    Storeroom,
    /// Large, with few features and a ceiling out of reach.
    Hall,
}

impl Kind {
    /// Every kind.
    pub const ALL: [Self; 4] = [Self::Office, Self::Corridor, Self::Storeroom, Self::Hall];

    /// Its word on the command line and in tables.
    pub fn word(self) -> &'static str {
        match self {
            Self::Office => "office",
            Self::Corridor => "corridor",
            Self::Storeroom => "storeroom",
            Self::Hall => "hall",
        }
    }

    /// Whether nothing is ever tuned on it.
    pub fn held_out(self) -> bool {
        false
    }

    /// A place of this kind; `None` where chance left no room for the robot.
    pub fn build(self, draw: &mut Draw) -> Option<Place> {
        match self {
            Self::Office => office::build(draw),
            Self::Corridor => corridor::build(draw),
            Self::Storeroom => storeroom::build(draw),
            Self::Hall => hall::build(draw),
        }
    }
}
