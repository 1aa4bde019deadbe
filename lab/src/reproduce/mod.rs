//! Takes a seed, gives the paper's experiments (section V): its corridor and its three test sites, and a furnished room
//! for the shapes that it left for later, with what was in them, what the engine made of each, and the columns of Tables I and II.
//!
//! `corridor`, `sites` and `rooms` make scenes with their truth (the last two by `two_sweeps`), `ways` are the columns, `judge` is where scenes
//! meet the engine, `score` compares one answer with its truth, `row` counts. `removal` is Fig. 3, `ideal_cylinder`
//! Fig. 4d; `picture` and `outline` are what Fig. 5 and 6 show.

mod constants;
mod corridor;
mod error;
mod ideal_cylinder;
mod judge;
pub mod outline;
mod picture;
mod removal;
mod rooms;
mod row;
mod score;
mod sites;
mod truth;
mod two_sweeps;
mod ways;

pub use corridor::{Beams, Corridor, Density, Noise, Thing};
pub use error::LookError;
pub use ideal_cylinder::{Attitude, Told, attitudes, told};
pub use judge::{Clock, Judged, judge};
pub use picture::{Picture, picture};
pub use removal::{Removal, RemovalError, Removals, removals};
pub use rooms::Furnished;
pub use row::{PAPER, PaperColumn, Row};
pub use score::{Mark, rotation_error_rad, score};
pub use sites::Site;
pub use truth::{Look, Truth};
pub use ways::Way;
