//! Radius outlier removal. Segmentation leaves a few points of other surfaces in a novelty, and moments are not robust: one
//! point two metres off turns a ball into a rod.

use crate::geometry::PointGrid;
use crate::shape::constants::{MAX_OUTLIER_SHARE, MIN_NEIGHBOURS, OUTLIER_RADIUS_SPACINGS};
use crate::shape::ransac::spacing_m;
use nalgebra::Point3;

/// The points with at least `MIN_NEIGHBOURS` neighbours within `OUTLIER_RADIUS_SPACINGS` times the spacing of the
/// points; all points if more than `MAX_OUTLIER_SHARE` of them had fewer.
pub(in crate::shape) fn remove_outliers(points: &[Point3<f64>]) -> Vec<Point3<f64>> {
    let radius_m = OUTLIER_RADIUS_SPACINGS * spacing_m(points);
    if radius_m <= 0.0 {
        return points.to_vec();
    }
    let grid = PointGrid::new(points, radius_m);
    let kept: Vec<Point3<f64>> = points
        .iter()
        .filter(|p| {
            let mut count = 0;
            grid.for_each_within(p, radius_m, |_, _| count += 1);
            // The point itself is among them.
            count > MIN_NEIGHBOURS
        })
        .copied()
        .collect();
    let outliers = points.len() - kept.len();
    if outliers as f64 > MAX_OUTLIER_SHARE * points.len() as f64 {
        return points.to_vec();
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::remove_outliers;
    use nalgebra::Point3;

    fn sheet(n: usize) -> Vec<Point3<f64>> {
        (0..n * n)
            .map(|i| Point3::new(2.0, (i % n) as f64 * 0.05, (i / n) as f64 * 0.05))
            .collect()
    }

    #[test]
    fn outliers_are_removed_and_a_sheet_is_kept() {
        for n in [4, 8, 30] {
            let mut points = sheet(n);
            assert_eq!(remove_outliers(&points).len(), n * n);
            points.push(Point3::new(4.0, 1.0, 1.0));
            points.push(Point3::new(3.0, -1.0, 0.0));
            let kept = remove_outliers(&points);
            assert_eq!(kept, sheet(n));
        }
    }

    #[test]
    fn a_sheet_that_thins_out_with_distance_is_kept() {
        // Rows of a scan over a floor: spacing grows with the square of the range.
        let points: Vec<Point3<f64>> = (0..20)
            .flat_map(|i| {
                let x = 1.0 / (1.0 - 0.03 * f64::from(i));
                (0..10).map(move |k| Point3::new(x, f64::from(k) * 0.05 * x, 0.0))
            })
            .collect();
        assert_eq!(remove_outliers(&points).len(), points.len());
    }

    #[test]
    fn scattered_points_are_all_kept() {
        let points: Vec<_> = (0..12)
            .map(|i| Point3::new(f64::from(i * i), f64::from(i % 3), 0.0))
            .collect();
        assert_eq!(remove_outliers(&points).len(), points.len());
        assert!(remove_outliers(&[]).is_empty());
    }
}
