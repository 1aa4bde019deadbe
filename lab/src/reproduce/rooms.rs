//! A furnished room in which one thing of any class has come to stand: what the paper left for later, through the whole
//! chain.

use super::constants::{
    FURNISHED_AHEAD_M, FURNISHED_ASIDE_M, FURNISHED_POINTS, FURNISHED_ROWS, FURNISHED_SIZES_M,
    ROOM_TRIES,
};
use super::two_sweeps::{TwoSweeps, two_sweeps};
use super::{Look, LookError, Truth};
use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
use patrold_engine::shape::{
    Class, Cone, Cuboid, Cylinder, Plane, Primitive, Sphere, Superquadric,
};
use patrold_sim::world::{Scene, SceneError};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;
use std::ops::{Range, RangeInclusive};

/// A room 8 m by 6 m, free in the middle.
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

/// Name of what came.
const THING: &str = "thing";

/// One scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Furnished {
    /// What came; `None`: nothing.
    pub class: Option<Class>,
    /// Number of the scene.
    pub number: usize,
}

impl Furnished {
    /// Every class that a thing may have, and nothing.
    pub const CLASSES: [Option<Class>; 7] = [
        Some(Class::Sphere),
        Some(Class::Cylinder),
        Some(Class::Plane),
        Some(Class::Box),
        Some(Class::Cone),
        Some(Class::Superquadric),
        None,
    ];

    /// The two sweeps of this scene under this seed. A thing that shows too few or too many points is drawn again.
    ///
    /// # Errors
    /// Where no draw shows as many points as wanted; a mistake in the text of the scenes.
    pub fn look(self, name: String, seed: u64) -> Result<Look, LookError> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let kind = Self::CLASSES.iter().position(|c| *c == self.class);
        rng.set_stream((self.number as u64) << 8 | 0xc0 | kind.unwrap_or(0) as u64);
        let Some(class) = self.class else {
            let rows = FURNISHED_ROWS[rng.random_range(0..FURNISHED_ROWS.len())];
            let sweeps = two_sweeps([ROOM, ROOM], rows, &mut rng)?;
            return Ok(sweeps.look(name, None, false));
        };
        let drawn = drawn(class, &FURNISHED_POINTS, ROOM_TRIES, &mut rng)?;
        let Some((thing, sweeps)) = drawn else {
            return Err(LookError::Points {
                name,
                tries: ROOM_TRIES,
                least: *FURNISHED_POINTS.start(),
                most: *FURNISHED_POINTS.end(),
            });
        };
        let thing = thing.transformed(&sweeps.base_from_map);
        let truth = Truth::of(&thing, &sweeps.after.view.origin);
        Ok(sweeps.look(name, Some(truth), false))
    }
}

/// The first of `tries` things that shows so many points, and its sweeps.
fn drawn(
    class: Class,
    points: &RangeInclusive<usize>,
    tries: usize,
    rng: &mut ChaCha8Rng,
) -> Result<Option<(Primitive, TwoSweeps)>, SceneError> {
    for _ in 0..tries {
        let rows = FURNISHED_ROWS[rng.random_range(0..FURNISHED_ROWS.len())];
        let thing = stand(class, rng);
        let after = format!("{ROOM}\n{}", text(&thing));
        let object = Scene::parse(&after)?.build(None)?.object_named(THING);
        let sweeps = two_sweeps([ROOM, &after], rows, rng)?;
        let met = sweeps.after.objects.iter().filter(|o| Some(**o) == object);
        if points.contains(&met.count()) {
            return Ok(Some((thing, sweeps)));
        }
    }
    Ok(None)
}

/// A thing on the floor, somewhere in front of the robot.
fn stand(class: Class, rng: &mut ChaCha8Rng) -> Primitive {
    let mut within = |range: Range<f64>| rng.random_range(range);
    let at = |z: f64, x: f64, y: f64| Point3::new(x, y, z);
    let (x, y) = (within(FURNISHED_AHEAD_M), within(FURNISHED_ASIDE_M));
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), within(0.0..TAU));
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
                rotation: turn,
                sides_m,
            })
        }
        Class::Superquadric => {
            let sides_m = [size(), size(), size()];
            Primitive::Superquadric(Superquadric {
                centre: at(sides_m[2] / 2.0, x, y),
                rotation: turn,
                sides_m,
                exponents: [within(0.3..1.7), within(0.3..1.7)],
            })
        }
        Class::Plane | Class::Ambiguous => {
            let sides_m = [2.0 * size(), size()];
            // A board on edge that faces the robot to within some 50 degrees: its long side is upright or level.
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

/// Its table in a scene file.
fn text(thing: &Primitive) -> String {
    let centre: [f64; 3] = thing.centre().coords.into();
    let yaw_deg = |rotation: &Rotation3<f64>| rotation[(1, 0)].atan2(rotation[(0, 0)]).to_degrees();
    let (kind, keys) = match thing {
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
                "[[cone]]\nname = '{THING}'\nbase = {base:?}\nradius_m = {:?}\nheight_m = {:?}\n",
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
    format!("[[{kind}]]\nname = '{THING}'\ncentre = {centre:?}\n{keys}\n")
}

#[cfg(test)]
mod tests {
    use super::{FURNISHED_POINTS, Furnished, drawn, stand, text};
    use nalgebra::{Unit, Vector3};
    use patrold_engine::shape::{Class, Primitive};
    use patrold_sim::world::{Ray, Scene};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn a_thing_that_never_shows_enough_points_is_told_and_none_is_made_up() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let within = |least, most, rng: &mut ChaCha8Rng| {
            drawn(Class::Sphere, &(least..=most), 2, rng).expect("a scene")
        };
        assert!(within(1_000_000, 2_000_000, &mut rng).is_none());
        assert!(within(1, 1_000_000, &mut rng).is_some());
    }

    /// What `ROOM_TRIES` stands on.
    #[test]
    fn most_draws_show_as_many_points_as_they_should() {
        for class in Furnished::CLASSES.into_iter().flatten() {
            let mut rng = ChaCha8Rng::seed_from_u64(6);
            let shows = |_: &u32| {
                let drawn = drawn(class, &FURNISHED_POINTS, 1, &mut rng);
                drawn.expect("a scene").is_some()
            };
            let shown = (0..20).filter(shows).count();
            eprintln!("{class:?}: {shown} of 20");
            assert!(shown > 10, "{class:?}: {shown} of 20");
        }
    }

    /// What is scored as truth and what the rays meet are one thing: rays from all around end on the primitive.
    #[test]
    fn the_scene_holds_the_thing_that_is_called_true() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        for class in Furnished::CLASSES.into_iter().flatten() {
            for _ in 0..20 {
                let thing = stand(class, &mut rng);
                let world = Scene::parse(&text(&thing))
                    .expect("a scene")
                    .build(None)
                    .expect("a world");
                let mut met = 0;
                for k in 0..200 {
                    let (turn, rise) = (f64::from(k) * 2.4, f64::from(k % 9) * 0.3 - 1.2);
                    let from = thing.centre() + Vector3::new(turn.cos(), turn.sin(), rise) * 3.0;
                    let off =
                        Vector3::new((turn * 3.0).sin(), (turn * 5.0).cos(), (turn * 7.0).sin())
                            * 0.15;
                    let direction = Unit::new_normalize(thing.centre() + off - from);
                    let Some(hit) = world.cast(
                        &Ray {
                            origin: from,
                            direction,
                        },
                        10.0,
                    ) else {
                        continue;
                    };
                    met += 1;
                    let at = from + direction.as_ref() * hit.range_m;
                    let distance_m = match &thing {
                        Primitive::Superquadric(s) => s.distance_m(&at),
                        other => other.visible_distance_m(&at, &from),
                    };
                    assert!(distance_m.abs() < 1e-6, "{thing:?} {distance_m} {at:?}");
                }
                assert!(met > 20, "{thing:?} {met}");
            }
        }
    }
}
