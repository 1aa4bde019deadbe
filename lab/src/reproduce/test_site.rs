//! The three test sites of paper section V.B, Fig. 6, each a place of its own: a door opened in an office, a person in a
//! corridor, a door closed in a laboratory.

use super::constants::{DOOR_THICKNESS_M, PERSON_HEIGHT_M, PERSON_POSITION_M, REPEATS, SITE_ROWS};
use super::error::ScenePairError;
use super::scene_pair::{NoveltyTruth, ScenePair};
use super::site_scene::{
    CORRIDOR, CORRIDOR_DOOR, LABORATORY, LABORATORY_DOOR, OFFICE, OFFICE_DOOR, SiteDoor,
};
use super::sweep_pair::simulate_sweep_pair;
use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
use patrold_engine::geometry::Pose;
use patrold_engine::shape::{Class, Plane, Primitive};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// A test site.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TestSite {
    /// Fig. 6a: a door opened, in an office.
    DoorOpened,
    /// Fig. 6b: a person in the corridor.
    Person,
    /// Fig. 6c: a door closed, in a laboratory.
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
        let [before, after] = self.scenes();
        let sweeps = simulate_sweep_pair([&before, &after], SITE_ROWS, &mut rng)?;
        let truth = self.truth(&sweeps.base_from_map, &sweeps.after.view.origin);
        let name = format!("{}-{repeat}", self.as_str());
        Ok(sweeps.into_scene(name, Some(truth), self != Self::Person))
    }

    /// The text of the scene before and after.
    fn scenes(self) -> [String; 2] {
        let with_door =
            |place: &str, door: &SiteDoor, angle_deg| place.to_owned() + &door.table(angle_deg);
        match self {
            Self::DoorOpened => {
                [0.0, OFFICE_DOOR.open_deg].map(|a| with_door(OFFICE, &OFFICE_DOOR, a))
            }
            Self::Person => {
                let empty = with_door(CORRIDOR, &CORRIDOR_DOOR, 0.0);
                let occupied = empty.clone() + &person();
                [empty, occupied]
            }
            Self::DoorClosed => {
                [LABORATORY_DOOR.open_deg, 0.0].map(|a| with_door(LABORATORY, &LABORATORY_DOOR, a))
            }
        }
    }

    fn truth(self, base_from_map: &Pose, sensor: &Point3<f64>) -> NoveltyTruth {
        let leaf = |door: &SiteDoor, angle_deg: f64| {
            let (along, middle) = door.leaf(angle_deg);
            let normal = Vector3::z().cross(&along);
            let axes = Matrix3::from_columns(&[Vector3::z(), along, normal]);
            // The face towards the sensor.
            let side = (base_from_map.inverse() * sensor - middle)
                .dot(&normal)
                .signum();
            let [width_m, height_m] = door.leaf_m;
            let face = Primitive::Plane(Plane {
                centre: middle + normal * (side * DOOR_THICKNESS_M / 2.0),
                rotation: Rotation3::from_matrix_unchecked(axes),
                sides_m: [height_m, width_m],
            });
            NoveltyTruth::of_primitive(&face.transformed(base_from_map), sensor)
        };
        match self {
            Self::DoorOpened => leaf(&OFFICE_DOOR, OFFICE_DOOR.open_deg),
            Self::DoorClosed => leaf(&LABORATORY_DOOR, 0.0),
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

fn person() -> String {
    format!(
        "\n[[person]]\nname = 'person'\nat = [{}, {}, 0.0]\nheight_m = {PERSON_HEIGHT_M}\n",
        PERSON_POSITION_M[0], PERSON_POSITION_M[1]
    )
}

#[cfg(test)]
mod tests {
    use super::{ScenePair, TestSite};
    use nalgebra::Point3;

    /// Points on the middle of the true object: three quarters of each length, and within 10 cm of a door's face.
    fn points_on_truth(scene: &ScenePair, points: &[Point3<f64>]) -> usize {
        let truth = scene.truth.as_ref().expect("an object");
        let on = |p: &&Point3<f64>| {
            let own = truth.rotation.transpose() * (*p - truth.centre);
            (0..3).all(|k| own[k].abs() <= (0.75 * truth.size_m[k] / 2.0).max(0.1))
        };
        points.iter().filter(on).count()
    }

    #[test]
    fn the_novelty_of_every_site_is_seen_where_the_truth_is_and_not_before() {
        for site in TestSite::ALL {
            let scene = site.simulate(1, 5).expect("a scene");
            let on = points_on_truth(&scene, &scene.current.points);
            assert!(on > 1000, "{site:?}: {on}");
            // The frames differ by 3 cm and 1.5 degrees at most.
            let before = points_on_truth(&scene, &scene.reference.points);
            assert!(100 * before < on, "{site:?}: {before} before, {on} now");
        }
    }

    #[test]
    fn the_sites_are_three_places() {
        // Nearest rank of .02 and .98 of the points along each axis.
        let extent = |site: TestSite| {
            let scene = site.simulate(0, 5).expect("a scene");
            [0, 1, 2].map(|k| {
                let mut along: Vec<f64> = scene.reference.points.iter().map(|p| p[k]).collect();
                along.sort_by(f64::total_cmp);
                let rank = |share: f64| along[(share * along.len() as f64) as usize];
                rank(0.98) - rank(0.02)
            })
        };
        let extents = TestSite::ALL.map(extent);
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            let differs = (0..3).any(|k| (extents[i][k] - extents[j][k]).abs() > 0.5);
            assert!(differs, "{i} and {j}: {extents:?}");
        }
    }
}
