//! The corridor of 400 points with one object in it (paper section V.A).

use super::constants::{
    CLEARANCE_M, CORRIDOR_BOUNDS_M, CORRIDOR_POINTS, CYLINDER_LENGTH_M, CYLINDER_RADIUS_M,
    FEW_POINTS, FIELD_DEG, FINE_SIGMA_M, MANY_POINTS, MAX_LEAN_RAD, MAX_SLANT_RAD, MAX_TRIES,
    OBJECT_POSITION_M, PLANE_SIDES_M, PRINTED_VARIANCE_M2, SCENES_PER_CLASS, SPHERE_RADIUS_M,
};
use super::error::ScenePairError;
use super::scene_pair::{NoveltyTruth, ScenePair};
use nalgebra::{Matrix3, Point3, Rotation3, Unit, Vector3};
use patrold_engine::geometry::View;
use patrold_engine::shape::{Cylinder, Plane, Primitive, Sphere};
use patrold_sim::world::{Ray, Scene, SceneError, World};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// The object in the corridor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CorridorObject {
    /// A sphere.
    Sphere,
    /// A cylinder.
    Cylinder,
    /// A rectangle.
    Plane,
    /// Nothing new.
    Nothing,
}

impl CorridorObject {
    /// All, in the order of the tables.
    pub const ALL: [Self; 4] = [Self::Sphere, Self::Cylinder, Self::Plane, Self::Nothing];

    /// The name in tables and in names of scenes.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Sphere => "sphere",
            Self::Cylinder => "cylinder",
            Self::Plane => "plane",
            Self::Nothing => "empty",
        }
    }
}

/// The reading of the noise of paper section V.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CorridorNoise {
    /// Variance 0.001 m^2, as printed: 3.2 cm.
    Printed,
    /// Standard deviation 0.001 m.
    Fine,
}

impl CorridorNoise {
    /// Standard deviation of every coordinate, metres.
    pub fn sigma_m(self) -> f64 {
        match self {
            Self::Printed => PRINTED_VARIANCE_M2.sqrt(),
            Self::Fine => FINE_SIGMA_M,
        }
    }
}

/// The number of points on the object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PointDensity {
    /// 60-120.
    Many,
    /// 15-30.
    Few,
}

impl PointDensity {
    fn range(self) -> [usize; 2] {
        match self {
            Self::Many => MANY_POINTS,
            Self::Few => FEW_POINTS,
        }
    }
}

/// The layout of the beams that hit the object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum BeamLayout {
    /// Even rows, as of a laser range finder, at a random phase and rotation.
    Rows,
    /// Random, which leaves edges less certain.
    Scattered,
}

/// A scene in the corridor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct CorridorScene {
    /// The object in it.
    pub object: CorridorObject,
    /// Noise of the points.
    pub noise: CorridorNoise,
    /// Points on the object.
    pub density: PointDensity,
    /// Beams on the object.
    pub beams: BeamLayout,
    /// Number within its class.
    pub number: usize,
}

impl CorridorScene {
    /// Scenes of each class (paper section V).
    pub const SCENES_PER_CLASS: usize = SCENES_PER_CLASS;

    /// The name by which it can be run alone, such as `sphere-17`.
    pub fn name(&self) -> String {
        format!("{}-{}", self.object.as_str(), self.number)
    }

    /// The empty corridor, and the corridor with the object, under this seed.
    ///
    /// # Errors
    /// No object drawn is clear of the walls; a mistake in the text of the scenes.
    pub fn simulate(&self, seed: u64) -> Result<ScenePair, ScenePairError> {
        let stream = (self.number as u64) << 8
            | match self.object {
                CorridorObject::Sphere => 0,
                CorridorObject::Cylinder => 1,
                CorridorObject::Plane => 2,
                CorridorObject::Nothing => 3,
            } << 4
            | match (self.noise, self.density) {
                (CorridorNoise::Printed, PointDensity::Many) => 0,
                (CorridorNoise::Printed, PointDensity::Few) => 1,
                (CorridorNoise::Fine, PointDensity::Many) => 2,
                (CorridorNoise::Fine, PointDensity::Few) => 3,
            };
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(stream);
        let object = draw_object(self.object, &mut rng);
        if object.is_none() && self.object != CorridorObject::Nothing {
            return Err(ScenePairError::NotClear {
                name: self.name(),
                tries: MAX_TRIES,
            });
        }
        let empty = world(None)?;
        let occupied = world(object.as_ref())?;
        let sigma_m = self.noise.sigma_m();
        let reference = rows(&empty, sigma_m, &mut rng);
        let mut current = rows(&occupied, sigma_m, &mut rng);
        if let Some(object) = &object {
            let [min, max] = self.density.range();
            let wanted = rng.random_range(min..=max);
            current.retain(|(_, index)| *index == 0);
            let seen = points_on(object, &occupied, self.beams, [min, wanted, max], &mut rng);
            current.extend(seen.into_iter().map(|p| (noisy(p, sigma_m, &mut rng), 1)));
        }
        let view = |points: Vec<(Point3<f64>, usize)>| {
            View::from_points(points.into_iter().map(|p| p.0).collect(), Point3::origin())
        };
        Ok(ScenePair {
            name: self.name(),
            reference: view(reference),
            current: view(current),
            truth: object.map(|o| NoveltyTruth::of_primitive(&o, &Point3::origin())),
            vacated: false,
        })
    }
}

/// A random object that is clear of the walls.
fn draw_object(object: CorridorObject, rng: &mut ChaCha8Rng) -> Option<Primitive> {
    for _ in 0..MAX_TRIES {
        let centre = Point3::from(OBJECT_POSITION_M.map(|[from, to]| rng.random_range(from..to)));
        let mut within = |[from, to]: [f64; 2]| rng.random_range(from..to);
        let primitive = match object {
            CorridorObject::Nothing => return None,
            CorridorObject::Sphere => Primitive::Sphere(Sphere {
                centre,
                radius_m: within(SPHERE_RADIUS_M),
            }),
            CorridorObject::Cylinder => {
                let (lean, direction) = (
                    within([0.0, MAX_LEAN_RAD]),
                    within([0.0, std::f64::consts::TAU]),
                );
                let axis = Vector3::new(
                    lean.sin() * direction.cos(),
                    lean.sin() * direction.sin(),
                    lean.cos(),
                );
                Primitive::Cylinder(Cylinder {
                    centre,
                    axis: Unit::new_normalize(axis),
                    radius_m: within(CYLINDER_RADIUS_M),
                    length_m: within(CYLINDER_LENGTH_M),
                })
            }
            CorridorObject::Plane => {
                let (slant, direction) = (
                    within([0.0, MAX_SLANT_RAD]),
                    within([0.0, std::f64::consts::TAU]),
                );
                let view = Unit::new_normalize(-centre.coords);
                let across = view.cross(&Vector3::z()).normalize();
                let up = across.cross(&view);
                let normal = view.as_ref() * slant.cos()
                    + (across * direction.cos() + up * direction.sin()) * slant.sin();
                Primitive::Plane(Plane {
                    centre,
                    rotation: plane_axes(&normal, within([0.0, std::f64::consts::PI])),
                    sides_m: PLANE_SIDES_M.map(&mut within),
                })
            }
        };
        if is_clear_of_walls(&primitive) {
            return Some(primitive);
        }
    }
    None
}

/// Axes of a plane: its first side level, then rotated about the normal.
fn plane_axes(normal: &Vector3<f64>, spin_rad: f64) -> Rotation3<f64> {
    let normal = normal.normalize();
    let level = Vector3::z().cross(&normal).normalize();
    let axes = Matrix3::from_columns(&[level, normal.cross(&level), normal]);
    Rotation3::from_matrix_unchecked(axes)
        * Rotation3::from_axis_angle(&Vector3::z_axis(), spin_rad)
}

fn is_clear_of_walls(primitive: &Primitive) -> bool {
    let axes = primitive.canonical_rotation(&Point3::origin());
    let size = primitive.size_m();
    let centre = primitive.centre();
    (0..3).all(|k| {
        let half = match primitive {
            Primitive::Sphere(s) => s.radius_m,
            _ => (0..3).map(|j| axes[(k, j)].abs() * size[j] / 2.0).sum(),
        };
        centre[k] - half >= CORRIDOR_BOUNDS_M[0][k] + CLEARANCE_M
            && centre[k] + half <= CORRIDOR_BOUNDS_M[1][k] - CLEARANCE_M
    })
}

/// The corridor, and in it the object as number 1 of the world.
fn world(object: Option<&Primitive>) -> Result<World, SceneError> {
    let [low, high] = CORRIDOR_BOUNDS_M;
    let middle = [0, 1, 2].map(|k| f64::midpoint(low[k], high[k]));
    let size = [0, 1, 2].map(|k| high[k] - low[k]);
    let mut text = format!("[[room]]\ncentre = {middle:?}\nsize = {size:?}\n");
    let list = |v: Vector3<f64>| format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z);
    match object {
        // `draw_object` draws the three classes of the paper alone.
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
            let level = plane_axes(&normal, 0.0);
            let spin = level.inverse() * p.rotation;
            let spin_deg = spin[(1, 0)].atan2(spin[(0, 0)]).to_degrees();
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

/// 400 beams in even rows over the field at a random phase: the points that they hit, and the number of the object.
fn rows(world: &World, sigma_m: f64, rng: &mut ChaCha8Rng) -> Vec<(Point3<f64>, usize)> {
    let side = (CORRIDOR_POINTS as f64).sqrt() as usize;
    let phase: [f64; 2] = [rng.random(), rng.random()];
    let angle = |k: usize, axis: usize| {
        let share = (k as f64 + phase[axis]) / side as f64;
        (2.0 * share - 1.0) * FIELD_DEG[axis].to_radians()
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
            if let Some((p, object)) = cast(world, direction) {
                points.push((noisy(p, sigma_m, rng), object));
            }
        }
    }
    points
}

fn cast(world: &World, direction: Unit<Vector3<f64>>) -> Option<(Point3<f64>, usize)> {
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

/// Points on the side of the object that the sensor sees, even in solid angle: about `wanted`, at least `min` and at most
/// `max` of them.
fn points_on(
    object: &Primitive,
    world: &World,
    beams: BeamLayout,
    [min, wanted, max]: [usize; 3],
    rng: &mut ChaCha8Rng,
) -> Vec<Point3<f64>> {
    let to_centre = object.centre().coords;
    let half = object.size_m().iter().map(|s| s * s).sum::<f64>().sqrt() / 2.0;
    let axis = to_centre.normalize();
    let across = axis.cross(&Vector3::z()).normalize();
    let up = across.cross(&axis);
    let hit = |direction: Vector3<f64>| match cast(world, Unit::new_normalize(direction)) {
        Some((p, 1)) => Some(p),
        _ => None,
    };
    // Rows on the plane at unit distance: even in solid angle to 1 % within the small field of an object.
    let window = half / (to_centre.norm_squared() - half * half).max(0.01).sqrt();
    let phase: [f64; 2] = [rng.random(), rng.random()];
    let (sin, cos) = rng.random_range(0.0..std::f64::consts::TAU).sin_cos();
    let rows = |step: f64| -> Vec<Point3<f64>> {
        let reach = (1.5 * window / step).ceil() as i32;
        let at = |k: i32, axis: usize| (f64::from(k) + phase[axis]) * step;
        let grid = (-reach..=reach).flat_map(|i| (-reach..=reach).map(move |k| (i, k)));
        grid.filter_map(|(i, k)| {
            let (u, v) = (at(i, 0), at(k, 1));
            let (u, v) = (u * cos - v * sin, u * sin + v * cos);
            hit(axis + across * u + up * v)
        })
        .collect()
    };
    if beams == BeamLayout::Rows {
        let probe = rows(window / 20.0).len().max(1) as f64;
        let mut step = window / 20.0 * (probe / wanted as f64).sqrt();
        for _ in 0..MAX_TRIES {
            let points = rows(step);
            if points.len() < min {
                step *= 0.98;
            } else if points.len() > max {
                step *= 1.01;
            } else {
                return points;
            }
        }
    }
    let min_cos = (1.0 - (half / to_centre.norm()).powi(2)).max(0.0).sqrt();
    let mut points = Vec::with_capacity(wanted);
    for _ in 0..MAX_TRIES.max(1000 * wanted) {
        if points.len() == wanted {
            break;
        }
        let c: f64 = rng.random_range(min_cos..1.0);
        let direction: f64 = rng.random_range(0.0..std::f64::consts::TAU);
        let s = (1.0 - c * c).max(0.0).sqrt();
        points.extend(hit(
            axis * c + (across * direction.cos() + up * direction.sin()) * s
        ));
    }
    points
}

#[cfg(test)]
mod tests {
    use super::{BeamLayout, CorridorNoise, CorridorObject, CorridorScene, PointDensity};
    use patrold_engine::shape::Class;

    fn corridor(object: CorridorObject, number: usize) -> CorridorScene {
        CorridorScene {
            object,
            noise: CorridorNoise::Fine,
            density: PointDensity::Many,
            beams: if number.is_multiple_of(2) {
                BeamLayout::Rows
            } else {
                BeamLayout::Scattered
            },
            number,
        }
    }

    #[test]
    fn objects_have_their_points_on_the_visible_side() {
        for object in [
            CorridorObject::Sphere,
            CorridorObject::Cylinder,
            CorridorObject::Plane,
        ] {
            for number in 0..10 {
                let scene = corridor(object, number).simulate(3).expect("a scene");
                let truth = scene.truth.expect("an object");
                assert!((390..=400).contains(&scene.reference.points.len()));
                let reach = truth.size_m.iter().map(|s| s * s).sum::<f64>().sqrt() / 2.0 + 0.01;
                let near = |p: &&nalgebra::Point3<f64>| (*p - truth.centre).norm() < reach;
                let on = scene.current.points.iter().filter(near).count();
                assert!((60..=120).contains(&on), "{} {on}", scene.name);
                let v = truth.centre.coords.normalize();
                if truth.class == Class::Sphere {
                    let facing =
                        |p: &&nalgebra::Point3<f64>| near(p) && (*p - truth.centre).dot(&v) < 0.01;
                    assert_eq!(scene.current.points.iter().filter(facing).count(), on);
                }
            }
        }
    }

    #[test]
    fn a_scene_depends_on_its_seed_and_name_alone() {
        let scene = |seed| {
            corridor(CorridorObject::Plane, 4)
                .simulate(seed)
                .expect("a scene")
        };
        assert_eq!(scene(1).current.points, scene(1).current.points);
        assert_ne!(scene(1).current.points, scene(2).current.points);
        assert!(
            corridor(CorridorObject::Nothing, 1)
                .simulate(1)
                .expect("a scene")
                .truth
                .is_none()
        );
    }
}
