//! Surfaces from minimal sets of oriented points (Schnabel section 4.1).

use super::constants::{MIN_SINE, MINIMAL_SET_EPSILONS};
use super::score::Tolerance;
use super::surface::{UnboundedSurface, across};
use nalgebra::{Matrix2, Matrix3, Unit, Vector2, Vector3};

/// Position and unit normal of either sign.
pub(super) type OrientedPoint = (Vector3<f64>, Vector3<f64>);

/// The plane, sphere and cylinder through three oriented points, as far as all three are their inliers and their radius is
/// below `max_radius_m`.
pub(super) fn propose_surfaces(
    three: &[OrientedPoint; 3],
    tolerance: Tolerance,
    max_radius_m: f64,
) -> impl Iterator<Item = UnboundedSurface> + use<> {
    let tolerance = tolerance.widened(MINIMAL_SET_EPSILONS);
    let three = *three;
    [plane(&three), sphere(&three), cylinder(&three)]
        .into_iter()
        .flatten()
        .filter(move |surface| {
            surface.is_valid()
                && surface.radius_m().is_none_or(|r| r < max_radius_m)
                && three.iter().all(|(p, n)| tolerance.accepts(surface, p, n))
        })
}

/// Through three points, as in Schnabel section 4.1; the normals only confirm it. Three positions within a cell fix a plane
/// better than one noisy normal.
fn plane(three: &[OrientedPoint; 3]) -> Option<UnboundedSurface> {
    let [(a, _), (b, _), (c, _)] = three;
    // Relative to the size of the triangle, so that the scale does not matter.
    let (ab, ac) = (b - a, c - a);
    let least = MIN_SINE * ab.norm() * ac.norm();
    let normal = Unit::try_new(ab.cross(&ac), least)?;
    Some(UnboundedSurface::Plane {
        normal,
        offset_m: normal.dot(a),
    })
}

/// The centre is the point nearest to the three lines along the normals, the radius the mean distance. Two normals would
/// suffice; the third halves their error.
fn sphere(three: &[OrientedPoint; 3]) -> Option<UnboundedSurface> {
    let mut projections = Matrix3::zeros();
    let mut right_side = Vector3::zeros();
    for (p, n) in three {
        let off_line = Matrix3::identity() - n * n.transpose();
        projections += off_line;
        right_side += off_line * p;
    }
    // With all normals parallel one direction stays open: the determinant is 9 sin^2 or less.
    if projections.determinant() < MIN_SINE * MIN_SINE {
        return None;
    }
    let centre = projections.try_inverse()? * right_side;
    let radius_m = three.iter().map(|(p, _)| (p - centre).norm()).sum::<f64>() / 3.0;
    Some(UnboundedSurface::Sphere { centre, radius_m })
}

/// The axis is perpendicular to the two normals that differ most, and passes nearest to the three lines along the normals.
fn cylinder(three: &[OrientedPoint; 3]) -> Option<UnboundedSurface> {
    let [(_, n0), (_, n1), (_, n2)] = three;
    let widest = [n0.cross(n1), n0.cross(n2), n1.cross(n2)]
        .into_iter()
        .max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()))?;
    let axis = Unit::try_new(widest, MIN_SINE)?;
    let e1 = crate::shape::primitive::perpendicular(&axis).into_inner();
    let e2 = axis.cross(&e1);
    let mut projections = Matrix2::zeros();
    let mut right_side = Vector2::zeros();
    for (p, n) in three {
        let flat = Vector2::new(n.dot(&e1), n.dot(&e2)).try_normalize(MIN_SINE)?;
        let off_line = Matrix2::identity() - flat * flat.transpose();
        projections += off_line;
        right_side += off_line * Vector2::new(p.dot(&e1), p.dot(&e2));
    }
    let foot = projections.try_inverse()? * right_side;
    let point = e1 * foot.x + e2 * foot.y;
    let distance = |(p, _): &OrientedPoint| across(&(p - point), &axis).norm();
    Some(UnboundedSurface::Cylinder {
        point,
        axis,
        radius_m: three.iter().map(distance).sum::<f64>() / 3.0,
    })
}

#[cfg(test)]
mod tests {
    use super::{OrientedPoint, UnboundedSurface, propose_surfaces};
    use crate::shape::ransac::score::Tolerance;
    use nalgebra::{Unit, Vector3};
    use proptest::prelude::*;

    const NEAR: Tolerance = Tolerance {
        epsilon_m: 1e-6,
        cos_angle: 0.99,
    };

    fn direction() -> impl Strategy<Value = Vector3<f64>> {
        prop::array::uniform3(-1.0f64..1.0)
            .prop_map(Vector3::from)
            .prop_filter("a direction", |v| v.norm() > 0.1)
            .prop_map(|v| v.normalize())
    }

    fn position() -> impl Strategy<Value = Vector3<f64>> {
        prop::array::uniform3(-5.0f64..5.0).prop_map(Vector3::from)
    }

    fn well_spread(three: &[Vector3<f64>; 3]) -> bool {
        let [a, b, c] = three;
        let wide = |a: &Vector3<f64>, b: &Vector3<f64>| a.cross(b).norm() > 0.3;
        wide(a, b) && wide(b, c) && wide(a, c)
    }

    proptest! {
        #[test]
        fn exact_points_of_a_sphere_give_that_sphere(
            centre in position(), radius in 0.05f64..5.0, on in [direction(), direction(), direction()],
            flip in any::<bool>(),
        ) {
            prop_assume!(well_spread(&on));
            let sign = if flip { -1.0 } else { 1.0 };
            let three: [OrientedPoint; 3] = on.map(|n| (centre + n * radius, n * sign));
            let found = propose_surfaces(&three, NEAR, 100.0).find_map(|s| match s {
                UnboundedSurface::Sphere { centre, radius_m } => Some((centre, radius_m)),
                _ => None,
            });
            let (c, r) = found.expect("a sphere");
            prop_assert!((c - centre).norm() < 1e-9 && (r - radius).abs() < 1e-9);
        }

        #[test]
        fn exact_points_of_a_cylinder_give_that_cylinder(
            point in position(), axis in direction(), radius in 0.05f64..3.0,
            coordinates in prop::array::uniform3((0.0f64..std::f64::consts::TAU, -3.0f64..3.0)),
        ) {
            let axis = Unit::new_normalize(axis);
            let e1 = crate::shape::primitive::perpendicular(&axis).into_inner();
            let e2 = axis.cross(&e1);
            let on = coordinates.map(|(angle, _)| e1 * angle.cos() + e2 * angle.sin());
            prop_assume!(well_spread(&on));
            let three: [OrientedPoint; 3] = std::array::from_fn(|k| {
                (point + on[k] * radius + axis.as_ref() * coordinates[k].1, on[k])
            });
            let found = propose_surfaces(&three, NEAR, 100.0).find_map(|s| match s {
                UnboundedSurface::Cylinder { point, axis, radius_m } => Some((point, axis, radius_m)),
                _ => None,
            });
            let (p, a, r) = found.expect("a cylinder");
            prop_assert!(a.cross(&axis).norm() < 1e-9 && (r - radius).abs() < 1e-9);
            prop_assert!((p - point).cross(&axis).norm() < 1e-8);
        }

        #[test]
        fn exact_points_of_a_plane_give_that_plane_alone(
            origin in position(), normal in direction(), uv in prop::array::uniform6(-2.0f64..2.0),
        ) {
            let normal = Unit::new_normalize(normal);
            let e1 = crate::shape::primitive::perpendicular(&normal).into_inner();
            let e2 = normal.cross(&e1);
            let points: [Vector3<f64>; 3] =
                std::array::from_fn(|k| origin + e1 * uv[2 * k] + e2 * uv[2 * k + 1]);
            let (ab, ac) = (points[1] - points[0], points[2] - points[0]);
            prop_assume!(ab.cross(&ac).norm() > 0.2 * ab.norm() * ac.norm());
            let three = points.map(|p| (p, normal.into_inner()));
            let found: Vec<_> = propose_surfaces(&three, NEAR, 100.0).collect();
            prop_assert_eq!(found.len(), 1);
            prop_assert!(points.iter().all(|p| found[0].distance_m(p).abs() < 1e-9));
            let along = found[0].normal_at(&Vector3::zeros()).map_or(0.0, |n| n.dot(&normal));
            prop_assert!(along.abs() > 1.0 - 1e-12 && found[0].radius_m().is_none());
        }

        #[test]
        fn surfaces_that_contradict_the_normals_are_not_proposed(
            centre in position(), on in [direction(), direction(), direction()], wrong in direction(),
        ) {
            prop_assume!(well_spread(&on) && on[2].cross(&wrong).norm() > 0.5);
            let mut three: [OrientedPoint; 3] = on.map(|n| (centre + n, n));
            three[2].1 = wrong;
            for s in propose_surfaces(&three, NEAR, 100.0) {
                prop_assert!(three.iter().all(|(p, n)| NEAR.widened(2.0).accepts(&s, p, n)));
                let round = matches!(s, UnboundedSurface::Sphere { .. });
                prop_assert!(!round);
            }
        }
    }

    #[test]
    fn degenerate_sets_propose_nothing() {
        let same = (Vector3::new(1.0, 2.0, 3.0), Vector3::z());
        let zero = (Vector3::x(), Vector3::zeros());
        let bad = (Vector3::new(f64::NAN, 0.0, 0.0), Vector3::z());
        for one in [same, zero, bad] {
            assert_eq!(propose_surfaces(&[one; 3], NEAR, 10.0).count(), 0);
        }
        let line = [0.0, 1.0, 2.0].map(|x| (Vector3::x() * x, Vector3::z()));
        assert_eq!(propose_surfaces(&line, NEAR, 10.0).count(), 0);
    }
}
