//! Least squares of an endless surface on its points.

use super::constants::{LEAST_STEP, MOST_STEPS};
use super::surface::Surface;
use crate::shape::primitive::perpendicular;
use nalgebra::{Matrix3, SMatrix, SVector, Unit, Vector3, Vector4, Vector5};

/// The surface of `start`'s class that minimises the squared distances of `points`, from `start`
/// by Gauss-Newton. `start` itself if the points do not determine one.
pub(super) fn fitted(start: &Surface, points: &[Vector3<f64>]) -> Surface {
    let found = match *start {
        Surface::Plane { .. } => plane(points),
        Surface::Sphere { centre, radius_m } => Some(sphere(centre, radius_m, points)),
        Surface::Cylinder {
            point,
            axis,
            radius_m,
        } => Some(cylinder(point, axis, radius_m, points)),
    };
    found.filter(Surface::is_sane).unwrap_or(*start)
}

/// The plane nearest to `points`; `None` of fewer than three.
pub(super) fn plane(points: &[Vector3<f64>]) -> Option<Surface> {
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
    Some(Surface::Plane {
        normal,
        offset_m: normal.dot(&mean),
    })
}

fn sphere(mut centre: Vector3<f64>, mut radius_m: f64, points: &[Vector3<f64>]) -> Surface {
    for _ in 0..MOST_STEPS {
        let rows = points.iter().filter_map(|p| {
            let away = p - centre;
            let distance = away.norm();
            let n = away / distance;
            (distance > 0.0).then(|| (Vector4::new(-n.x, -n.y, -n.z, -1.0), distance - radius_m))
        });
        let Some(step) = newton_step(rows) else {
            break;
        };
        centre += step.fixed_rows::<3>(0);
        radius_m += step[3];
        if step.norm() < LEAST_STEP * radius_m.abs() {
            break;
        }
    }
    Surface::Sphere { centre, radius_m }
}

fn cylinder(
    mut point: Vector3<f64>,
    mut axis: Unit<Vector3<f64>>,
    mut radius_m: f64,
    points: &[Vector3<f64>],
) -> Surface {
    // Turns about the middle of the points, where they and moves of the axis are independent.
    let mean = points.iter().sum::<Vector3<f64>>() / (points.len() as f64).max(1.0);
    point += axis.as_ref() * axis.dot(&(mean - point));
    let reach = points.iter().map(|p| (p - mean).norm()).fold(0.0, f64::max);
    for _ in 0..MOST_STEPS {
        let e1 = perpendicular(&axis);
        let e2 = axis.cross(&e1);
        // Moves of the point along e1, e2; turns of the axis towards e1, e2; the radius.
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
        let Some(step) = newton_step(rows) else {
            break;
        };
        point += e1.as_ref() * step[0] + e2 * step[1];
        axis = Unit::new_normalize(axis.as_ref() + e1.as_ref() * step[2] + e2 * step[3]);
        radius_m += step[4];
        let moved = step[0].hypot(step[1]) + step[4].abs() + reach * step[2].hypot(step[3]);
        if moved < LEAST_STEP * radius_m.abs() {
            break;
        }
    }
    Surface::Cylinder {
        point,
        axis,
        radius_m,
    }
}

/// The least-squares step for rows (derivatives, residual).
fn newton_step<const N: usize>(
    rows: impl Iterator<Item = (SVector<f64, N>, f64)>,
) -> Option<SVector<f64, N>> {
    let mut normal = SMatrix::<f64, N, N>::zeros();
    let mut right = SVector::<f64, N>::zeros();
    for (row, residual) in rows {
        for a in 0..N {
            for b in 0..=a {
                normal[(a, b)] += row[a] * row[b];
            }
            right[a] -= row[a] * residual;
        }
    }
    let step = normal.cholesky()?.solve(&right);
    step.iter().all(|v| v.is_finite()).then_some(step)
}

#[cfg(test)]
mod tests {
    use super::{Surface, fitted};
    use nalgebra::{Unit, Vector3};

    fn grid(on: impl Fn(f64, f64) -> Vector3<f64>) -> Vec<Vector3<f64>> {
        let at = |i: i32| f64::from(i) * 0.1;
        (0..12)
            .flat_map(|i| (0..12).map(move |j| (at(i), at(j))))
            .map(|(a, b)| on(a, b))
            .collect()
    }

    #[test]
    fn exact_points_bring_a_rough_start_home() {
        let centre = Vector3::new(1.0, -2.0, 0.5);
        let ball =
            grid(|a, b| centre + Vector3::new(a.cos() * b.cos(), a.sin() * b.cos(), b.sin()) * 0.4);
        let start = Surface::Sphere {
            centre: centre + Vector3::new(0.05, 0.02, -0.06),
            radius_m: 0.5,
        };
        let Surface::Sphere {
            centre: c,
            radius_m,
        } = fitted(&start, &ball)
        else {
            panic!("the class is kept")
        };
        assert!((c - centre).norm() < 1e-6 && (radius_m - 0.4).abs() < 1e-6);

        let axis = Unit::new_normalize(Vector3::new(0.1, 0.2, 1.0));
        let e1 = axis.cross(&Vector3::x()).normalize();
        let e2 = axis.cross(&e1);
        let bar = grid(|a, h| centre + (e1 * a.cos() + e2 * a.sin()) * 0.3 + axis.as_ref() * h);
        let start = Surface::Cylinder {
            point: centre + e1 * 0.04,
            axis: Unit::new_normalize(axis.as_ref() + e2 * 0.1),
            radius_m: 0.35,
        };
        let Surface::Cylinder {
            axis: a, radius_m, ..
        } = fitted(&start, &bar)
        else {
            panic!("the class is kept")
        };
        assert!(a.dot(&axis) > 1.0 - 1e-9 && (radius_m - 0.3).abs() < 1e-6);
    }

    #[test]
    fn points_that_determine_nothing_leave_the_start() {
        let start = Surface::Sphere {
            centre: Vector3::zeros(),
            radius_m: 1.0,
        };
        for points in [vec![], vec![Vector3::x()], vec![Vector3::x(); 40]] {
            assert_eq!(fitted(&start, &points), start);
        }
    }
}
