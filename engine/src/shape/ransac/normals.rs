//! Normals of a bare cloud: the least principal axis of the points around each point.

use super::constants::{SPACING_POINTS, SPACING_QUERIES};
use super::kd_tree::KdTree;
use crate::mixture::Gaussian;
use nalgebra::{Point3, Vector3};

/// One unit normal per point from its `neighbours` nearest points (at least 3), oriented towards `sensor`. A point without a
/// plane around it (fewer than three points, or all at one position) gets the direction to the sensor.
pub fn estimate_normals(
    points: &[Point3<f64>],
    sensor: &Point3<f64>,
    neighbours: usize,
) -> Vec<Vector3<f64>> {
    let tree = KdTree::new(points);
    let mut near = Vec::new();
    points
        .iter()
        .map(|p| {
            near.clear();
            let found = tree.nearest(p, neighbours.max(3));
            near.extend(found.iter().filter_map(|(_, i)| points.get(*i as usize)));
            let towards = (sensor - p).try_normalize(1e-12).unwrap_or_else(Vector3::z);
            let normal = Gaussian::from_points(&near)
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

/// Typical spacing of points on a surface, metres: the median over some points of the distance to the sixth neighbour. 0 for
/// fewer than two points. Many points are subsampled: on surfaces, distances shrink with the root of the number.
pub(in crate::shape) fn spacing_m(points: &[Point3<f64>]) -> f64 {
    let finite = |p: &&Point3<f64>| p.iter().all(|v| v.is_finite());
    let stride = points.len().div_ceil(SPACING_POINTS).max(1);
    let some: Vec<Point3<f64>> = points
        .iter()
        .step_by(stride)
        .filter(finite)
        .copied()
        .collect();
    let tree = KdTree::new(&some);
    let query_stride = some.len().div_ceil(SPACING_QUERIES).max(1);
    let sixth = |p: &Point3<f64>| tree.nearest(p, 7).last().map(|(d, _)| d.sqrt());
    let mut distances: Vec<f64> = some
        .iter()
        .step_by(query_stride)
        .filter_map(sixth)
        .collect();
    distances.sort_by(f64::total_cmp);
    let median = distances.get(distances.len() / 2).copied().unwrap_or(0.0);
    median / (stride as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::{estimate_normals, spacing_m};
    use nalgebra::Point3;
    use rand::SeedableRng;
    use rand::seq::SliceRandom;
    use rand_chacha::ChaCha8Rng;

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
    fn the_spacing_scales_with_the_number_of_points() {
        for side in [20, 60, 200] {
            let step = 1.0 / f64::from(side);
            let mut points: Vec<_> = (0..side * side)
                .map(|i| Point3::new(f64::from(i % side) * step, f64::from(i / side) * step, 1.0))
                .collect();
            points.shuffle(&mut ChaCha8Rng::seed_from_u64(1));
            // The nearest are itself, four at one step, then a diagonal.
            let expected = 2f64.sqrt() * step;
            let got = spacing_m(&points);
            assert!(
                (got / expected - 1.0).abs() < 0.25,
                "{side}: {got} {expected}"
            );
        }
        assert_eq!(spacing_m(&[]), 0.0);
        assert_eq!(spacing_m(&[Point3::origin()]), 0.0);
        assert_eq!(spacing_m(&[Point3::new(f64::NAN, 0.0, 0.0); 3]), 0.0);
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
