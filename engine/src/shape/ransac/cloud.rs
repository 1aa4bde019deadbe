//! The points of the caller that are still searched, and the frame of the search.

use super::sample::PointSample;
use nalgebra::{Point3, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Oriented points of the caller; indices are the caller's.
#[derive(Debug, Clone, Default)]
pub(super) struct Cloud<'a> {
    points: &'a [Point3<f64>],
    /// Unit normals, of either sign.
    normals: &'a [Vector3<f64>],
    /// Indices of the points that take part, rising; `None` while all do.
    active_indices: Option<Vec<u32>>,
    /// Origin of this frame in the caller's frame: a point of the cloud.
    pub origin: Point3<f64>,
    /// Lower corner of the box around all points, in this frame, metres.
    pub low: [f32; 3],
    /// Sides of that box, metres.
    pub sides_m: Vector3<f64>,
}

/// The points that take part: all, or those at some indices.
pub(super) enum ActivePoints<'a> {
    All(&'a [Point3<f64>], &'a [Vector3<f64>]),
    Indices(&'a [u32]),
}

impl<'a> Cloud<'a> {
    /// All points that are finite and have a finite normal.
    pub(super) fn new(points: &'a [Point3<f64>], normals: &'a [Vector3<f64>]) -> Self {
        let finite = |v: [f64; 3]| v.iter().all(|c| (*c as f32).is_finite());
        let origin = points.iter().find(|p| finite((**p).into()));
        let origin = origin.copied().unwrap_or_default();
        let count = points.len().min(normals.len());
        let (points, normals) = (&points[..count], &normals[..count]);
        let mut cloud = Self {
            points,
            normals,
            origin,
            ..Self::default()
        };
        // Testing the extremes tests every point.
        let (all, normal_extremes) = (Extremes::new(points), Extremes::new(normals));
        let finite_vector = |v: &Vector3<f64>| finite((*v).into());
        let from = origin.coords;
        let extremes = [
            all.low - from,
            all.high - from,
            normal_extremes.low,
            normal_extremes.high,
        ];
        let mut ends = all;
        if !(all.all_finite & normal_extremes.all_finite & extremes.iter().all(finite_vector)) {
            let takes_part = |k: &u32| {
                let k = *k as usize;
                finite_vector(&(points[k] - origin)) && finite_vector(&normals[k])
            };
            let active_indices: Vec<u32> = (0..count as u32).filter(takes_part).collect();
            let those: Vec<_> = active_indices.iter().map(|&k| points[k as usize]).collect();
            ends = Extremes::new(&those);
            cloud.active_indices = Some(active_indices);
        }
        if cloud.len() > 0 {
            cloud.low = (ends.low - origin.coords).map(|v| v as f32).into();
            cloud.sides_m = ends.high - ends.low;
        }
        cloud
    }

    pub(super) fn len(&self) -> usize {
        self.active_indices
            .as_ref()
            .map_or(self.points.len(), Vec::len)
    }

    /// Diagonal of the box, metres.
    pub(super) fn diagonal_m(&self) -> f64 {
        self.sides_m.norm()
    }

    pub(super) fn active(&self) -> ActivePoints<'_> {
        match &self.active_indices {
            None => ActivePoints::All(self.points, self.normals),
            Some(active_indices) => ActivePoints::Indices(active_indices),
        }
    }

    /// Position of point `k` in this frame; the origin if there is none.
    pub(super) fn position(&self, k: u32) -> Vector3<f64> {
        let point = self.points.get(k as usize);
        point.map_or_else(Vector3::zeros, |p| p - self.origin)
    }

    /// Point `k` in the caller's frame and its normal; zeros if there is none.
    #[inline(always)]
    pub(super) fn oriented_point(&self, k: u32) -> (Point3<f64>, Vector3<f64>) {
        let k = k as usize;
        match (self.points.get(k), self.normals.get(k)) {
            (Some(p), Some(n)) => (*p, *n),
            _ => Default::default(),
        }
    }

    /// `count` distinct points (all, if there are fewer) in random order.
    pub(super) fn sample(&self, count: usize, rng: &mut ChaCha8Rng) -> PointSample {
        let drawn = distinct(count.min(self.len()), self.len(), rng);
        let mut sample = PointSample::with_capacity(drawn.len(), self.low, self.sides_m);
        for k in drawn {
            let index = self
                .active_indices
                .as_ref()
                .map_or(k, |active| active[k as usize]);
            let (point, normal) = self.oriented_point(index);
            sample.push(&(point - self.origin), &normal);
        }
        sample
    }

    /// Removes the points at `indices` (rising).
    pub(super) fn remove(&mut self, indices: &[u32]) {
        let mut keep = vec![true; self.points.len()];
        indices.iter().for_each(|&k| keep[k as usize] = false);
        self.active_indices = Some(match self.active_indices.take() {
            None => retained(0..self.points.len() as u32, &keep),
            Some(active_indices) => retained(active_indices.into_iter(), &keep),
        });
    }
}

fn retained(indices: impl ExactSizeIterator<Item = u32>, keep: &[bool]) -> Vec<u32> {
    // Every index is written, and overwritten by the next one unless it is kept.
    let mut kept = vec![0; indices.len() + 1];
    let mut count = 0;
    for k in indices {
        kept[count] = k;
        count += usize::from(keep[k as usize]);
    }
    kept.truncate(count);
    kept
}

/// Least and greatest of each of three coordinates; infinities if there is no point.
#[derive(Debug, Clone, Copy)]
struct Extremes {
    low: Vector3<f64>,
    high: Vector3<f64>,
    all_finite: bool,
}

impl Extremes {
    fn new<T: Copy + Into<[f64; 3]>>(all: &[T]) -> Self {
        // Four accumulators, so that they share vector instructions.
        let mut low = [[f64::INFINITY; 3]; 4];
        let mut high = [[f64::NEG_INFINITY; 3]; 4];
        let mut zero = [[0.0; 3]; 4];
        let mut take = |j: usize, one: T| {
            let one = one.into();
            for k in 0..3 {
                low[j][k] = if one[k] < low[j][k] {
                    one[k]
                } else {
                    low[j][k]
                };
                high[j][k] = if one[k] > high[j][k] {
                    one[k]
                } else {
                    high[j][k]
                };
                // NaN from the first value on that is not finite.
                zero[j][k] += one[k] * 0.0;
            }
        };
        let (fours, rest) = all.as_chunks::<4>();
        for four in fours {
            (0..4).for_each(|j| take(j, four[j]));
        }
        rest.iter().for_each(|&one| take(0, one));
        Self {
            low: low
                .map(Vector3::from)
                .into_iter()
                .fold(low[0].into(), |a, b| a.inf(&b)),
            high: high
                .map(Vector3::from)
                .into_iter()
                .fold(high[0].into(), |a, b| a.sup(&b)),
            all_finite: zero.as_flattened().iter().all(|&v| v == 0.0),
        }
    }
}

/// `count` distinct numbers below `below` in random order.
fn distinct(count: usize, below: usize, rng: &mut ChaCha8Rng) -> Vec<u32> {
    if 2 * count > below {
        let all = rand::seq::index::sample(rng, below, count);
        return all.into_iter().map(|k| k as u32).collect();
    }
    // Few among many: duplicates are rare, and no list of all numbers is needed.
    let mut taken = vec![false; below];
    let mut drawn = Vec::with_capacity(count);
    while drawn.len() < count {
        let k = rng.random_range(0..below as u32);
        if !std::mem::replace(&mut taken[k as usize], true) {
            drawn.push(k);
        }
    }
    drawn
}

#[cfg(test)]
mod tests {
    use super::{ActivePoints, Cloud};
    use nalgebra::{Point3, Vector3};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    fn row(n: u32) -> (Vec<Point3<f64>>, Vec<Vector3<f64>>) {
        let points = (0..n).map(|i| Point3::new(1e6 + f64::from(i), -f64::from(i), 3.0));
        (points.collect(), vec![Vector3::z(); n as usize])
    }

    fn active_indices(cloud: &Cloud) -> Vec<u32> {
        match cloud.active() {
            ActivePoints::All(points, _) => (0..points.len() as u32).collect(),
            ActivePoints::Indices(indices) => indices.to_vec(),
        }
    }

    #[test]
    fn coordinates_are_relative_to_a_point_of_the_cloud() {
        let (points, normals) = row(101);
        let cloud = Cloud::new(&points, &normals);
        assert_eq!(cloud.origin, Point3::new(1e6, 0.0, 3.0));
        assert_eq!(cloud.position(50), Vector3::new(50.0, -50.0, 0.0));
        assert_eq!(cloud.position(101), Vector3::zeros());
        assert_eq!(cloud.low, [0.0, -100.0, 0.0]);
        assert_eq!(cloud.sides_m, Vector3::new(100.0, 100.0, 0.0));
        assert_eq!(cloud.oriented_point(7), (points[7], Vector3::z()));
    }

    #[test]
    fn points_that_are_not_finite_take_no_part() {
        let mut points = vec![Point3::new(1.0, 2.0, 3.0); 6];
        points[0].z = f64::INFINITY;
        points[1].y = f64::NAN;
        points[4].x = 1e39;
        let mut normals = vec![Vector3::x(); 6];
        normals[3].x = f64::NAN;
        normals[5].y = 1e300;
        let cloud = Cloud::new(&points, &normals);
        assert_eq!(active_indices(&cloud), [2]);
        assert_eq!((cloud.low, cloud.sides_m), ([0.0; 3], Vector3::zeros()));
        assert!(cloud.position(2).norm() < 1e-12);
        let none = Cloud::new(&points[..2], &normals[..2]);
        assert_eq!((none.len(), none.diagonal_m()), (0, 0.0));
        // Normals of some of the points only.
        assert_eq!(Cloud::new(&points[2..], &normals[..1]).len(), 1);
    }

    #[test]
    fn removed_points_leave_the_others_in_order() {
        let (points, normals) = row(10);
        for gone in [
            &[][..],
            &[0],
            &[9],
            &[0, 1, 2, 9],
            &[3, 5, 6],
            &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9],
        ] {
            let mut cloud = Cloud::new(&points, &normals);
            cloud.remove(gone);
            let mut kept: Vec<u32> = (0..10).filter(|k| !gone.contains(k)).collect();
            assert_eq!(active_indices(&cloud), kept);
            // And again: indices stay the caller's.
            if let Some(last) = kept.pop() {
                cloud.remove(&[last]);
                assert_eq!(active_indices(&cloud), kept);
                assert_eq!(cloud.len(), kept.len());
            }
        }
    }

    #[test]
    fn a_sample_has_no_point_twice_and_no_removed_one() {
        let (points, normals) = row(100);
        let mut cloud = Cloud::new(&points, &normals);
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for (from, count) in [
            (0, 0),
            (0, 1),
            (0, 50),
            (0, 100),
            (0, 300),
            (40, 20),
            (40, 90),
        ] {
            cloud.remove(&(0..from).collect::<Vec<u32>>());
            let sample = cloud.sample(count, &mut rng);
            let mut drawn: Vec<i64> = (0..sample.len() as u32)
                .map(|k| sample.position(k).x as i64)
                .collect();
            drawn.sort_unstable();
            drawn.dedup();
            assert_eq!(drawn.len(), count.min(100 - from as usize));
            assert!(drawn.iter().all(|x| (i64::from(from)..100).contains(x)));
        }
    }

    #[test]
    fn all_points_are_sampled_equally_often() {
        let (points, normals) = row(30);
        let cloud = Cloud::new(&points, &normals);
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        // Both ways of drawing; binomial, five standard deviations.
        for count in [6, 24] {
            let mut firsts = [0.0f64; 30];
            let mut drawn = [0.0f64; 30];
            for _ in 0..6000 {
                let sample = cloud.sample(count, &mut rng);
                firsts[sample.position(0).x as usize] += 1.0;
                for k in 0..count as u32 {
                    drawn[sample.position(k).x as usize] += 1.0;
                }
            }
            let share = count as f64 / 30.0;
            let within = |got: &f64, p: f64| {
                (got - 6000.0 * p).abs() < 5.0 * (6000.0 * p * (1.0 - p)).sqrt()
            };
            assert!(firsts.iter().all(|n| within(n, 1.0 / 30.0)), "{firsts:?}");
            assert!(drawn.iter().all(|n| within(n, share)), "{drawn:?}");
        }
    }
}
