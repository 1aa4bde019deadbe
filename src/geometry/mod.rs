//! Takes coordinates, gives poses, views and rigid registration. Metres, radians, REP-103 axes
//! (x forward, y left, z up) everywhere.

mod mount;
mod pose;
mod view;
mod voxel;

pub use mount::Mount;
pub use pose::{Pose, RollPitchYaw};
pub use view::{NoiseLaw, View};
pub use voxel::{Thinned, thin};
