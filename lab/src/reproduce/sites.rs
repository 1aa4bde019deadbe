//! The three test sites after the paper's photographs (section V.B, Fig. 6): a door that was opened, a person in the
//! corridor, a door that was closed.

use super::constants::{
    HINGE_M, LEAF_M, OPEN_DEG, PERSON_AT_M, PERSON_M, REPEATS, SITE_ROWS, THICKNESS_M,
};
use super::two_sweeps::two_sweeps;
use super::{Look, LookError, Truth};
use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
use patrold_engine::geometry::Pose;
use patrold_engine::shape::{Class, Plane, Primitive};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// A corridor 2.4 m wide with a cupboard and a doorway of 0.9 m in its left wall, a piece of a room behind it.
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
pub enum Site {
    /// Fig. 6a: a door was opened.
    DoorOpened,
    /// Fig. 6b: a person stands in the corridor.
    Person,
    /// Fig. 6c: a door was closed.
    DoorClosed,
}

impl Site {
    /// Repeats at each (section V).
    pub const REPEATS: usize = REPEATS;

    /// Every one.
    pub const ALL: [Self; 3] = [Self::DoorOpened, Self::Person, Self::DoorClosed];

    /// Its word.
    pub fn word(self) -> &'static str {
        match self {
            Self::DoorOpened => "door-opened",
            Self::Person => "person",
            Self::DoorClosed => "door-closed",
        }
    }

    /// The two captures of one repeat: same place, other noise, the robot back to within 3 cm and 1.5 degrees.
    ///
    /// # Errors
    /// Never for the scenes that this room makes; a mistake in their text.
    pub fn look(self, repeat: usize, seed: u64) -> Result<Look, LookError> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream((repeat as u64) << 8 | 0x80 | self as u64);
        let (before, after) = match self {
            Self::DoorOpened => (door(0.0), door(OPEN_DEG)),
            Self::Person => (door(0.0), door(0.0) + &person()),
            Self::DoorClosed => (door(OPEN_DEG), door(0.0)),
        };
        let sweeps = two_sweeps([&before, &after], SITE_ROWS, &mut rng)?;
        let truth = self.truth(&sweeps.base_from_map, &sweeps.after.view.origin);
        let name = format!("{}-{repeat}", self.word());
        Ok(sweeps.look(name, Some(truth), self != Self::Person))
    }

    fn truth(self, base_from_map: &Pose, sensor: &Point3<f64>) -> Truth {
        let leaf = |angle_deg: f64| {
            // Closed, the leaf points along -x from its hinge; turning it counter-clockwise swings it into the corridor.
            let along =
                Rotation3::from_axis_angle(&Vector3::z_axis(), (180.0 + angle_deg).to_radians())
                    * Vector3::x();
            let middle =
                Point3::new(HINGE_M[0], HINGE_M[1], LEAF_M[1] / 2.0) + along * (LEAF_M[0] / 2.0);
            let normal = Vector3::z().cross(&along);
            let axes = Matrix3::from_columns(&[Vector3::z(), along, Vector3::z().cross(&along)]);
            // The face that the sensor sees.
            let towards = (base_from_map.inverse() * sensor - middle)
                .dot(&normal)
                .signum();
            let face = Primitive::Plane(Plane {
                centre: middle + normal * (towards * THICKNESS_M / 2.0),
                rotation: Rotation3::from_matrix_unchecked(axes),
                sides_m: [LEAF_M[1], LEAF_M[0]],
            });
            Truth::of(&face.transformed(base_from_map), sensor)
        };
        match self {
            Self::DoorOpened => leaf(OPEN_DEG),
            Self::DoorClosed => leaf(0.0),
            Self::Person => Truth {
                class: Class::Cylinder,
                centre: base_from_map * Point3::new(PERSON_AT_M[0], PERSON_AT_M[1], PERSON_M / 2.0),
                rotation: base_from_map.rotation.to_rotation_matrix().into_inner(),
                size_m: [0.4, 0.4, PERSON_M],
                sized: [false, false, true],
                turned: false,
            },
        }
    }
}

fn door(angle_deg: f64) -> String {
    format!(
        "{CORRIDOR}\n[[door]]\nname = 'door'\nhinge = [{}, {}, 0.0]\nyaw_deg = 180.0\nwidth_m = {}\nheight_m = {}\n\
         thickness_m = {THICKNESS_M}\nangle_deg = {angle_deg:?}\n",
        HINGE_M[0], HINGE_M[1], LEAF_M[0], LEAF_M[1]
    )
}

fn person() -> String {
    format!(
        "\n[[person]]\nname = 'person'\nat = [{}, {}, 0.0]\nheight_m = {PERSON_M}\n",
        PERSON_AT_M[0], PERSON_AT_M[1]
    )
}
