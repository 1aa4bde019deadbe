//! Simulated views of single primitives: a grid of beams, the first hit, noise.

use crate::shape::primitive::{Cone, Cuboid, Cylinder, Plane, Primitive, Sphere, Superquadric};
use nalgebra::{Point3, Rotation3, Unit, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Distance along `d` (unit) from `o` to the primitive's surface.
pub(super) fn cast_ray(primitive: &Primitive, o: &Point3<f64>, d: &Vector3<f64>) -> Option<f64> {
    let roots = |a: f64, b: f64, c: f64| {
        let disc = b * b - a * c;
        (disc > 0.0 && a > 0.0).then(|| (-b - disc.sqrt()) / a)
    };
    match primitive {
        Primitive::Sphere(s) => {
            let oc = o - s.centre;
            roots(1.0, oc.dot(d), oc.norm_squared() - s.radius_m.powi(2))
        }
        Primitive::Cylinder(c) => {
            let oc = o - c.centre;
            let (oh, dh) = (oc.dot(&c.axis), d.dot(&c.axis));
            let (oa, da) = (oc - c.axis.as_ref() * oh, d - c.axis.as_ref() * dh);
            let side = roots(
                da.norm_squared(),
                oa.dot(&da),
                oa.norm_squared() - c.radius_m.powi(2),
            )
            .filter(|t| (oh + t * dh).abs() <= c.length_m / 2.0);
            let cap = (c.length_m / 2.0 * oh.signum() - oh) / dh;
            let cap = Some(cap)
                .filter(|t| *t > 0.0 && (oa + da * *t).norm() <= c.radius_m)
                .filter(|_| oh.abs() > c.length_m / 2.0);
            match (side, cap) {
                (Some(a), Some(b)) => Some(a.min(b)),
                (a, b) => a.or(b),
            }
        }
        Primitive::Plane(p) => {
            let n = p.normal();
            let t = (p.centre - o).dot(&n) / d.dot(&n);
            let local = p.rotation.inverse() * (o + d * t - p.centre);
            let inside = local.x.abs() <= p.sides_m[0] / 2.0 && local.y.abs() <= p.sides_m[1] / 2.0;
            (t > 0.0 && inside).then_some(t)
        }
        Primitive::Cuboid(b) => {
            let turn = b.rotation.inverse();
            let (from, along) = (turn * (o - b.centre), turn * d);
            let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
            for k in 0..3 {
                let half = b.sides_m[k] / 2.0;
                let (a, z) = ((-half - from[k]) / along[k], (half - from[k]) / along[k]);
                enter = enter.max(a.min(z));
                leave = leave.min(a.max(z));
            }
            (enter < leave).then_some(enter)
        }
        Primitive::Cone(c) => {
            // |away|^2 = (slope * depth)^2 below the apex.
            let slope_2 = (c.radius_m / c.height_m).powi(2);
            let oa = o - c.apex();
            let (oh, dh) = (-oa.dot(&c.axis), -d.dot(&c.axis));
            let (op, dp) = (oa + c.axis.as_ref() * oh, d + c.axis.as_ref() * dh);
            let a = dp.norm_squared() - slope_2 * dh * dh;
            let b = op.dot(&dp) - slope_2 * oh * dh;
            let disc = b * b - a * (op.norm_squared() - slope_2 * oh * oh);
            let on = |t: &f64| *t > 0.0 && (0.0..=c.height_m).contains(&(oh + t * dh));
            let root = |sign: f64| Some((-b + sign * disc.sqrt()) / a).filter(on);
            let base = (c.height_m - oh) / dh;
            let base = Some(base).filter(|t| *t > 0.0 && (op + dp * *t).norm() <= c.radius_m);
            let hits = [root(-1.0), root(1.0), base];
            hits.into_iter().flatten().min_by(f64::total_cmp)
        }
        Primitive::Superquadric(s) => {
            // The gauge is convex along the ray: its minimum by ternary search within a ball around the body, then the near
            // crossing of the surface by bisection.
            let oc = o - s.centre;
            let reach = s.sides_m.iter().sum::<f64>();
            let (b, c) = (oc.dot(d), oc.norm_squared() - reach * reach);
            let disc = b * b - c;
            if disc <= 0.0 {
                return None;
            }
            let gauge = |t: f64| s.gauge_at(&(o + d * t));
            let (mut low, mut high) = (-b - disc.sqrt(), -b + disc.sqrt());
            let first = low;
            while high - low > 1e-7 {
                let third = (high - low) / 3.0;
                if gauge(low + third) < gauge(high - third) {
                    high -= third;
                } else {
                    low += third;
                }
            }
            let minimum = f64::midpoint(low, high);
            if gauge(minimum) >= 1.0 {
                return None;
            }
            let (mut low, mut high) = (first, minimum);
            for _ in 0..40 {
                let middle = f64::midpoint(low, high);
                if gauge(middle) < 1.0 {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            Some(high)
        }
    }
    .filter(|t| t.is_finite() && *t > 0.0)
}

/// About `wanted` points of the side that `sensor` sees, on a regular grid of beams, with isotropic noise of `sigma_m`.
pub(in crate::shape) fn simulate_view(
    primitive: &Primitive,
    sensor: &Point3<f64>,
    wanted: usize,
    sigma_m: f64,
    rng: &mut ChaCha8Rng,
) -> Vec<Point3<f64>> {
    let to = primitive.centre() - sensor;
    let axis = Unit::new_normalize(to);
    let half = primitive.size_m().iter().map(|s| s * s).sum::<f64>().sqrt() / 2.0;
    // Half the side of a window around the object in the plane at distance one.
    let window = (half / (to.norm() - half).max(0.1)).min(3.0);
    let e1 = axis.cross(&crate::shape::primitive::perpendicular(&axis));
    let e2 = axis.cross(&e1);
    let (shift_1, shift_2): (f64, f64) = (rng.random(), rng.random());
    let beams = |steps: f64| {
        let step = 2.0 * window / steps;
        let mut hits = Vec::new();
        for i in 0..steps as usize {
            for k in 0..steps as usize {
                let a = -window + (i as f64 + shift_1) * step;
                let b = -window + (k as f64 + shift_2) * step;
                let d = (axis.as_ref() + e1 * a + e2 * b).normalize();
                hits.extend(cast_ray(primitive, sensor, &d).map(|t| sensor + d * t));
            }
        }
        hits
    };
    // Rays are expensive where the surface has no closed form.
    let fine = match primitive {
        Primitive::Superquadric(_) => 60.0,
        _ => 200.0,
    };
    let probe = beams(fine).len().max(1) as f64;
    let steps = fine * (wanted as f64 / probe).sqrt();
    let mut points = beams(steps.round().max(4.0));
    for p in &mut points {
        let n: [f64; 3] = std::array::from_fn(|_| StandardNormal.sample(rng));
        *p += Vector3::from(n) * sigma_m;
    }
    points
}

/// A random primitive of the class 0 sphere, 1 cylinder, 2 plane as in the corridor scenes; 3 box, 4 cone, 5 superquadric of
/// similar sizes; 6 short cylinder; 7 cylinder seen end-on from a sensor at the origin.
pub(in crate::shape) fn random_primitive(class: usize, seed: u64) -> (Primitive, ChaCha8Rng) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed * 3 + class as u64);
    let centre = Point3::new(
        rng.random_range(2.0..4.0),
        rng.random_range(-1.0..1.0),
        rng.random_range(-0.6..0.4),
    );
    let primitive = match class {
        0 => Primitive::Sphere(Sphere {
            centre,
            radius_m: rng.random_range(0.2..0.45),
        }),
        1 => {
            let lean: [f64; 2] = [rng.random_range(-0.3..0.3), rng.random_range(-0.3..0.3)];
            Primitive::Cylinder(Cylinder {
                centre,
                axis: Unit::new_normalize(Vector3::new(lean[0], lean[1], 1.0)),
                radius_m: rng.random_range(0.15..0.35),
                length_m: rng.random_range(0.8..1.6),
            })
        }
        3 => Primitive::Cuboid(Cuboid {
            centre,
            rotation: random_rotation(&mut rng),
            sides_m: std::array::from_fn(|_| rng.random_range(0.25..0.8)),
        }),
        4 => {
            let lean: [f64; 2] = [rng.random_range(-0.3..0.3), rng.random_range(-0.3..0.3)];
            Primitive::Cone(Cone {
                centre,
                axis: Unit::new_normalize(Vector3::new(lean[0], lean[1], 1.0)),
                radius_m: rng.random_range(0.15..0.4),
                height_m: rng.random_range(0.4..1.0),
            })
        }
        5 => Primitive::Superquadric(Superquadric {
            centre,
            rotation: random_rotation(&mut rng),
            sides_m: std::array::from_fn(|_| rng.random_range(0.3..0.9)),
            exponents: std::array::from_fn(|_| rng.random_range(0.3..1.7)),
        }),
        // Shorter than 1.2 times its width; below, with the axis within 25 deg of the view.
        6 => {
            let lean: [f64; 2] = [rng.random_range(-0.3..0.3), rng.random_range(-0.3..0.3)];
            let radius_m = rng.random_range(0.2..0.4);
            Primitive::Cylinder(Cylinder {
                centre,
                axis: Unit::new_normalize(Vector3::new(lean[0], lean[1], 1.0)),
                radius_m,
                length_m: 2.0 * radius_m * rng.random_range(0.4..1.2),
            })
        }
        7 => {
            let off: [f64; 3] = std::array::from_fn(|_| rng.random_range(-0.24..0.24));
            Primitive::Cylinder(Cylinder {
                centre,
                axis: Unit::new_normalize(centre.coords.normalize() + Vector3::from(off)),
                radius_m: rng.random_range(0.15..0.35),
                length_m: rng.random_range(0.4..1.2),
            })
        }
        _ => Primitive::Plane(Plane {
            centre,
            // Normal within 50 deg of the view.
            rotation: Rotation3::from_euler_angles(0.0, 0.0, rng.random_range(-0.9..0.9))
                * Rotation3::from_euler_angles(0.0, -1.57 + rng.random_range(-0.4..0.4), 0.3),
            sides_m: [rng.random_range(0.8..1.6), rng.random_range(0.4..0.8)],
        }),
    };
    (primitive, rng)
}

/// Any rotation about the vertical, tilted by up to 17 deg.
fn random_rotation(rng: &mut ChaCha8Rng) -> Rotation3<f64> {
    Rotation3::from_euler_angles(
        rng.random_range(-0.3..0.3),
        rng.random_range(-0.3..0.3),
        rng.random_range(-3.1..3.1),
    )
}
