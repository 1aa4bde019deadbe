//! Primitives from minimal sets of points with normals.

use crate::shape::primitive::{Cylinder, Plane, Primitive, Sphere, rotation_with_third};
use nalgebra::{Point3, Rotation3, Unit, Vector3};

/// A point and the unit normal there.
pub(super) type Oriented = (Point3<f64>, Vector3<f64>);

/// The plane, sphere and cylinder that three oriented points suggest; those that fail all three
/// points within `epsilon_m` and `cos_angle` are dropped. Extents are not known yet (zero).
pub(super) fn suggested(
    three: &[Oriented; 3],
    epsilon_m: f64,
    cos_angle: f64,
    largest_m: f64,
) -> impl Iterator<Item = Primitive> + use<> {
    let [first, second, _] = three;
    let found = [
        plane(three),
        sphere(first, second).filter(|s| size_of(s) < largest_m),
        cylinder(first, second).filter(|c| size_of(c) < largest_m),
    ];
    let three = *three;
    found.into_iter().flatten().filter(move |primitive| {
        three
            .iter()
            .all(|point| agrees(primitive, point, epsilon_m, cos_angle))
    })
}

/// Whether the point lies on the surface and faces its way (either way).
pub(super) fn agrees(
    primitive: &Primitive,
    point: &Oriented,
    epsilon_m: f64,
    cos_angle: f64,
) -> bool {
    primitive.distance_m(&point.0).abs() < epsilon_m
        && primitive
            .normal_at(&point.0)
            .is_some_and(|n| n.dot(&point.1).abs() > cos_angle)
}

fn size_of(primitive: &Primitive) -> f64 {
    primitive.size_m()[0]
}

/// Through three points.
fn plane(three: &[Oriented; 3]) -> Option<Primitive> {
    let [(a, _), (b, _), (c, _)] = three;
    let normal = Unit::try_new((b - a).cross(&(c - a)), 1e-12)?;
    Some(flat(*a, &normal))
}

/// The plane through `at`.
pub(super) fn flat(at: Point3<f64>, normal: &Unit<Vector3<f64>>) -> Primitive {
    let frame = rotation_with_third(normal, &Vector3::zeros());
    Primitive::Plane(Plane {
        centre: at,
        rotation: Rotation3::from_matrix_unchecked(frame),
        sides_m: [0.0; 2],
    })
}

/// Centre midway between the lines along both normals, radius the mean distance.
fn sphere((p, n): &Oriented, (q, m): &Oriented) -> Option<Primitive> {
    let d = q - p;
    let b = n.dot(m);
    let denominator = 1.0 - b * b;
    if denominator < 1e-4 {
        return None;
    }
    let s = (d.dot(n) - b * d.dot(m)) / denominator;
    let t = (b * d.dot(n) - d.dot(m)) / denominator;
    let centre = nalgebra::center(&(p + n * s), &(q + m * t));
    Some(Primitive::Sphere(Sphere {
        centre,
        radius_m: f64::midpoint((p - centre).norm(), (q - centre).norm()),
    }))
}

/// Axis across both normals; the centre where the normals' lines meet seen along it.
fn cylinder((p, n): &Oriented, (q, m): &Oriented) -> Option<Primitive> {
    let axis = Unit::try_new(n.cross(m), 1e-2)?;
    let d = q - p;
    let d = d - axis.as_ref() * axis.dot(&d);
    // p + s n = q + t m in the plane across the axis: cross with m.
    let s = d.cross(m).dot(&axis) / n.cross(m).dot(&axis);
    let centre = p + n * s;
    let away = q - centre;
    let away = away - axis.as_ref() * axis.dot(&away);
    Some(Primitive::Cylinder(Cylinder {
        centre,
        axis,
        radius_m: f64::midpoint(s.abs(), away.norm()),
        length_m: 0.0,
    }))
}

#[cfg(test)]
mod tests {
    use super::{Primitive, suggested};
    use nalgebra::{Point3, Vector3};

    #[test]
    fn minimal_sets_give_their_sphere_and_cylinder() {
        let centre = Point3::new(1.0, 2.0, 3.0);
        let on_ball = |d: Vector3<f64>| (centre + d.normalize() * 0.4, d.normalize());
        let three = [
            on_ball(Vector3::new(1.0, 0.2, 0.0)),
            on_ball(Vector3::new(0.0, 1.0, 0.3)),
            on_ball(Vector3::new(0.5, 0.5, 0.7)),
        ];
        let found: Vec<_> = suggested(&three, 1e-6, 0.99, 10.0).collect();
        let [Primitive::Sphere(s)] = found[..] else {
            panic!("{found:?}")
        };
        assert!((s.centre - centre).norm() < 1e-9 && (s.radius_m - 0.4).abs() < 1e-9);

        let on_bar = |angle: f64, z: f64| {
            let n = Vector3::new(angle.cos(), angle.sin(), 0.0);
            (Point3::new(1.0, 2.0, z) + n * 0.2, n)
        };
        let three = [on_bar(0.0, 0.1), on_bar(1.0, 0.9), on_bar(2.0, 0.4)];
        let found: Vec<_> = suggested(&three, 1e-6, 0.99, 10.0).collect();
        let [Primitive::Cylinder(c)] = found[..] else {
            panic!("{found:?}")
        };
        assert!((c.radius_m - 0.2).abs() < 1e-9 && c.axis.z.abs() > 1.0 - 1e-12);
    }
}
