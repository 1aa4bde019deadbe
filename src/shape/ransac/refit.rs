//! Least squares of a primitive on its inliers, and its extent.

use super::candidate::flat;
use crate::mixture::Gaussian;
use crate::shape::constants::MOST_STEPS;
use crate::shape::primitive::{Cylinder, Plane, Primitive, Sphere, perpendicular};
use nalgebra::{Point3, Rotation3, SMatrix, SVector, Unit, Vector2, Vector3, Vector4, Vector5};

/// The primitive that minimises the squared distances of `points`, starting from `primitive`.
/// Extents are those of the points. The start itself if the points do not determine it.
pub(super) fn refitted(primitive: &Primitive, points: &[Point3<f64>]) -> Primitive {
    let Some(moments) = Gaussian::of_points(points) else {
        return *primitive;
    };
    let fitted = match primitive {
        Primitive::Plane(_) => {
            let eigen = moments.covariance.symmetric_eigen();
            let least = eigen.eigenvalues.imin();
            let normal = eigen.eigenvectors.column(least).into_owned();
            flat(moments.mean, &Unit::new_normalize(normal))
        }
        Primitive::Sphere(s) => Primitive::Sphere(sphere(s, points)),
        Primitive::Cylinder(c) => Primitive::Cylinder(cylinder(c, points)),
    };
    let sane = fitted
        .size_m()
        .iter()
        .chain(fitted.centre().iter())
        .all(|v| v.is_finite());
    extended(if sane { &fitted } else { primitive }, points)
}

fn sphere(start: &Sphere, points: &[Point3<f64>]) -> Sphere {
    let mut s = *start;
    for _ in 0..MOST_STEPS {
        let rows = points.iter().filter_map(|p| {
            let n = s.normal_at(p)?;
            Some((Vector4::new(-n.x, -n.y, -n.z, -1.0), s.distance_m(p)))
        });
        let Some(step) = newton_step(rows) else {
            break;
        };
        s.centre += Vector3::new(step[0], step[1], step[2]);
        s.radius_m += step[3];
        if step.norm() < 1e-10 * s.radius_m.abs() {
            break;
        }
    }
    if s.radius_m > 0.0 { s } else { *start }
}

fn cylinder(start: &Cylinder, points: &[Point3<f64>]) -> Cylinder {
    let mut c = *start;
    for _ in 0..MOST_STEPS {
        let e1 = perpendicular(&c.axis);
        let e2 = c.axis.cross(&e1);
        // Moves of the centre along e1, e2; turns of the axis towards e1, e2; the radius.
        let rows = points.iter().filter_map(|p| {
            let n = c.normal_at(p)?;
            let height = (p - c.centre).dot(&c.axis);
            let (n1, n2) = (n.dot(&e1), n.dot(&e2));
            Some((
                Vector5::new(-n1, -n2, -n1 * height, -n2 * height, -1.0),
                c.distance_m(p),
            ))
        });
        let Some(step) = newton_step(rows) else {
            break;
        };
        c.centre += e1.as_ref() * step[0] + e2 * step[1];
        c.axis = Unit::new_normalize(c.axis.as_ref() + e1.as_ref() * step[2] + e2 * step[3]);
        c.radius_m += step[4];
        if step.norm() < 1e-10 * c.radius_m.abs() {
            break;
        }
    }
    if c.radius_m > 0.0 { c } else { *start }
}

/// The least-squares step for rows (derivatives, residual).
fn newton_step<const N: usize>(
    rows: impl Iterator<Item = (SVector<f64, N>, f64)>,
) -> Option<SVector<f64, N>> {
    let mut normal = SMatrix::<f64, N, N>::zeros();
    let mut right = SVector::<f64, N>::zeros();
    for (row, residual) in rows {
        normal += row * row.transpose();
        right -= row * residual;
    }
    let step = normal.cholesky()?.solve(&right);
    step.iter().all(|v| v.is_finite()).then_some(step)
}

/// The same surface with the extent of `points` on it.
fn extended(primitive: &Primitive, points: &[Point3<f64>]) -> Primitive {
    match *primitive {
        Primitive::Sphere(s) => Primitive::Sphere(s),
        Primitive::Cylinder(c) => {
            let (low, high) = span(points.iter().map(|p| (p - c.centre).dot(&c.axis)));
            Primitive::Cylinder(Cylinder {
                centre: c.centre + c.axis.as_ref() * f64::midpoint(low, high),
                length_m: high - low,
                ..c
            })
        }
        Primitive::Plane(p) => Primitive::Plane(smallest_rectangle(&p, points)),
    }
}

fn span(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
        (l.min(v), h.max(v))
    });
    if low <= high { (low, high) } else { (0.0, 0.0) }
}

/// The smallest of the rectangles around the points, over turns within the plane.
pub(in crate::shape) fn smallest_rectangle(plane: &Plane, points: &[Point3<f64>]) -> Plane {
    let m = plane.rotation.matrix();
    let (x, y) = (m.column(0).into_owned(), m.column(1).into_owned());
    let flat: Vec<Vector2<f64>> = points
        .iter()
        .map(|p| p - plane.centre)
        .map(|d| Vector2::new(d.dot(&x), d.dot(&y)))
        .collect();
    // One in `stride` points decides the turn; all of them the extent.
    let stride = (flat.len() / 512).max(1);
    let at = |angle: f64, stride: usize| {
        let (sin, cos) = angle.sin_cos();
        let along = span(flat.iter().step_by(stride).map(|v| v.x * cos + v.y * sin));
        let across = span(flat.iter().step_by(stride).map(|v| v.y * cos - v.x * sin));
        (along, across)
    };
    let area = |angle: f64| {
        let ((a, b), (c, d)) = at(angle, stride);
        (b - a) * (d - c)
    };
    let angle = (0..90)
        .map(|k| f64::from(k).to_radians())
        .min_by(|a, b| area(*a).total_cmp(&area(*b)))
        .unwrap_or(0.0);
    let ((a, b), (c, d)) = at(angle, 1);
    let (sin, cos) = angle.sin_cos();
    let (u, v) = (x * cos + y * sin, y * cos - x * sin);
    Plane {
        centre: plane.centre + u * f64::midpoint(a, b) + v * f64::midpoint(c, d),
        rotation: Rotation3::from_matrix_unchecked(nalgebra::Matrix3::from_columns(&[
            u,
            v,
            plane.normal(),
        ])),
        sides_m: [b - a, d - c],
    }
    .longer_first()
}
