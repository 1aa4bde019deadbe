//! The corridor of 400 points with one thing in it (section V.A).

use super::constants::{
    BALL_RADIUS_M, CLEARANCE_M, CORRIDOR_M, CORRIDOR_POINTS, CYLINDER_LENGTH_M, CYLINDER_RADIUS_M,
    FEW, FIELD_DEG, FINE_SIGMA_M, LEAN_RAD, MANY, PLACE_M, PLANE_SIDES_M, PRINTED_VARIANCE_M2,
    SCENES, SLANT_RAD, TRIES,
};
use super::{Look, LookError, Truth};
use nalgebra::{Matrix3, Point3, Rotation3, Unit, Vector3};
use patrold_engine::geometry::View;
use patrold_engine::shape::{Cylinder, Plane, Primitive, Sphere};
use patrold_sim::world::{Ray, Scene, SceneError, World};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// What stands in the corridor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Thing {
    /// A ball.
    Sphere,
    /// A round bar.
    Cylinder,
    /// A board.
    Plane,
    /// Nothing.
    Nothing,
}

impl Thing {
    /// Every one.
    pub const ALL: [Self; 4] = [Self::Sphere, Self::Cylinder, Self::Plane, Self::Nothing];

    /// Its word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Sphere => "sphere",
            Self::Cylinder => "cylinder",
            Self::Plane => "plane",
            Self::Nothing => "empty",
        }
    }
}

/// How the noise of section V is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Noise {
    /// Variance 0.001 m^2, as printed: 3.2 cm.
    Printed,
    /// Standard deviation 0.001 m.
    Fine,
}

impl Noise {
    /// Standard deviation on every coordinate, metres.
    pub fn sigma_m(self) -> f64 {
        match self {
            Self::Printed => PRINTED_VARIANCE_M2.sqrt(),
            Self::Fine => FINE_SIGMA_M,
        }
    }
}

/// How many points the thing has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Density {
    /// 60-120.
    Many,
    /// 15-30.
    Few,
}

impl Density {
    fn range(self) -> [usize; 2] {
        match self {
            Self::Many => MANY,
            Self::Few => FEW,
        }
    }
}

/// How the beams that meet the thing lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Beams {
    /// In even rows, as those of a laser range finder, at a phase and turn of their own.
    Rows,
    /// At random; where an edge is, is then known less well.
    Scattered,
}

/// Which scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Corridor {
    /// What stands in it.
    pub thing: Thing,
    /// Noise.
    pub noise: Noise,
    /// Points on the thing.
    pub density: Density,
    /// How its beams lie.
    pub beams: Beams,
    /// Number of the scene.
    pub number: usize,
}

impl Corridor {
    /// Scenes of each class (section V).
    pub const SCENES: usize = SCENES;

    /// `sphere-17`.
    pub fn name(&self) -> String {
        format!("{}-{}", self.thing.word(), self.number)
    }

    /// The scene of this plan under this seed: the empty corridor, and the corridor now.
    ///
    /// # Errors
    /// Where no draw stands clear of the walls; a mistake in the text of the scenes.
    pub fn look(&self, seed: u64) -> Result<Look, LookError> {
        let stream = (self.number as u64) << 8
            | match self.thing {
                Thing::Sphere => 0,
                Thing::Cylinder => 1,
                Thing::Plane => 2,
                Thing::Nothing => 3,
            } << 4
            | match (self.noise, self.density) {
                (Noise::Printed, Density::Many) => 0,
                (Noise::Printed, Density::Few) => 1,
                (Noise::Fine, Density::Many) => 2,
                (Noise::Fine, Density::Few) => 3,
            };
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(stream);
        let thing = draw(self.thing, &mut rng);
        if thing.is_none() && self.thing != Thing::Nothing {
            return Err(LookError::NotClear {
                name: self.name(),
                tries: TRIES,
            });
        }
        let empty = world(None)?;
        let now = world(thing.as_ref())?;
        let sigma_m = self.noise.sigma_m();
        let reference = rows(&empty, sigma_m, &mut rng);
        let mut current = rows(&now, sigma_m, &mut rng);
        if let Some(thing) = &thing {
            let [least, most] = self.density.range();
            let wanted = rng.random_range(least..=most);
            let walls = current.into_iter().filter(|(_, object)| *object == 0);
            current = walls.collect();
            let seen = on(thing, &now, self.beams, [least, wanted, most], &mut rng);
            current.extend(seen.into_iter().map(|p| (noisy(p, sigma_m, &mut rng), 1)));
        }
        let view = |points: Vec<(Point3<f64>, usize)>| {
            View::bare(points.into_iter().map(|p| p.0).collect(), Point3::origin())
        };
        Ok(Look {
            name: self.name(),
            reference: view(reference),
            current: view(current),
            truth: thing.map(|t| Truth::of(&t, &Point3::origin())),
            vacated: false,
        })
    }
}

/// A thing that stands clear of the walls.
fn draw(thing: Thing, rng: &mut ChaCha8Rng) -> Option<Primitive> {
    for _ in 0..TRIES {
        let centre = Point3::from(PLACE_M.map(|[from, to]| rng.random_range(from..to)));
        let mut within = |[from, to]: [f64; 2]| rng.random_range(from..to);
        let primitive = match thing {
            Thing::Nothing => return None,
            Thing::Sphere => Primitive::Sphere(Sphere {
                centre,
                radius_m: within(BALL_RADIUS_M),
            }),
            Thing::Cylinder => {
                let (lean, way) = (
                    within([0.0, LEAN_RAD]),
                    within([0.0, std::f64::consts::TAU]),
                );
                let axis = Vector3::new(lean.sin() * way.cos(), lean.sin() * way.sin(), lean.cos());
                Primitive::Cylinder(Cylinder {
                    centre,
                    axis: Unit::new_normalize(axis),
                    radius_m: within(CYLINDER_RADIUS_M),
                    length_m: within(CYLINDER_LENGTH_M),
                })
            }
            Thing::Plane => {
                let (slant, way) = (
                    within([0.0, SLANT_RAD]),
                    within([0.0, std::f64::consts::TAU]),
                );
                let view = Unit::new_normalize(-centre.coords);
                let across = view.cross(&Vector3::z()).normalize();
                let up = across.cross(&view);
                let normal = view.as_ref() * slant.cos()
                    + (across * way.cos() + up * way.sin()) * slant.sin();
                Primitive::Plane(Plane {
                    centre,
                    rotation: board(&normal, within([0.0, std::f64::consts::PI])),
                    sides_m: PLANE_SIDES_M.map(&mut within),
                })
            }
        };
        if stands_clear(&primitive) {
            return Some(primitive);
        }
    }
    None
}

/// Axes of a board: its first side lies level, then turned about the normal.
fn board(normal: &Vector3<f64>, spin_rad: f64) -> Rotation3<f64> {
    let normal = normal.normalize();
    let level = Vector3::z().cross(&normal).normalize();
    let axes = Matrix3::from_columns(&[level, normal.cross(&level), normal]);
    Rotation3::from_matrix_unchecked(axes)
        * Rotation3::from_axis_angle(&Vector3::z_axis(), spin_rad)
}

fn stands_clear(primitive: &Primitive) -> bool {
    let axes = primitive.rotation(&Point3::origin());
    let size = primitive.size_m();
    let centre = primitive.centre();
    (0..3).all(|k| {
        let half = match primitive {
            Primitive::Sphere(s) => s.radius_m,
            _ => (0..3).map(|j| axes[(k, j)].abs() * size[j] / 2.0).sum(),
        };
        centre[k] - half >= CORRIDOR_M[0][k] + CLEARANCE_M
            && centre[k] + half <= CORRIDOR_M[1][k] - CLEARANCE_M
    })
}

/// The corridor, and in it the thing as object 1.
fn world(thing: Option<&Primitive>) -> Result<World, SceneError> {
    let [low, high] = CORRIDOR_M;
    let middle = [0, 1, 2].map(|k| f64::midpoint(low[k], high[k]));
    let size = [0, 1, 2].map(|k| high[k] - low[k]);
    let mut text = format!("[[room]]\ncentre = {middle:?}\nsize = {size:?}\n");
    let list = |v: Vector3<f64>| format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z);
    match thing {
        // `draw` knows the paper's three classes alone.
        None | Some(Primitive::Cuboid(_) | Primitive::Cone(_) | Primitive::Superquadric(_)) => {}
        Some(Primitive::Sphere(s)) => {
            let centre = list(s.centre.coords);
            text += &format!(
                "[[sphere]]\ncentre = {centre}\nradius_m = {:?}\n",
                s.radius_m
            );
        }
        Some(Primitive::Cylinder(c)) => {
            text += &format!(
                "[[cylinder]]\ncentre = {}\naxis = {}\nradius_m = {:?}\nlength_m = {:?}\n",
                list(c.centre.coords),
                list(c.axis.into_inner()),
                c.radius_m,
                c.length_m
            );
        }
        Some(Primitive::Plane(p)) => {
            let normal = p.normal();
            let level = board(&normal, 0.0);
            let turned = level.inverse() * p.rotation;
            let spin_deg = turned[(1, 0)].atan2(turned[(0, 0)]).to_degrees();
            text += &format!(
                "[[plane]]\ncentre = {}\nnormal = {}\nsize = {:?}\nspin_deg = {spin_deg:?}\n",
                list(p.centre.coords),
                list(normal),
                p.sides_m
            );
        }
    }
    Scene::parse(&text)?.build(None)
}

fn noisy(at: Point3<f64>, sigma_m: f64, rng: &mut ChaCha8Rng) -> Point3<f64> {
    let noise: [f64; 3] = std::array::from_fn(|_| StandardNormal.sample(rng));
    at + Vector3::from(noise) * sigma_m
}

/// 400 beams in even rows over the field, each scan with its own phase; what they meet, and which object it is.
fn rows(world: &World, sigma_m: f64, rng: &mut ChaCha8Rng) -> Vec<(Point3<f64>, usize)> {
    let side = (CORRIDOR_POINTS as f64).sqrt() as usize;
    let phase: [f64; 2] = [rng.random(), rng.random()];
    let angle = |k: usize, which: usize| {
        let share = (k as f64 + phase[which]) / side as f64;
        (2.0 * share - 1.0) * FIELD_DEG[which].to_radians()
    };
    let mut points = Vec::with_capacity(CORRIDOR_POINTS);
    for row in 0..side {
        for column in 0..side {
            let (azimuth, elevation) = (angle(column, 0), angle(row, 1));
            let direction = Unit::new_unchecked(Vector3::new(
                azimuth.cos() * elevation.cos(),
                azimuth.sin() * elevation.cos(),
                elevation.sin(),
            ));
            if let Some((p, object)) = met(world, direction) {
                points.push((noisy(p, sigma_m, rng), object));
            }
        }
    }
    points
}

fn met(world: &World, direction: Unit<Vector3<f64>>) -> Option<(Point3<f64>, usize)> {
    let ray = Ray {
        origin: Point3::origin(),
        direction,
    };
    let hit = world.cast(&ray, f64::INFINITY)?;
    Some((
        ray.origin + direction.into_inner() * hit.range_m,
        hit.object,
    ))
}

/// Points of the side of the thing that the sensor sees, even in solid angle: about `wanted`, at least `least` and at
/// most `most` of them.
fn on(
    thing: &Primitive,
    world: &World,
    beams: Beams,
    [least, wanted, most]: [usize; 3],
    rng: &mut ChaCha8Rng,
) -> Vec<Point3<f64>> {
    let to = thing.centre().coords;
    let half = thing.size_m().iter().map(|s| s * s).sum::<f64>().sqrt() / 2.0;
    let axis = to.normalize();
    let across = axis.cross(&Vector3::z()).normalize();
    let up = across.cross(&axis);
    let cast = |direction: Vector3<f64>| match met(world, Unit::new_normalize(direction)) {
        Some((p, 1)) => Some(p),
        _ => None,
    };
    // Rows on the plane at unit distance, which is even in solid angle to a per cent within the small field of a thing.
    let window = half / (to.norm_squared() - half * half).max(0.01).sqrt();
    let phase: [f64; 2] = [rng.random(), rng.random()];
    let (sin, cos) = rng.random_range(0.0..std::f64::consts::TAU).sin_cos();
    let rows = |step: f64| -> Vec<Point3<f64>> {
        let reach = (1.5 * window / step).ceil() as i32;
        let at = |k: i32, which: usize| (f64::from(k) + phase[which]) * step;
        let lines = (-reach..=reach).flat_map(|i| (-reach..=reach).map(move |k| (i, k)));
        lines
            .filter_map(|(i, k)| {
                let (u, v) = (at(i, 0), at(k, 1));
                let (u, v) = (u * cos - v * sin, u * sin + v * cos);
                cast(axis + across * u + up * v)
            })
            .collect()
    };
    if beams == Beams::Rows {
        let probe = rows(window / 20.0).len().max(1) as f64;
        let mut step = window / 20.0 * (probe / wanted as f64).sqrt();
        for _ in 0..TRIES {
            let points = rows(step);
            if points.len() < least {
                step *= 0.98;
            } else if points.len() > most {
                step *= 1.01;
            } else {
                return points;
            }
        }
    }
    let nearest = (1.0 - (half / to.norm()).powi(2)).max(0.0).sqrt();
    let mut points = Vec::with_capacity(wanted);
    for _ in 0..TRIES.max(1000 * wanted) {
        if points.len() == wanted {
            break;
        }
        let c: f64 = rng.random_range(nearest..1.0);
        let way: f64 = rng.random_range(0.0..std::f64::consts::TAU);
        let s = (1.0 - c * c).max(0.0).sqrt();
        points.extend(cast(axis * c + (across * way.cos() + up * way.sin()) * s));
    }
    points
}

#[cfg(test)]
mod tests {
    use super::{Beams, Corridor, Density, Noise, Thing};
    use patrold_engine::shape::Class;

    fn plan(thing: Thing, number: usize) -> Corridor {
        Corridor {
            thing,
            noise: Noise::Fine,
            density: Density::Many,
            beams: if number.is_multiple_of(2) {
                Beams::Rows
            } else {
                Beams::Scattered
            },
            number,
        }
    }

    #[test]
    fn things_have_their_points_on_the_side_that_is_seen() {
        for thing in [Thing::Sphere, Thing::Cylinder, Thing::Plane] {
            for number in 0..10 {
                let look = plan(thing, number).look(3).expect("a scene");
                let truth = look.truth.expect("a thing");
                assert!((390..=400).contains(&look.reference.points.len()));
                let reach = truth.size_m.iter().map(|s| s * s).sum::<f64>().sqrt() / 2.0 + 0.01;
                let near = |p: &&nalgebra::Point3<f64>| (*p - truth.centre).norm() < reach;
                let on = look.current.points.iter().filter(near).count();
                assert!((60..=120).contains(&on), "{} {on}", look.name);
                let v = truth.centre.coords.normalize();
                if truth.class == Class::Sphere {
                    let facing =
                        |p: &&nalgebra::Point3<f64>| near(p) && (*p - truth.centre).dot(&v) < 0.01;
                    assert_eq!(look.current.points.iter().filter(facing).count(), on);
                }
            }
        }
    }

    #[test]
    fn a_scene_depends_on_its_seed_and_name_alone() {
        let look = |seed| plan(Thing::Plane, 4).look(seed).expect("a scene");
        assert_eq!(look(1).current.points, look(1).current.points);
        assert_ne!(look(1).current.points, look(2).current.points);
        assert!(
            plan(Thing::Nothing, 1)
                .look(1)
                .expect("a scene")
                .truth
                .is_none()
        );
    }
}
