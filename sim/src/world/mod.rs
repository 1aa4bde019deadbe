//! Simulated surroundings: scene files in, what a laser on a pan-tilt measures in them out. Map frame: x forward, y left,
//! z up, the floor at z = 0; metres, radians.
//!
//! A [`Scene`] is read from a file (walls, furniture, people, recorded clouds; variants by `extends`) and builds a
//! [`World`] that rays are cast in. A [`SimulatedRobot`] gives the directions of its beams, a [`SimulatedLaser`] one
//! revolution in the units of the sensor, and [`simulate_sweep`] a whole sweep with the true object of every point.

mod beam_fan;
mod body;
mod bvh;
mod cast;
mod constants;
mod laser;
mod noise;
mod person;
mod placement;
mod ray_box;
mod robot;
mod room;
mod scene;
mod scene_error;
mod scene_file;
mod simulated_sweep;
mod solid;
mod superquadric;
mod surfel;
mod tables;

pub use beam_fan::BeamFan;
pub use body::Body;
pub use cast::{Hit, ObjectInfo, Ray, World};
pub use laser::SimulatedLaser;
pub use noise::{NoiseOptions, TrueBeam};
pub use robot::{MountGeometry, Pose2d, SimulatedRobot, azimuth_rad};
pub use scene::{PlacedCloud, Scene, SceneChange, SceneObject};
pub use scene_error::SceneError;
pub use simulated_sweep::{SimulatedSweep, SweepRows, simulate_sweep};
pub use tables::{
    BoxTable, ConeTable, CylinderTable, DoorTable, Opening, PersonTable, PlaneTable, RoomTable,
    SphereTable, SuperquadricTable, Wall,
};
