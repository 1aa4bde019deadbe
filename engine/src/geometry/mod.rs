//! Takes coordinates, gives poses, views, neighbours and rigid registration. Metres, radians, REP-103 axes
//! (x forward, y left, z up) everywhere.

mod directions;
mod field;
mod landmarks;
mod mount;
mod neighbours;
mod passage;
mod pose;
mod principal;
mod rays;
mod registration;
mod scatter;
mod surfaces;
mod view;
mod voxel;

pub use field::Field;
pub use landmarks::Landmarks;
pub use mount::Mount;
pub use neighbours::Grid;
pub use passage::{Passage, RangeDrift};
pub use pose::{Pose, RollPitchYaw};
pub use rays::{Fan, Look, Rays, SECTORS};
pub use registration::{Registration, RegistrationSettings, register};
pub use surfaces::{Patch, Surfaces};
pub use view::{NoiseLaw, View};
pub use voxel::{Thinned, Voxels, thin};
