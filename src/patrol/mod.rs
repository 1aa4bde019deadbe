//! Takes a view and a waypoint's reference, gives the inspection: the whole corridor in one call, and its
//! report in the contract's words.

mod record;

pub use record::{NoveltyRecord, ShapeRecord};
