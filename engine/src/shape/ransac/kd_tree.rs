//! A balanced k-d tree in one array.

use nalgebra::Point3;

/// Indices into the points; the middle of every range is its splitting point.
pub(super) struct KdTree<'a> {
    points: &'a [Point3<f64>],
    order: Vec<u32>,
}

impl<'a> KdTree<'a> {
    pub(super) fn new(points: &'a [Point3<f64>]) -> Self {
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        split(points, &mut order, 0);
        Self { points, order }
    }

    /// Squared distance and index of the `count` points nearest to `p`, nearest first.
    pub(super) fn nearest(&self, p: &Point3<f64>, count: usize) -> Vec<(f64, u32)> {
        let mut found = Vec::with_capacity(count + 1);
        if count > 0 {
            self.search(&self.order, 0, p, count, &mut found);
        }
        found
    }

    fn search(
        &self,
        range: &[u32],
        depth: usize,
        p: &Point3<f64>,
        count: usize,
        found: &mut Vec<(f64, u32)>,
    ) {
        let middle = range.len() / 2;
        let (Some(&index), Some(below), Some(above)) = (
            range.get(middle),
            range.get(..middle),
            range.get(middle + 1..),
        ) else {
            return;
        };
        let q = &self.points[index as usize];
        let entry = ((q - p).norm_squared(), index);
        if found.len() < count || found.last().is_some_and(|last| entry < *last) {
            let at = found.partition_point(|f| *f < entry);
            found.insert(at, entry);
            found.truncate(count);
        }
        let axis = depth % 3;
        let over = p[axis] - q[axis];
        let (near, far) = if over < 0.0 {
            (below, above)
        } else {
            (above, below)
        };
        self.search(near, depth + 1, p, count, found);
        if found.len() < count || found.last().is_some_and(|f| over * over <= f.0) {
            self.search(far, depth + 1, p, count, found);
        }
    }
}

fn split(points: &[Point3<f64>], range: &mut [u32], depth: usize) {
    if range.len() < 2 {
        return;
    }
    let axis = depth % 3;
    let middle = range.len() / 2;
    let key = |i: u32| points[i as usize][axis];
    let (below, _, above) =
        range.select_nth_unstable_by(middle, |&a, &b| key(a).total_cmp(&key(b)).then(a.cmp(&b)));
    split(points, below, depth + 1);
    split(points, above, depth + 1);
}

#[cfg(test)]
mod tests {
    use super::KdTree;
    use nalgebra::Point3;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn neighbours_are_those_of_exhaustive_search() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let points: Vec<Point3<f64>> = (0..500)
            .map(|_| Point3::new(rng.random(), rng.random(), rng.random_range(0.0..0.1)))
            .collect();
        let tree = KdTree::new(&points);
        for p in &points[..50] {
            let mut all: Vec<(f64, u32)> = (0..500u32)
                .map(|i| ((points[i as usize] - p).norm_squared(), i))
                .collect();
            all.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
            assert_eq!(tree.nearest(p, 12), all[..12]);
        }
        assert!(KdTree::new(&[]).nearest(&Point3::origin(), 3).is_empty());
    }
}
