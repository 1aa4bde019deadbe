//! The solids that scenes are made of, and where a ray hits them, from outside or from inside.

use super::bvh::Aabb;
use super::ray_box::{MIN_HIT_RANGE_M, RangeAndCosine, slab};
use super::superquadric;
use nalgebra::{Point3, Vector3};
use patrold_engine::geometry::Pose;

/// A shape about the origin of its own frame. Lengths in metres.
#[derive(Debug, Clone, PartialEq)]
pub enum SolidShape {
    /// A box.
    Cuboid {
        /// Half the sides along x, y, z.
        half: Vector3<f64>,
    },
    /// A sphere.
    Sphere { radius: f64 },
    /// A closed cylinder along z.
    Cylinder { radius: f64, half_length: f64 },
    /// A closed cone: base at z = 0, apex at z = height.
    Cone { radius: f64, height: f64 },
    /// A superquadric ellipsoid.
    Superquadric {
        /// Half the sides along x, y, z.
        half: Vector3<f64>,
        /// e1 (along z) and e2 (across), 0.1 to 2: 1 is round, 2 a rhombus.
        exponents: [f64; 2],
    },
    /// A flat rectangle in z = 0 with rectangular holes.
    Rectangle {
        /// Half the sides along x and y.
        half: [f64; 2],
        /// Holes as `[x from, x to, y from, y to]`.
        holes: Vec<[f64; 4]>,
    },
}

/// A shape at its pose in the map.
#[derive(Debug, Clone, PartialEq)]
pub struct Solid {
    map_from_local: Pose,
    local_from_map: Pose,
    shape: SolidShape,
}

impl Solid {
    /// `shape` at `map_from_local`.
    pub fn new(map_from_local: Pose, shape: SolidShape) -> Self {
        Self {
            map_from_local,
            local_from_map: map_from_local.inverse(),
            shape,
        }
    }

    /// Where a ray in map coordinates (unit `direction`) first hits the surface.
    pub fn hit(&self, origin: &Point3<f64>, direction: &Vector3<f64>) -> Option<RangeAndCosine> {
        let o = (self.local_from_map * origin).coords;
        let d = self.local_from_map.rotation * direction;
        match &self.shape {
            SolidShape::Cuboid { half } => hit_cuboid(&o, &d, half),
            SolidShape::Sphere { radius } => {
                let roots = roots(1.0, o.dot(&d), o.norm_squared() - radius * radius)?;
                nearest(roots, |t| Some((o + d * t).dot(&d).abs() / radius))
            }
            SolidShape::Cylinder {
                radius,
                half_length,
            } => hit_cylinder(&o, &d, *radius, *half_length),
            SolidShape::Cone { radius, height } => hit_cone(&o, &d, *radius, *height),
            SolidShape::Superquadric { half, exponents } => {
                superquadric::hit(&o, &d, half, *exponents)
            }
            SolidShape::Rectangle { half, holes } => {
                let t = -o.z / d.z;
                nearest([t], |t| {
                    let (x, y) = (o.x + d.x * t, o.y + d.y * t);
                    let inside = x.abs() <= half[0] && y.abs() <= half[1];
                    let open = holes
                        .iter()
                        .any(|[x0, x1, y0, y1]| x > *x0 && x < *x1 && y > *y0 && y < *y1);
                    (inside && !open).then_some(d.z.abs())
                })
            }
        }
    }

    /// A box along the map's axes that holds the solid.
    pub fn bounds(&self) -> Aabb {
        let (centre, half) = match &self.shape {
            SolidShape::Cuboid { half } | SolidShape::Superquadric { half, .. } => {
                (Vector3::zeros(), *half)
            }
            SolidShape::Sphere { radius } => (Vector3::zeros(), Vector3::repeat(*radius)),
            SolidShape::Cylinder {
                radius,
                half_length,
            } => (
                Vector3::zeros(),
                Vector3::new(*radius, *radius, *half_length),
            ),
            SolidShape::Cone { radius, height } => {
                let half = height / 2.0;
                (Vector3::z() * half, Vector3::new(*radius, *radius, half))
            }
            SolidShape::Rectangle { half, .. } => {
                (Vector3::zeros(), Vector3::new(half[0], half[1], 0.0))
            }
        };
        let centre = self.map_from_local * Point3::from(centre);
        let reach = self
            .map_from_local
            .rotation
            .to_rotation_matrix()
            .matrix()
            .abs()
            * half;
        Aabb {
            low: centre - reach,
            high: centre + reach,
        }
    }
}

/// The first of `ranges` in front of the ray that `cosine` accepts as a hit.
fn nearest<const N: usize>(
    ranges: [f64; N],
    cosine: impl Fn(f64) -> Option<f64>,
) -> Option<RangeAndCosine> {
    ranges
        .into_iter()
        .filter(|t| t.is_finite() && *t > MIN_HIT_RANGE_M)
        .filter_map(|t| Some((t, cosine(t)?)))
        .min_by(|a, b| a.0.total_cmp(&b.0))
}

/// The nearer of two hits.
fn nearer(a: Option<RangeAndCosine>, b: Option<RangeAndCosine>) -> Option<RangeAndCosine> {
    match (a, b) {
        (Some(a), Some(b)) => Some(if a.0 <= b.0 { a } else { b }),
        (a, b) => a.or(b),
    }
}

/// Real roots of `a t^2 + 2 b t + c`.
fn roots(a: f64, b: f64, c: f64) -> Option<[f64; 2]> {
    if a.abs() < 1e-14 {
        return Some([-c / (2.0 * b), f64::NAN]);
    }
    let discriminant = b * b - a * c;
    if discriminant < 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    Some([(-b - root) / a, (-b + root) / a])
}

fn hit_cuboid(o: &Vector3<f64>, d: &Vector3<f64>, half: &Vector3<f64>) -> Option<RangeAndCosine> {
    let through = slab(o, d, half)?;
    let t = through.into_iter().find(|t| *t > MIN_HIT_RANGE_M)?;
    // It lies on the nearest face.
    let p = (o + d * t).component_div(half).abs();
    Some((t, d[p.imax()].abs()))
}

fn hit_cylinder(
    o: &Vector3<f64>,
    d: &Vector3<f64>,
    radius: f64,
    half_length: f64,
) -> Option<RangeAndCosine> {
    let side = roots(
        d.x * d.x + d.y * d.y,
        o.x * d.x + o.y * d.y,
        o.x * o.x + o.y * o.y - radius * radius,
    )
    .and_then(|roots| {
        nearest(roots, |t| {
            let p = o + d * t;
            (p.z.abs() <= half_length).then(|| (p.x * d.x + p.y * d.y).abs() / radius)
        })
    });
    let caps = [(-half_length - o.z) / d.z, (half_length - o.z) / d.z];
    nearer(side, nearest(caps, |t| in_disc(&(o + d * t), radius, d)))
}

fn hit_cone(
    o: &Vector3<f64>,
    d: &Vector3<f64>,
    radius: f64,
    height: f64,
) -> Option<RangeAndCosine> {
    // x^2 + y^2 = slope^2 w^2, with w the depth below the apex.
    let slope2 = (radius / height).powi(2);
    let w = height - o.z;
    let side = roots(
        d.x * d.x + d.y * d.y - slope2 * d.z * d.z,
        o.x * d.x + o.y * d.y + slope2 * w * d.z,
        o.x * o.x + o.y * o.y - slope2 * w * w,
    )
    .and_then(|roots| {
        nearest(roots, |t| {
            let p = o + d * t;
            let normal = Vector3::new(p.x, p.y, slope2 * (height - p.z));
            (p.z >= 0.0 && p.z <= height)
                .then(|| normal.try_normalize(1e-12).map_or(1.0, |n| n.dot(d).abs()))
        })
    });
    nearer(
        side,
        nearest([-o.z / d.z], |t| in_disc(&(o + d * t), radius, d)),
    )
}

fn in_disc(p: &Vector3<f64>, radius: f64, d: &Vector3<f64>) -> Option<f64> {
    (p.x * p.x + p.y * p.y <= radius * radius).then_some(d.z.abs())
}

#[cfg(test)]
mod tests {
    use super::{Solid, SolidShape};
    use nalgebra::{Point3, Unit, Vector3};
    use patrold_engine::geometry::{Pose, RollPitchYaw};
    use proptest::prelude::*;

    fn hit(shape: SolidShape, origin: [f64; 3], direction: [f64; 3]) -> Option<(f64, f64)> {
        let direction = Vector3::from(direction).normalize();
        let (range, cosine) =
            Solid::new(Pose::identity(), shape).hit(&origin.into(), &direction)?;
        // Nine decimals are enough for a formula.
        Some(((range * 1e9).round() / 1e9, (cosine * 1e9).round() / 1e9))
    }

    fn near(got: Option<(f64, f64)>, range: f64, cosine: f64) {
        let (r, c) = got.expect("a hit");
        assert!(
            (r - range).abs() < 2e-9 && (c - cosine).abs() < 2e-9,
            "{r} {c}, not {range} {cosine}"
        );
    }

    #[test]
    fn boxes_are_hit_on_the_nearest_face() {
        let shape = || SolidShape::Cuboid {
            half: Vector3::new(1.0, 2.0, 3.0),
        };
        near(hit(shape(), [-5.0, 0.0, 0.0], [1.0, 0.0, 0.0]), 4.0, 1.0);
        near(hit(shape(), [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]), 3.0, 1.0);
        // To (-1, 1, 0) from (-3, -1, 0).
        let s = 0.5f64.sqrt();
        near(
            hit(shape(), [-3.0, -1.0, 0.0], [1.0, 1.0, 0.0]),
            8f64.sqrt(),
            s,
        );
        assert_eq!(hit(shape(), [-5.0, 2.5, 0.0], [1.0, 0.0, 0.0]), None);
        assert_eq!(hit(shape(), [-5.0, 0.0, 0.0], [-1.0, 0.0, 0.0]), None);
    }

    #[test]
    fn spheres_are_hit_from_both_sides() {
        let shape = || SolidShape::Sphere { radius: 1.0 };
        near(hit(shape(), [-3.0, 0.0, 0.0], [1.0, 0.0, 0.0]), 2.0, 1.0);
        // Half a radius off the centre: the surface at 30 degrees.
        near(
            hit(shape(), [-3.0, 0.5, 0.0], [1.0, 0.0, 0.0]),
            3.0 - 0.75f64.sqrt(),
            0.75f64.sqrt(),
        );
        near(hit(shape(), [0.5, 0.0, 0.0], [1.0, 0.0, 0.0]), 0.5, 1.0);
        assert_eq!(hit(shape(), [-3.0, 1.5, 0.0], [1.0, 0.0, 0.0]), None);
    }

    #[test]
    fn cylinders_are_hit_on_side_and_caps() {
        let shape = || SolidShape::Cylinder {
            radius: 0.5,
            half_length: 1.0,
        };
        near(
            hit(shape(), [-2.0, 0.3, 0.9], [1.0, 0.0, 0.0]),
            2.0 - 0.4,
            0.8,
        );
        near(hit(shape(), [0.2, 0.0, 5.0], [0.0, 0.0, -1.0]), 4.0, 1.0);
        near(hit(shape(), [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]), 1.0, 1.0);
        near(hit(shape(), [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]), 0.5, 1.0);
        // Over the rim on to the cap: down 0.3 at 45 degrees.
        near(
            hit(shape(), [-0.7, 0.0, 1.3], [1.0, 0.0, -1.0]),
            0.18f64.sqrt(),
            0.5f64.sqrt(),
        );
        assert_eq!(hit(shape(), [-2.0, 0.0, 1.1], [1.0, 0.0, 0.0]), None);
        assert_eq!(hit(shape(), [0.6, 0.0, 5.0], [0.0, 0.0, -1.0]), None);
    }

    #[test]
    fn cones_are_hit_on_side_and_base() {
        let shape = || SolidShape::Cone {
            radius: 1.0,
            height: 1.0,
        };
        let s = 0.5f64.sqrt();
        near(hit(shape(), [-2.0, 0.0, 0.5], [1.0, 0.0, 0.0]), 1.5, s);
        near(hit(shape(), [0.5, 0.0, 2.0], [0.0, 0.0, -1.0]), 1.5, s);
        near(hit(shape(), [0.5, 0.0, -2.0], [0.0, 0.0, 1.0]), 2.0, 1.0);
        near(hit(shape(), [0.0, 0.0, 0.5], [1.0, 0.0, 0.0]), 0.5, s);
        near(hit(shape(), [0.0, 0.0, 0.5], [0.0, 0.0, -1.0]), 0.5, 1.0);
        // Parallel to the far flank, square on the near one.
        near(
            hit(shape(), [-1.5, 0.0, 0.5], [1.0, 0.0, -1.0]),
            0.5 * 2f64.sqrt(),
            1.0,
        );
        assert_eq!(hit(shape(), [-2.0, 0.0, 1.1], [1.0, 0.0, 0.0]), None);
    }

    #[test]
    fn rectangles_let_rays_through_their_holes() {
        let shape = || SolidShape::Rectangle {
            half: [2.0, 1.0],
            holes: vec![[0.0, 1.0, -1.0, 0.5]],
        };
        near(hit(shape(), [-1.0, 0.0, 2.0], [0.0, 0.0, -1.0]), 2.0, 1.0);
        near(
            hit(shape(), [-1.0, 0.0, -2.0], [0.0, 1.0, 4.0]),
            17f64.sqrt() / 2.0,
            4.0 / 17f64.sqrt(),
        );
        assert_eq!(hit(shape(), [0.5, 0.0, 2.0], [0.0, 0.0, -1.0]), None);
        assert_eq!(hit(shape(), [0.0, 1.5, 2.0], [0.0, 0.0, -1.0]), None);
        assert_eq!(hit(shape(), [-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]), None);
    }

    fn any_shape() -> impl Strategy<Value = SolidShape> {
        prop_oneof![
            (0.1..2.0, 0.1..2.0, 0.1..2.0).prop_map(|(x, y, z)| SolidShape::Cuboid {
                half: Vector3::new(x, y, z)
            }),
            (0.1..2.0).prop_map(|radius| SolidShape::Sphere { radius }),
            (0.1..2.0, 0.1..2.0).prop_map(|(radius, half_length)| SolidShape::Cylinder {
                radius,
                half_length
            }),
            (0.1..2.0, 0.1..2.0).prop_map(|(radius, height)| SolidShape::Cone { radius, height }),
            (0.1..2.0, 0.1..2.0).prop_map(|(x, y)| SolidShape::Rectangle {
                half: [x, y],
                holes: Vec::new()
            }),
        ]
    }

    proptest! {
        #[test]
        fn hits_lie_within_the_bounds_and_move_with_the_solid(
            shape in any_shape(),
            at in proptest::array::uniform3(-3.0..3.0f64),
            turn in proptest::array::uniform3(-3.0..3.0f64),
            origin in proptest::array::uniform3(-4.0..4.0f64),
            direction in proptest::array::uniform3(-1.0..1.0f64),
        ) {
            let direction = Vector3::from(direction);
            prop_assume!(direction.norm() > 0.1);
            let direction = Unit::new_normalize(direction);
            let [roll_rad, pitch_rad, yaw_rad] = turn;
            let pose = RollPitchYaw { roll_rad, pitch_rad, yaw_rad }.with_translation(at);
            let origin = Point3::from(origin);
            let at_origin = Solid::new(Pose::identity(), shape.clone()).hit(&origin, &direction);
            let solid = Solid::new(pose, shape);
            let moved = solid.hit(&(pose * origin), &(pose * *direction));
            prop_assert_eq!(at_origin.is_some(), moved.is_some());
            if let (Some(a), Some(b)) = (at_origin, moved) {
                prop_assert!((a.0 - b.0).abs() < 1e-7);
                prop_assert!((0.0..=1.0 + 1e-9).contains(&a.1));
                let p = pose * (origin + *direction * a.0);
                let bounds = solid.bounds();
                for axis in 0..3 {
                    prop_assert!(p[axis] >= bounds.low[axis] - 1e-6 && p[axis] <= bounds.high[axis] + 1e-6);
                }
            }
        }
    }
}
