//! The caller's points as the search sees them: which of them take part, and the frame about them.

use super::sample::Sample;
use nalgebra::{Point3, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Oriented points, borrowed; a place is an index into what the caller gave.
#[derive(Debug, Clone, Default)]
pub(super) struct Cloud<'a> {
    points: &'a [Point3<f64>],
    /// Unit normals, of either sign.
    normals: &'a [Vector3<f64>],
    /// Places of the points that take part, rising; `None` while all do.
    left: Option<Vec<u32>>,
    /// Origin of this frame in the caller's: a point of the cloud.
    pub origin: Point3<f64>,
    /// Least coordinates of all points, in this frame, metres.
    pub low: [f32; 3],
    /// Lengths of the box around all points, metres.
    pub sides_m: Vector3<f64>,
}

/// Some points, those of all places or of a few.
pub(super) enum Part<'a> {
    All(&'a [Point3<f64>], &'a [Vector3<f64>]),
    At(&'a [u32]),
}

impl<'a> Cloud<'a> {
    /// All points that are finite and have a finite normal.
    pub fn of(points: &'a [Point3<f64>], normals: &'a [Vector3<f64>]) -> Self {
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
        // One test of the extremes stands for one of every point.
        let (all, lean) = (Ends::of(points), Ends::of(normals));
        let sound = |v: &Vector3<f64>| finite((*v).into());
        let from = origin.coords;
        let extremes = [all.low - from, all.high - from, lean.low, lean.high];
        let mut ends = all;
        if !(all.numbers & lean.numbers & extremes.iter().all(sound)) {
            let takes_part = |k: &u32| {
                let k = *k as usize;
                sound(&(points[k] - origin)) && sound(&normals[k])
            };
            let left: Vec<u32> = (0..count as u32).filter(takes_part).collect();
            let those: Vec<_> = left.iter().map(|&k| points[k as usize]).collect();
            ends = Ends::of(&those);
            cloud.left = Some(left);
        }
        if cloud.len() > 0 {
            cloud.low = (ends.low - origin.coords).map(|v| v as f32).into();
            cloud.sides_m = ends.high - ends.low;
        }
        cloud
    }

    pub fn len(&self) -> usize {
        self.left.as_ref().map_or(self.points.len(), Vec::len)
    }

    /// Length of the box's diagonal, metres.
    pub fn diagonal_m(&self) -> f64 {
        self.sides_m.norm()
    }

    /// Those that take part.
    pub fn part(&self) -> Part<'_> {
        match &self.left {
            None => Part::All(self.points, self.normals),
            Some(left) => Part::At(left),
        }
    }

    /// Place of point `k` in this frame; the origin if there is none.
    pub fn place(&self, k: u32) -> Vector3<f64> {
        let point = self.points.get(k as usize);
        point.map_or_else(Vector3::zeros, |p| p - self.origin)
    }

    /// Point `k` as the caller gave it and its normal; zeros if there is none.
    #[inline(always)]
    pub fn given(&self, k: u32) -> (Point3<f64>, Vector3<f64>) {
        let k = k as usize;
        match (self.points.get(k), self.normals.get(k)) {
            (Some(p), Some(n)) => (*p, *n),
            _ => Default::default(),
        }
    }

    /// `count` different points (all, if there are fewer) in random order.
    pub fn sample(&self, count: usize, rng: &mut ChaCha8Rng) -> Sample {
        let drawn = different(count.min(self.len()), self.len(), rng);
        let mut sample = Sample::with_room(drawn.len(), self.low, self.sides_m);
        for k in drawn {
            let place = self.left.as_ref().map_or(k, |left| left[k as usize]);
            let (point, normal) = self.given(place);
            sample.push(&(point - self.origin), &normal);
        }
        sample
    }

    /// Takes out the points at `places` (rising).
    pub fn remove(&mut self, places: &[u32]) {
        let mut stays = vec![true; self.points.len()];
        places.iter().for_each(|&k| stays[k as usize] = false);
        self.left = Some(match self.left.take() {
            None => staying(0..self.points.len() as u32, &stays),
            Some(left) => staying(left.into_iter(), &stays),
        });
    }
}

fn staying(places: impl ExactSizeIterator<Item = u32>, stays: &[bool]) -> Vec<u32> {
    // Every place is written and the next one overwrites it unless it stays.
    let mut kept = vec![0; places.len() + 1];
    let mut count = 0;
    for k in places {
        kept[count] = k;
        count += usize::from(stays[k as usize]);
    }
    kept.truncate(count);
    kept
}

/// Least and greatest of each of three coordinates; infinities of none.
#[derive(Debug, Clone, Copy)]
struct Ends {
    low: Vector3<f64>,
    high: Vector3<f64>,
    /// Whether all are finite.
    numbers: bool,
}

impl Ends {
    fn of<T: Copy + Into<[f64; 3]>>(all: &[T]) -> Self {
        // Four at a time, each for itself until the end, so that they share instructions.
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
                // Not a number from the first infinity on.
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
            numbers: zero.as_flattened().iter().all(|&v| v == 0.0),
        }
    }
}

/// `count` different numbers below `of` in random order.
fn different(count: usize, of: usize, rng: &mut ChaCha8Rng) -> Vec<u32> {
    if 2 * count > of {
        let all = rand::seq::index::sample(rng, of, count);
        return all.into_iter().map(|k| k as u32).collect();
    }
    // Few among many: hardly one is drawn twice, and no list of all is needed.
    let mut taken = vec![false; of];
    let mut drawn = Vec::with_capacity(count);
    while drawn.len() < count {
        let k = rng.random_range(0..of as u32);
        if !std::mem::replace(&mut taken[k as usize], true) {
            drawn.push(k);
        }
    }
    drawn
}

#[cfg(test)]
mod tests {
    use super::{Cloud, Part};
    use nalgebra::{Point3, Vector3};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    fn row(n: u32) -> (Vec<Point3<f64>>, Vec<Vector3<f64>>) {
        let points = (0..n).map(|i| Point3::new(1e6 + f64::from(i), -f64::from(i), 3.0));
        (points.collect(), vec![Vector3::z(); n as usize])
    }

    fn left(cloud: &Cloud) -> Vec<u32> {
        match cloud.part() {
            Part::All(points, _) => (0..points.len() as u32).collect(),
            Part::At(places) => places.to_vec(),
        }
    }

    #[test]
    fn coordinates_are_from_a_point_of_the_cloud() {
        let (points, normals) = row(101);
        let cloud = Cloud::of(&points, &normals);
        assert_eq!(cloud.origin, Point3::new(1e6, 0.0, 3.0));
        assert_eq!(cloud.place(50), Vector3::new(50.0, -50.0, 0.0));
        assert_eq!(cloud.place(101), Vector3::zeros());
        assert_eq!(cloud.low, [0.0, -100.0, 0.0]);
        assert_eq!(cloud.sides_m, Vector3::new(100.0, 100.0, 0.0));
        assert_eq!(cloud.given(7), (points[7], Vector3::z()));
    }

    #[test]
    fn what_is_not_finite_takes_no_part() {
        let mut points = vec![Point3::new(1.0, 2.0, 3.0); 6];
        points[0].z = f64::INFINITY;
        points[1].y = f64::NAN;
        points[4].x = 1e39;
        let mut normals = vec![Vector3::x(); 6];
        normals[3].x = f64::NAN;
        normals[5].y = 1e300;
        let cloud = Cloud::of(&points, &normals);
        assert_eq!(left(&cloud), [2]);
        assert_eq!((cloud.low, cloud.sides_m), ([0.0; 3], Vector3::zeros()));
        assert!(cloud.place(2).norm() < 1e-12);
        let none = Cloud::of(&points[..2], &normals[..2]);
        assert_eq!((none.len(), none.diagonal_m()), (0, 0.0));
        // Normals of some of the points only.
        assert_eq!(Cloud::of(&points[2..], &normals[..1]).len(), 1);
    }

    #[test]
    fn points_taken_out_leave_the_others_in_order() {
        let (points, normals) = row(10);
        for gone in [
            &[][..],
            &[0],
            &[9],
            &[0, 1, 2, 9],
            &[3, 5, 6],
            &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9],
        ] {
            let mut cloud = Cloud::of(&points, &normals);
            cloud.remove(gone);
            let mut kept: Vec<u32> = (0..10).filter(|k| !gone.contains(k)).collect();
            assert_eq!(left(&cloud), kept);
            // And again: places stay the caller's.
            if let Some(last) = kept.pop() {
                cloud.remove(&[last]);
                assert_eq!(left(&cloud), kept);
                assert_eq!(cloud.len(), kept.len());
            }
        }
    }

    #[test]
    fn a_sample_has_no_point_twice_and_none_that_was_taken_out() {
        let (points, normals) = row(100);
        let mut cloud = Cloud::of(&points, &normals);
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
                .map(|k| sample.place(k).x as i64)
                .collect();
            drawn.sort_unstable();
            drawn.dedup();
            assert_eq!(drawn.len(), count.min(100 - from as usize));
            assert!(drawn.iter().all(|x| (i64::from(from)..100).contains(x)));
        }
    }

    #[test]
    fn every_point_is_sampled_as_often_as_any_other() {
        let (points, normals) = row(30);
        let cloud = Cloud::of(&points, &normals);
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        // Both ways of drawing; binomial, five standard deviations.
        for count in [6, 24] {
            let mut firsts = [0.0f64; 30];
            let mut drawn = [0.0f64; 30];
            for _ in 0..6000 {
                let sample = cloud.sample(count, &mut rng);
                firsts[sample.place(0).x as usize] += 1.0;
                for k in 0..count as u32 {
                    drawn[sample.place(k).x as usize] += 1.0;
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
