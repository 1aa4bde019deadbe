//! Normals of a bare cloud: the least principal axis of each point's neighbourhood.

use super::neighbours::Neighbours;
use crate::mixture::Gaussian;
use nalgebra::{Point3, Vector3};

/// One unit normal per point from its `neighbours` nearest points (at least 3), turned towards
/// `sensor`. A point whose neighbourhood has no plane (fewer than three points, or all in one
/// place) gets the direction to the sensor.
pub fn estimate_normals(
    points: &[Point3<f64>],
    sensor: &Point3<f64>,
    neighbours: usize,
) -> Vec<Vector3<f64>> {
    let tree = Neighbours::new(points);
    let mut near = Vec::new();
    points
        .iter()
        .map(|p| {
            near.clear();
            let found = tree.nearest(p, neighbours.max(3));
            near.extend(found.iter().filter_map(|(_, i)| points.get(*i as usize)));
            let towards = (sensor - p).try_normalize(1e-12).unwrap_or_else(Vector3::z);
            let normal = Gaussian::of_points(&near)
                .filter(|g| near.len() >= 3 && g.covariance.trace() > 1e-18)
                .map(|g| {
                    let eigen = g.covariance.symmetric_eigen();
                    let least = eigen.eigenvalues.imin();
                    eigen.eigenvectors.column(least).normalize()
                })
                .filter(|n| n.iter().all(|v| v.is_finite()))
                .unwrap_or(towards);
            if normal.dot(&towards) < 0.0 {
                -normal
            } else {
                normal
            }
        })
        .collect()
}

/// Typical distance between neighbours, metres: the median over a sample of the points of the
/// distance to the sixth nearest. 0 for fewer than two points.
pub(in crate::shape) fn spacing_m(points: &[Point3<f64>]) -> f64 {
    let tree = Neighbours::new(points);
    let stride = points.len().div_ceil(200).max(1);
    let mut distances: Vec<f64> = points
        .iter()
        .step_by(stride)
        .filter_map(|p| tree.nearest(p, 7).last().map(|(d, _)| d.sqrt()))
        .collect();
    distances.sort_by(f64::total_cmp);
    distances.get(distances.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::estimate_normals;
    use nalgebra::Point3;

    #[test]
    fn a_tilted_sheet_has_one_normal_towards_the_sensor() {
        let points: Vec<_> = (0..100)
            .map(|i| (f64::from(i % 10) * 0.1, f64::from(i / 10) * 0.1))
            .map(|(x, y)| Point3::new(x, y, 3.0 + 0.5 * x))
            .collect();
        let normals = estimate_normals(&points, &Point3::origin(), 8);
        for n in normals {
            assert!((n.x - 0.5 * -n.z).abs() < 1e-9 && n.z < 0.0, "{n}");
        }
    }

    #[test]
    fn degenerate_clouds_get_finite_normals() {
        let same = [Point3::new(1.0, 1.0, 1.0); 5];
        for points in [&same[..], &same[..1], &[]] {
            for n in estimate_normals(points, &Point3::origin(), 8) {
                assert!((n.norm() - 1.0).abs() < 1e-9);
            }
        }
    }
}
