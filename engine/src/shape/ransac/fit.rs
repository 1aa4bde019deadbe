//! Least-squares fits of an unbounded surface to its points.

use super::constants::{MAX_FIT_STEPS, MIN_STEP};
use super::surface::UnboundedSurface;
use crate::shape::primitive::perpendicular;
use nalgebra::{Matrix3, SMatrix, SVector, Unit, Vector3, Vector4, Vector5};

/// The surface of the class of `start` with the least squared distances of `points`, by Gauss-Newton from `start`; `start`
/// itself if the points do not determine one.
pub(super) fn fit_surface(start: &UnboundedSurface, points: &[Vector3<f64>]) -> UnboundedSurface {
    let found = match *start {
        UnboundedSurface::Plane { .. } => plane(points),
        UnboundedSurface::Sphere { centre, radius_m } => Some(sphere(centre, radius_m, points)),
        UnboundedSurface::Cylinder {
            point,
            axis,
            radius_m,
        } => Some(cylinder(point, axis, radius_m, points)),
    };
    found.filter(UnboundedSurface::is_valid).unwrap_or(*start)
}

/// The plane with the least squared distances; `None` for fewer than three points.
pub(super) fn plane(points: &[Vector3<f64>]) -> Option<UnboundedSurface> {
    if points.len() < 3 {
        return None;
    }
    let n = points.len() as f64;
    let mean = points.iter().sum::<Vector3<f64>>() / n;
    let mut scatter = Matrix3::zeros();
    for p in points {
        let d = p - mean;
        scatter += d * d.transpose();
    }
    let eigen = scatter.symmetric_eigen();
    let normal = eigen.eigenvectors.column(eigen.eigenvalues.imin());
    let normal = Unit::new_normalize(normal.into_owned());
    Some(UnboundedSurface::Plane {
        normal,
        offset_m: normal.dot(&mean),
    })
}

fn sphere(
    mut centre: Vector3<f64>,
    mut radius_m: f64,
    points: &[Vector3<f64>],
) -> UnboundedSurface {
    for _ in 0..MAX_FIT_STEPS {
        let rows = points.iter().filter_map(|p| {
            let away = p - centre;
            let distance = away.norm();
            let n = away / distance;
            (distance > 0.0).then(|| (Vector4::new(-n.x, -n.y, -n.z, -1.0), distance - radius_m))
        });
        let Some(step) = gauss_newton_step(rows) else {
            break;
        };
        centre += step.fixed_rows::<3>(0);
        radius_m += step[3];
        if step.norm() < MIN_STEP * radius_m.abs() {
            break;
        }
    }
    UnboundedSurface::Sphere { centre, radius_m }
}

fn cylinder(
    mut point: Vector3<f64>,
    mut axis: Unit<Vector3<f64>>,
    mut radius_m: f64,
    points: &[Vector3<f64>],
) -> UnboundedSurface {
    // Rotated about the mean of the points, where rotations and translations of the axis are independent.
    let mean = points.iter().sum::<Vector3<f64>>() / (points.len() as f64).max(1.0);
    point += axis.as_ref() * axis.dot(&(mean - point));
    let reach = points.iter().map(|p| (p - mean).norm()).fold(0.0, f64::max);
    for _ in 0..MAX_FIT_STEPS {
        let e1 = perpendicular(&axis);
        let e2 = axis.cross(&e1);
        // Translations of the point along e1, e2; rotations of the axis towards e1, e2; the radius.
        let rows = points.iter().filter_map(|p| {
            let d = p - point;
            let height = axis.dot(&d);
            let (x, y) = (e1.dot(&d), e2.dot(&d));
            let distance = x.hypot(y);
            let (n1, n2) = (x / distance, y / distance);
            (distance > 0.0).then(|| {
                (
                    Vector5::new(-n1, -n2, -n1 * height, -n2 * height, -1.0),
                    distance - radius_m,
                )
            })
        });
        let Some(step) = gauss_newton_step(rows) else {
            break;
        };
        point += e1.as_ref() * step[0] + e2 * step[1];
        axis = Unit::new_normalize(axis.as_ref() + e1.as_ref() * step[2] + e2 * step[3]);
        radius_m += step[4];
        let moved = step[0].hypot(step[1]) + step[4].abs() + reach * step[2].hypot(step[3]);
        if moved < MIN_STEP * radius_m.abs() {
            break;
        }
    }
    UnboundedSurface::Cylinder {
        point,
        axis,
        radius_m,
    }
}

/// The step for rows of (derivatives, residual).
fn gauss_newton_step<const N: usize>(
    rows: impl Iterator<Item = (SVector<f64, N>, f64)>,
) -> Option<SVector<f64, N>> {
    let mut normal = SMatrix::<f64, N, N>::zeros();
    let mut right_side = SVector::<f64, N>::zeros();
    for (row, residual) in rows {
        for a in 0..N {
            for b in 0..=a {
                normal[(a, b)] += row[a] * row[b];
            }
            right_side[a] -= row[a] * residual;
        }
    }
    let step = normal.cholesky()?.solve(&right_side);
    step.iter().all(|v| v.is_finite()).then_some(step)
}

#[cfg(test)]
mod tests {
    use super::{UnboundedSurface, fit_surface};
    use nalgebra::{Unit, Vector3};

    fn grid(on: impl Fn(f64, f64) -> Vector3<f64>) -> Vec<Vector3<f64>> {
        let at = |i: i32| f64::from(i) * 0.1;
        (0..12)
            .flat_map(|i| (0..12).map(move |j| (at(i), at(j))))
            .map(|(a, b)| on(a, b))
            .collect()
    }

    #[test]
    fn exact_points_are_fitted_from_a_rough_start() {
        let centre = Vector3::new(1.0, -2.0, 0.5);
        let on_sphere =
            grid(|a, b| centre + Vector3::new(a.cos() * b.cos(), a.sin() * b.cos(), b.sin()) * 0.4);
        let start = UnboundedSurface::Sphere {
            centre: centre + Vector3::new(0.05, 0.02, -0.06),
            radius_m: 0.5,
        };
        let UnboundedSurface::Sphere {
            centre: c,
            radius_m,
        } = fit_surface(&start, &on_sphere)
        else {
            panic!("the class is kept")
        };
        assert!((c - centre).norm() < 1e-6 && (radius_m - 0.4).abs() < 1e-6);

        let axis = Unit::new_normalize(Vector3::new(0.1, 0.2, 1.0));
        let e1 = axis.cross(&Vector3::x()).normalize();
        let e2 = axis.cross(&e1);
        let on_cylinder =
            grid(|a, h| centre + (e1 * a.cos() + e2 * a.sin()) * 0.3 + axis.as_ref() * h);
        let start = UnboundedSurface::Cylinder {
            point: centre + e1 * 0.04,
            axis: Unit::new_normalize(axis.as_ref() + e2 * 0.1),
            radius_m: 0.35,
        };
        let UnboundedSurface::Cylinder {
            axis: a, radius_m, ..
        } = fit_surface(&start, &on_cylinder)
        else {
            panic!("the class is kept")
        };
        assert!(a.dot(&axis) > 1.0 - 1e-9 && (radius_m - 0.3).abs() < 1e-6);
    }

    #[test]
    fn points_that_determine_no_surface_leave_the_start() {
        let start = UnboundedSurface::Sphere {
            centre: Vector3::zeros(),
            radius_m: 1.0,
        };
        for points in [vec![], vec![Vector3::x()], vec![Vector3::x(); 40]] {
            assert_eq!(fit_surface(&start, &points), start);
        }
    }
}
