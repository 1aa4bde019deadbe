//! Takes scene files, gives what a laser on a pan-tilt would measure in them: simulated buildings for the device
//! twins, the demo and the tests. Map frame: x forward, y left, z up, the floor at z = 0; metres, radians.
//!
//! [`Scene`] is the file (walls, furniture, people, recorded clouds; variants by `extends`), [`World`] answers rays,
//! [`Robot`] knows where its beams go, [`Lookaround`] gives one revolution of the laser in device units, and
//! [`sample_view`] a whole labelled sweep without any device.

mod beam_fan;
mod body;
mod bvh;
mod cast;
mod constants;
mod lookaround;
mod noise;
mod person;
mod robot;
mod room;
mod sample;
mod scene;
mod scene_file;
mod solid;
mod superquadric;
mod surfel;
mod tables;

pub use beam_fan::BeamFan;
pub use body::Body;
pub use cast::{Hit, ObjectInfo, Ray, World};
pub use lookaround::Lookaround;
pub use noise::{NoiseOptions, TrueBeam};
pub use robot::{MountGeometry, Robot, Stand, azimuth_rad};
pub use sample::{SampledView, SweepRows, sample_view};
pub use scene::{CloudPlace, Object, Scene, SceneChange, SceneError};
pub use tables::{
    BoxTable, ConeTable, CylinderTable, DoorTable, Opening, PersonTable, PlaneTable, RoomTable,
    SphereTable, SuperquadricTable, Wall,
};
