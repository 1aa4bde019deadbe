//! Poses, views, surfaces, neighbour search and rigid registration. Metres, radians, REP-103 axes (x forward, y left,
//! z up) everywhere.

mod constants;
mod direction_index;
mod drift;
mod field_of_view;
mod mount;
mod plane_index;
mod point_grid;
mod pose;
mod principal_axes;
mod range_noise;
mod ray_index;
mod rays;
mod registration;
mod sectors;
mod surfaces;
mod view;
mod voxel;

pub(crate) use drift::DriftTransform;
pub use drift::RangeDrift;
pub(crate) use field_of_view::FieldOfViewBounds;
pub use mount::Mount;
pub(crate) use plane_index::PlaneIndex;
pub use point_grid::PointGrid;
pub use pose::{Pose, RollPitchYaw};
pub use ray_index::RayIndex;
pub(crate) use rays::RaySet;
pub(crate) use registration::register;
pub use registration::{Registration, RegistrationSettings};
pub(crate) use surfaces::SurfacePatch;
pub use surfaces::Surfaces;
pub use view::{NoiseLaw, View};
pub(crate) use voxel::VoxelTable;
pub use voxel::{DownsampledCloud, voxel_downsample};
