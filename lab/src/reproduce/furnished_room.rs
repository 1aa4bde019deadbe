//! A furnished room in which an object of any class appears: what the paper left for later.

use super::constants::{
    FURNISHED_AHEAD_M, FURNISHED_ASIDE_M, FURNISHED_POINTS, FURNISHED_ROWS, FURNISHED_SIZES_M,
    ROOM_MAX_TRIES,
};
use super::error::ScenePairError;
use super::scene_pair::{NoveltyTruth, ScenePair};
use super::sweep_pair::{SweepPair, simulate_sweep_pair};
use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
use patrold_engine::shape::{
    Class, Cone, Cuboid, Cylinder, Plane, Primitive, Sphere, Superquadric,
};
use patrold_sim::world::{Scene, SceneError};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;
use std::ops::{Range, RangeInclusive};

/// A room of 8 m by 6 m, free in the middle.
const ROOM: &str = "
[[room]]
name = 'room'
centre = [1.0, 0.0, 1.3]
size = [8.0, 6.0, 2.6]

[[box]]
name = 'cupboard'
centre = [4.7, -1.6, 1.0]
size = [0.5, 1.2, 2.0]

[[box]]
name = 'counter'
centre = [2.0, 2.7, 0.45]
size = [2.4, 0.6, 0.9]

[[box]]
name = 'bench'
centre = [1.5, -2.75, 0.22]
size = [1.6, 0.4, 0.44]

[[cylinder]]
name = 'pillar'
centre = [4.2, 1.2, 1.3]
radius_m = 0.2
length_m = 2.6
";

/// Name of the new object.
const NEW_OBJECT: &str = "thing";

/// A scene in the furnished room.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct FurnishedRoom {
    /// Class of the new object; `None`: nothing appears.
    pub class: Option<Class>,
    /// Number within its class.
    pub number: usize,
}

impl FurnishedRoom {
    /// All classes of objects, and none.
    pub const CLASSES: [Option<Class>; 7] = [
        Some(Class::Sphere),
        Some(Class::Cylinder),
        Some(Class::Plane),
        Some(Class::Box),
        Some(Class::Cone),
        Some(Class::Superquadric),
        None,
    ];

    /// The two sweeps of this scene under this seed. An object that shows too few or too many points is drawn again.
    ///
    /// # Errors
    /// No object drawn shows as many points as it should; a mistake in the text of the scenes.
    pub fn simulate(self, name: String, seed: u64) -> Result<ScenePair, ScenePairError> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let index = Self::CLASSES.iter().position(|c| *c == self.class);
        rng.set_stream((self.number as u64) << 8 | 0xc0 | index.unwrap_or(0) as u64);
        let Some(class) = self.class else {
            let rows = FURNISHED_ROWS[rng.random_range(0..FURNISHED_ROWS.len())];
            let sweeps = simulate_sweep_pair([ROOM, ROOM], rows, &mut rng)?;
            return Ok(sweeps.into_scene(name, None, false));
        };
        let drawn = draw_visible(class, &FURNISHED_POINTS, ROOM_MAX_TRIES, &mut rng)?;
        let Some((object, sweeps)) = drawn else {
            return Err(ScenePairError::Points {
                name,
                tries: ROOM_MAX_TRIES,
                min: *FURNISHED_POINTS.start(),
                max: *FURNISHED_POINTS.end(),
            });
        };
        let object = object.transformed(&sweeps.base_from_map);
        let truth = NoveltyTruth::of_primitive(&object, &sweeps.after.view.origin);
        Ok(sweeps.into_scene(name, Some(truth), false))
    }
}

/// The first of `tries` random objects that shows so many points, and its sweeps.
fn draw_visible(
    class: Class,
    points: &RangeInclusive<usize>,
    tries: usize,
    rng: &mut ChaCha8Rng,
) -> Result<Option<(Primitive, SweepPair)>, SceneError> {
    for _ in 0..tries {
        let rows = FURNISHED_ROWS[rng.random_range(0..FURNISHED_ROWS.len())];
        let object = draw_object(class, rng);
        let after = format!("{ROOM}\n{}", scene_table(&object));
        let index = Scene::parse(&after)?.build(None)?.object_named(NEW_OBJECT);
        let sweeps = simulate_sweep_pair([ROOM, &after], rows, rng)?;
        let hits = sweeps.after.objects.iter().filter(|o| Some(**o) == index);
        if points.contains(&hits.count()) {
            return Ok(Some((object, sweeps)));
        }
    }
    Ok(None)
}

/// A random object on the floor in front of the robot.
fn draw_object(class: Class, rng: &mut ChaCha8Rng) -> Primitive {
    let mut within = |range: Range<f64>| rng.random_range(range);
    let at = |z: f64, x: f64, y: f64| Point3::new(x, y, z);
    let (x, y) = (within(FURNISHED_AHEAD_M), within(FURNISHED_ASIDE_M));
    let rotation = Rotation3::from_axis_angle(&Vector3::z_axis(), within(0.0..TAU));
    let mut size = || within(FURNISHED_SIZES_M);
    match class {
        Class::Sphere => {
            let radius_m = size() / 2.0;
            Primitive::Sphere(Sphere {
                centre: at(radius_m, x, y),
                radius_m,
            })
        }
        Class::Cylinder => {
            let (radius_m, length_m) = (size() / 3.0, 1.5 * size());
            Primitive::Cylinder(Cylinder {
                centre: at(length_m / 2.0, x, y),
                axis: Vector3::z_axis(),
                radius_m,
                length_m,
            })
        }
        Class::Cone => {
            let (radius_m, height_m) = (size() / 2.0, size() + 0.1);
            Primitive::Cone(Cone {
                centre: at(height_m / 2.0, x, y),
                axis: Vector3::z_axis(),
                radius_m,
                height_m,
            })
        }
        Class::Box => {
            let sides_m = [size(), size(), size()];
            Primitive::Cuboid(Cuboid {
                centre: at(sides_m[2] / 2.0, x, y),
                rotation,
                sides_m,
            })
        }
        Class::Superquadric => {
            let sides_m = [size(), size(), size()];
            Primitive::Superquadric(Superquadric {
                centre: at(sides_m[2] / 2.0, x, y),
                rotation,
                sides_m,
                exponents: [within(0.3..1.7), within(0.3..1.7)],
            })
        }
        Class::Plane | Class::Ambiguous => {
            let sides_m = [2.0 * size(), size()];
            // On edge, facing the robot to within some 50 degrees.
            let facing = y.atan2(x) + within(-0.85..0.85);
            let normal = -Vector3::new(facing.cos(), facing.sin(), 0.0);
            let level = Vector3::z().cross(&normal);
            let axes = Matrix3::from_columns(&[level, Vector3::z(), normal]);
            Primitive::Plane(Plane {
                centre: at(sides_m[1] / 2.0, x, y),
                rotation: Rotation3::from_matrix_unchecked(axes),
                sides_m,
            })
        }
    }
}

/// The table of a scene file for an object.
fn scene_table(object: &Primitive) -> String {
    let centre: [f64; 3] = object.centre().coords.into();
    let yaw_deg = |rotation: &Rotation3<f64>| rotation[(1, 0)].atan2(rotation[(0, 0)]).to_degrees();
    let (kind, keys) = match object {
        Primitive::Sphere(s) => ("sphere", format!("radius_m = {:?}", s.radius_m)),
        Primitive::Cylinder(c) => (
            "cylinder",
            format!("radius_m = {:?}\nlength_m = {:?}", c.radius_m, c.length_m),
        ),
        Primitive::Plane(p) => (
            "plane",
            format!(
                "normal = {:?}\nsize = {:?}",
                <[f64; 3]>::from(p.normal()),
                p.sides_m
            ),
        ),
        Primitive::Cuboid(b) => (
            "box",
            format!(
                "size = {:?}\nyaw_deg = {:?}",
                b.sides_m,
                yaw_deg(&b.rotation)
            ),
        ),
        Primitive::Cone(c) => {
            let base: [f64; 3] = (c.centre - Vector3::z() * (c.height_m / 2.0)).coords.into();
            return format!(
                "[[cone]]\nname = '{NEW_OBJECT}'\nbase = {base:?}\nradius_m = {:?}\nheight_m = {:?}\n",
                c.radius_m, c.height_m
            );
        }
        Primitive::Superquadric(s) => (
            "superquadric",
            format!(
                "size = {:?}\nexponents = {:?}\nyaw_deg = {:?}",
                s.sides_m,
                s.exponents,
                yaw_deg(&s.rotation)
            ),
        ),
    };
    format!("[[{kind}]]\nname = '{NEW_OBJECT}'\ncentre = {centre:?}\n{keys}\n")
}

#[cfg(test)]
mod tests {
    use super::{FURNISHED_POINTS, FurnishedRoom, draw_object, draw_visible, scene_table};
    use nalgebra::{Unit, Vector3};
    use patrold_engine::shape::{Class, Primitive};
    use patrold_sim::world::{Ray, Scene};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn no_object_is_returned_where_none_shows_enough_points() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let visible = |min, max, rng: &mut ChaCha8Rng| {
            draw_visible(Class::Sphere, &(min..=max), 2, rng).expect("a scene")
        };
        assert!(visible(1_000_000, 2_000_000, &mut rng).is_none());
        assert!(visible(1, 1_000_000, &mut rng).is_some());
    }

    /// The reason of `ROOM_MAX_TRIES`.
    #[test]
    fn most_draws_show_as_many_points_as_they_should() {
        for class in FurnishedRoom::CLASSES.into_iter().flatten() {
            let mut rng = ChaCha8Rng::seed_from_u64(6);
            let shows = |_: &u32| {
                let drawn = draw_visible(class, &FURNISHED_POINTS, 1, &mut rng);
                drawn.expect("a scene").is_some()
            };
            let shown = (0..20).filter(shows).count();
            eprintln!("{class:?}: {shown} of 20");
            assert!(shown > 10, "{class:?}: {shown} of 20");
        }
    }

    /// Rays from all around end on the primitive that is scored as truth.
    #[test]
    fn the_scene_holds_the_true_object() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        for class in FurnishedRoom::CLASSES.into_iter().flatten() {
            for _ in 0..20 {
                let object = draw_object(class, &mut rng);
                let world = Scene::parse(&scene_table(&object))
                    .expect("a scene")
                    .build(None)
                    .expect("a world");
                let mut hits = 0;
                for k in 0..200 {
                    let (turn, rise) = (f64::from(k) * 2.4, f64::from(k % 9) * 0.3 - 1.2);
                    let from = object.centre() + Vector3::new(turn.cos(), turn.sin(), rise) * 3.0;
                    let off =
                        Vector3::new((turn * 3.0).sin(), (turn * 5.0).cos(), (turn * 7.0).sin())
                            * 0.15;
                    let direction = Unit::new_normalize(object.centre() + off - from);
                    let Some(hit) = world.cast(
                        &Ray {
                            origin: from,
                            direction,
                        },
                        10.0,
                    ) else {
                        continue;
                    };
                    hits += 1;
                    let at = from + direction.as_ref() * hit.range_m;
                    let distance_m = match &object {
                        Primitive::Superquadric(s) => s.distance_m(&at),
                        other => other.visible_distance_m(&at, &from),
                    };
                    assert!(distance_m.abs() < 1e-6, "{object:?} {distance_m} {at:?}");
                }
                assert!(hits > 20, "{object:?} {hits}");
            }
        }
    }
}
