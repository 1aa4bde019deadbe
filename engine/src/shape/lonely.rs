//! Points that stand alone. Segmentation leaves a few of another surface's in a novelty, and
//! moments have no defence: one point two metres off turns a ball into a rod.

use super::constants::{LONELY_COMPANY, LONELY_SPACINGS, MOST_LONELY_SHARE};
use super::ransac::spacing_m;
use crate::geometry::Grid;
use nalgebra::Point3;

/// The points with company: at least `LONELY_COMPANY` others within `LONELY_SPACINGS` times the
/// spacing of these points. All of them where that would leave too few to call the rest strays.
pub(super) fn in_company(points: &[Point3<f64>]) -> Vec<Point3<f64>> {
    let reach_m = LONELY_SPACINGS * spacing_m(points);
    if reach_m <= 0.0 {
        return points.to_vec();
    }
    let grid = Grid::new(points, reach_m);
    let kept: Vec<Point3<f64>> = points
        .iter()
        .filter(|p| {
            let mut others = 0;
            grid.for_each_within(p, reach_m, |_, _| others += 1);
            // Every point finds itself.
            others > LONELY_COMPANY
        })
        .copied()
        .collect();
    let strays = points.len() - kept.len();
    if strays as f64 > MOST_LONELY_SHARE * points.len() as f64 {
        return points.to_vec();
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::in_company;
    use nalgebra::Point3;

    fn sheet(n: usize) -> Vec<Point3<f64>> {
        (0..n * n)
            .map(|i| Point3::new(2.0, (i % n) as f64 * 0.05, (i / n) as f64 * 0.05))
            .collect()
    }

    #[test]
    fn strays_go_and_a_sheet_stays_whole() {
        for n in [4, 8, 30] {
            let mut points = sheet(n);
            assert_eq!(in_company(&points).len(), n * n);
            points.push(Point3::new(4.0, 1.0, 1.0));
            points.push(Point3::new(3.0, -1.0, 0.0));
            let kept = in_company(&points);
            assert_eq!(kept, sheet(n));
        }
    }

    #[test]
    fn a_sheet_that_thins_out_with_distance_stays_whole() {
        // Rows of a scan over a floor: spacing grows with the square of the range.
        let points: Vec<Point3<f64>> = (0..20)
            .flat_map(|i| {
                let x = 1.0 / (1.0 - 0.03 * f64::from(i));
                (0..10).map(move |k| Point3::new(x, f64::from(k) * 0.05 * x, 0.0))
            })
            .collect();
        assert_eq!(in_company(&points).len(), points.len());
    }

    #[test]
    fn scattered_points_are_all_kept() {
        let points: Vec<_> = (0..12)
            .map(|i| Point3::new(f64::from(i * i), f64::from(i % 3), 0.0))
            .collect();
        assert_eq!(in_company(&points).len(), points.len());
        assert!(in_company(&[]).is_empty());
    }
}
