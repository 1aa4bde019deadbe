//! The three test sites after the photographs of paper section V.B, Fig. 6: a door opened, a person in the corridor, a door
//! closed.

use super::constants::{
    DOOR_HINGE_M, DOOR_LEAF_M, DOOR_OPEN_DEG, DOOR_THICKNESS_M, PERSON_HEIGHT_M, PERSON_POSITION_M,
    REPEATS, SITE_ROWS,
};
use super::error::ScenePairError;
use super::scene_pair::{NoveltyTruth, ScenePair};
use super::sweep_pair::simulate_sweep_pair;
use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
use patrold_engine::geometry::Pose;
use patrold_engine::shape::{Class, Plane, Primitive};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// A corridor 2.4 m wide with a cupboard, and a doorway of 0.9 m in its left wall to a room behind.
const CORRIDOR: &str = "
[[room]]
name = 'corridor'
centre = [1.5, 0.0, 1.25]
size = [9.0, 2.4, 2.5]
openings = [{ wall = 'left', at_m = 0.6, width_m = 0.9, from_m = 0.0, to_m = 2.0 }]

[[room]]
name = 'behind'
centre = [2.1, 2.3, 1.25]
size = [3.0, 2.0, 2.5]
openings = [{ wall = 'right', at_m = 0.0, width_m = 0.9, from_m = 0.0, to_m = 2.0 }]

[[box]]
name = 'cupboard'
centre = [4.2, -1.0, 0.9]
size = [0.8, 0.4, 1.8]

[[box]]
name = 'bench'
centre = [-1.5, -0.95, 0.22]
size = [1.2, 0.4, 0.44]
";

/// A test site.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TestSite {
    /// Fig. 6a: a door opened.
    DoorOpened,
    /// Fig. 6b: a person in the corridor.
    Person,
    /// Fig. 6c: a door closed.
    DoorClosed,
}

impl TestSite {
    /// Repeats at each site (paper section V).
    pub const REPEATS: usize = REPEATS;

    /// All sites.
    pub const ALL: [Self; 3] = [Self::DoorOpened, Self::Person, Self::DoorClosed];

    /// The name in tables and in names of scenes.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::DoorOpened => "door-opened",
            Self::Person => "person",
            Self::DoorClosed => "door-closed",
        }
    }

    /// The two sweeps of one repeat under this seed: other noise, the robot back to within 3 cm and 1.5 degrees.
    ///
    /// # Errors
    /// A mistake in the text of the scenes.
    pub fn simulate(self, repeat: usize, seed: u64) -> Result<ScenePair, ScenePairError> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream((repeat as u64) << 8 | 0x80 | self as u64);
        let (before, after) = match self {
            Self::DoorOpened => (door(0.0), door(DOOR_OPEN_DEG)),
            Self::Person => (door(0.0), door(0.0) + &person()),
            Self::DoorClosed => (door(DOOR_OPEN_DEG), door(0.0)),
        };
        let sweeps = simulate_sweep_pair([&before, &after], SITE_ROWS, &mut rng)?;
        let truth = self.truth(&sweeps.base_from_map, &sweeps.after.view.origin);
        let name = format!("{}-{repeat}", self.as_str());
        Ok(sweeps.into_scene(name, Some(truth), self != Self::Person))
    }

    fn truth(self, base_from_map: &Pose, sensor: &Point3<f64>) -> NoveltyTruth {
        let leaf = |angle_deg: f64| {
            // Closed, the leaf points along -x from its hinge; counter-clockwise it swings into the corridor.
            let along =
                Rotation3::from_axis_angle(&Vector3::z_axis(), (180.0 + angle_deg).to_radians())
                    * Vector3::x();
            let middle = Point3::new(DOOR_HINGE_M[0], DOOR_HINGE_M[1], DOOR_LEAF_M[1] / 2.0)
                + along * (DOOR_LEAF_M[0] / 2.0);
            let normal = Vector3::z().cross(&along);
            let axes = Matrix3::from_columns(&[Vector3::z(), along, Vector3::z().cross(&along)]);
            // The face towards the sensor.
            let side = (base_from_map.inverse() * sensor - middle)
                .dot(&normal)
                .signum();
            let face = Primitive::Plane(Plane {
                centre: middle + normal * (side * DOOR_THICKNESS_M / 2.0),
                rotation: Rotation3::from_matrix_unchecked(axes),
                sides_m: [DOOR_LEAF_M[1], DOOR_LEAF_M[0]],
            });
            NoveltyTruth::of_primitive(&face.transformed(base_from_map), sensor)
        };
        match self {
            Self::DoorOpened => leaf(DOOR_OPEN_DEG),
            Self::DoorClosed => leaf(0.0),
            Self::Person => NoveltyTruth {
                class: Class::Cylinder,
                centre: base_from_map
                    * Point3::new(
                        PERSON_POSITION_M[0],
                        PERSON_POSITION_M[1],
                        PERSON_HEIGHT_M / 2.0,
                    ),
                rotation: base_from_map.rotation.to_rotation_matrix().into_inner(),
                size_m: [0.4, 0.4, PERSON_HEIGHT_M],
                sized: [false, false, true],
                turned: false,
            },
        }
    }
}

fn door(angle_deg: f64) -> String {
    format!(
        "{CORRIDOR}\n[[door]]\nname = 'door'\nhinge = [{}, {}, 0.0]\nyaw_deg = 180.0\nwidth_m = {}\nheight_m = {}\n\
         thickness_m = {DOOR_THICKNESS_M}\nangle_deg = {angle_deg:?}\n",
        DOOR_HINGE_M[0], DOOR_HINGE_M[1], DOOR_LEAF_M[0], DOOR_LEAF_M[1]
    )
}

fn person() -> String {
    format!(
        "\n[[person]]\nname = 'person'\nat = [{}, {}, 0.0]\nheight_m = {PERSON_HEIGHT_M}\n",
        PERSON_POSITION_M[0], PERSON_POSITION_M[1]
    )
}
