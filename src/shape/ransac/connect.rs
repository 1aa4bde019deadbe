//! Connectivity: the largest connected patch of a primitive's inliers.
//!
//! Inliers lie within epsilon of the surface, so cells of space larger than that are as good as a
//! bitmap in the surface's own parameters, have no seams or poles, and need nothing per class.

use nalgebra::Point3;
use std::collections::HashMap;

/// Those of `inliers` (indices into `points`) in the largest patch connected through neighbouring
/// cells of `cell_m`, in their order.
pub(super) fn largest_patch(points: &[Point3<f64>], inliers: &[u32], cell_m: f64) -> Vec<u32> {
    let cell = |i: u32| {
        points
            .get(i as usize)
            .map(|p| [0, 1, 2].map(|k| (p[k] / cell_m).floor() as i64))
    };
    let mut number: HashMap<[i64; 3], usize> = HashMap::new();
    let mut cells = Vec::new();
    let mut members = Vec::with_capacity(inliers.len());
    for key in inliers.iter().filter_map(|&i| cell(i)) {
        let n = *number.entry(key).or_insert_with(|| {
            cells.push(key);
            cells.len() - 1
        });
        members.push(n);
    }
    let mut label = vec![usize::MAX; cells.len()];
    let mut labels = 0;
    for seed in 0..cells.len() {
        if label[seed] != usize::MAX {
            continue;
        }
        label[seed] = labels;
        let mut open = vec![seed];
        while let Some(here) = open.pop() {
            let [x, y, z] = cells[here];
            for step in 0..27 {
                let key = [x + step % 3 - 1, y + step / 3 % 3 - 1, z + step / 9 - 1];
                if let Some(&next) = number.get(&key)
                    && label[next] == usize::MAX
                {
                    label[next] = labels;
                    open.push(next);
                }
            }
        }
        labels += 1;
    }
    let mut sizes = vec![0usize; labels];
    members.iter().for_each(|&n| sizes[label[n]] += 1);
    // The first of equals: labels follow the inliers' order.
    let best = (0..labels).rev().max_by_key(|&l| sizes[l]).unwrap_or(0);
    let kept = inliers.iter().zip(&members);
    kept.filter(|(_, n)| label[**n] == best)
        .map(|(&i, _)| i)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::largest_patch;
    use nalgebra::Point3;

    #[test]
    fn a_gap_parts_patches() {
        let points: Vec<_> = (0..30)
            .map(|i| {
                Point3::new(
                    f64::from(i) * 0.1 + if i < 10 { 0.0 } else { 5.0 },
                    0.0,
                    -1.0,
                )
            })
            .collect();
        let all: Vec<u32> = (0..30).collect();
        let kept = largest_patch(&points, &all, 0.15);
        assert_eq!(kept, (10..30).collect::<Vec<u32>>());
        assert!(largest_patch(&points, &[], 0.15).is_empty());
    }
}
