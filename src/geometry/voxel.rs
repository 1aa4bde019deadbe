//! Thinning: one point per cube of space, so that crowded places do not outvote sparse ones.

use nalgebra::{Point3, Vector3};
use std::collections::HashMap;

/// A cloud thinned to the means of its voxels.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Thinned {
    /// Mean of the points of each occupied voxel, metres, in the order in which voxels were first met.
    pub points: Vec<Point3<f64>>,
    /// How many points each mean stands for.
    pub counts: Vec<usize>,
    /// For every input point, the index of its voxel in `points`.
    pub member_of: Vec<usize>,
}

/// Thins `points` (finite, metres) to voxels of side `voxel_m`, on a grid through the origin of the
/// frame. Deterministic. A side that is not above zero thins nothing.
pub fn thin(points: &[Point3<f64>], voxel_m: f64) -> Thinned {
    if voxel_m.is_nan() || voxel_m <= 0.0 {
        return Thinned {
            points: points.to_vec(),
            counts: vec![1; points.len()],
            member_of: (0..points.len()).collect(),
        };
    }
    let mut cells: HashMap<[i64; 3], usize> = HashMap::with_capacity(points.len() / 4);
    let mut thinned = Thinned {
        member_of: Vec::with_capacity(points.len()),
        ..Thinned::default()
    };
    let mut shifts: Vec<Vector3<f64>> = Vec::new();
    for p in points {
        let key = [p.x, p.y, p.z].map(|v| (v / voxel_m).floor() as i64);
        let cell = *cells.entry(key).or_insert(shifts.len());
        if cell == shifts.len() {
            thinned.points.push(*p);
            thinned.counts.push(0);
            shifts.push(Vector3::zeros());
        }
        // Relative to the first point: sums of small numbers even far from the origin.
        shifts[cell] += p - thinned.points[cell];
        thinned.counts[cell] += 1;
        thinned.member_of.push(cell);
    }
    for ((point, shift), &count) in thinned.points.iter_mut().zip(&shifts).zip(&thinned.counts) {
        *point += shift / count as f64;
    }
    thinned
}

#[cfg(test)]
mod tests {
    use super::thin;
    use nalgebra::{Point3, Vector3};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn mass_and_mean_are_kept(raw in proptest::collection::vec(proptest::array::uniform3(-2.0..2.0f64), 1..300), far in any::<bool>()) {
            let shift = if far { Vector3::new(1e6, -1e6, 1e6) } else { Vector3::zeros() };
            let points: Vec<_> = raw.iter().map(|p| Point3::from(*p) + shift).collect();
            let thinned = thin(&points, 0.5);
            prop_assert_eq!(thinned.counts.iter().sum::<usize>(), points.len());
            let mean: Vector3<f64> = points.iter().map(|p| p - points[0]).sum();
            let thin_mean: Vector3<f64> =
                thinned.points.iter().zip(&thinned.counts).map(|(p, &n)| (p - points[0]) * n as f64).sum();
            prop_assert!((mean - thin_mean).norm() < 1e-6);
            for (p, &cell) in points.iter().zip(&thinned.member_of) {
                prop_assert!((p - thinned.points[cell]).amax() <= 0.5 + 1e-9);
            }
        }
    }

    #[test]
    fn cells_come_in_the_order_of_their_first_points() {
        let points = [2.1, -0.1, 2.3, -0.3, 0.1].map(|x| Point3::new(x, 0.0, 0.0));
        let thinned = thin(&points, 1.0);
        assert_eq!(thinned.member_of, [0, 1, 0, 1, 2]);
        assert_eq!(thinned.counts, [2, 2, 1]);
        assert!((thinned.points[1].x + 0.2).abs() < 1e-15);
        assert_eq!(thin(&points, 0.0).points, points);
        assert!(thin(&[], 1.0).points.is_empty());
    }
}
