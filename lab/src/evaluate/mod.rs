//! Takes a seed, gives rates: simulated pairs of sweeps with their truth, judged by the engine and held against it.
//!
//! A pair is fixed by the seed, its class of change and its number ([`plan`]); [`Pair::take`] draws its place, its change
//! and its sweeps; [`judge`] is the one place that calls the engine; [`score()`] holds what it said against the truth,
//! and [`summarise`] makes rows of rates. Time is the caller's.

mod builder;
mod changes;
mod constants;
mod doorway;
mod draw;
mod dump;
mod furniture;
mod judge;
mod pair;
mod place;
mod places;
mod plan;
mod rates;
mod score;
mod sensor;
mod summary;
mod truth;

pub use changes::Change;
pub use dump::{Entry, NamedFile, dump};
pub use judge::{Clock, Engine, Given, Judged, judge};
pub use pair::{Pair, PairError};
pub use places::Kind;
pub use plan::{Amounts, Planned, PoseError, Set, plan};
pub use rates::Rate;
pub use score::{Listed, Outcome, score};
pub use sensor::Sensor;
pub use summary::{Row, summarise};
pub use truth::Label;
