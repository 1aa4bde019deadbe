//! Localised sampling (Schnabel section 4.3): points near one another lie on one primitive more
//! often. The octree is the points in Morton order, where every cell is one run of them.

use super::constants::{EVEN_SHARE, LEAST_CELL_EPSILONS, MORTON_BITS};
use super::sample::Sample;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// An octree as a sorted list of Morton keys.
pub(super) struct Octree {
    /// Key and place in the sample of each point, by key.
    sorted: Vec<(u32, u32)>,
    /// Levels that are drawn from, the root being 0.
    pub levels: u32,
}

impl Octree {
    /// Over all points of `sample`; cells much smaller than `epsilon_m` are not drawn from.
    pub fn new(sample: &Sample, epsilon_m: f64) -> Self {
        let side = sample.sides_m.max().max(f64::MIN_POSITIVE);
        let scale = (f64::from(1u32 << MORTON_BITS) / side) as f32;
        let [x, y, z] = &sample.at;
        // Casts saturate: what rounding puts outside the box lies in its outermost cell.
        let most = (1 << MORTON_BITS) - 1;
        let [left, front, bottom] = sample.low;
        let digit = |v: f32, low: f32| spread((((v - low) * scale) as u32).min(most));
        let mut sorted: Vec<(u32, u32)> = (0u32..)
            .zip(x.iter().zip(y).zip(z))
            .map(|(k, ((x, y), z))| {
                (
                    digit(*x, left) | digit(*y, front) << 1 | digit(*z, bottom) << 2,
                    k,
                )
            })
            .collect();
        sorted.sort_unstable();
        let finest = (side / (LEAST_CELL_EPSILONS * epsilon_m).max(f64::MIN_POSITIVE)).log2();
        let levels = finest.floor().clamp(0.0, f64::from(MORTON_BITS)) as u32 + 1;
        Self { sorted, levels }
    }

    /// Three different points: the first anywhere, the others from its cell at `level`. `None` if
    /// the cell is too thinly settled.
    pub fn draw(&self, level: u32, rng: &mut ChaCha8Rng) -> Option<[u32; 3]> {
        if self.sorted.len() < 3 {
            return None;
        }
        let at = rng.random_range(0..self.sorted.len());
        let (key, first) = *self.sorted.get(at)?;
        let shift = 3 * (MORTON_BITS - level.min(MORTON_BITS));
        let cell = key >> shift;
        let (from, to) = if level == 0 {
            (0, self.sorted.len())
        } else {
            let from = self.sorted.partition_point(|(k, _)| k >> shift < cell);
            let cells = self.sorted.get(from..)?;
            (
                from,
                from + cells.partition_point(|(k, _)| k >> shift == cell),
            )
        };
        if to - from < 3 {
            return None;
        }
        // Two different of the others: numbers that jump over those taken.
        let a = rng.random_range(from..to - 1);
        let a = a + usize::from(a >= at);
        let b = rng.random_range(from..to - 2);
        let (low, high) = (a.min(at), a.max(at));
        let b = b + usize::from(b >= low);
        let b = b + usize::from(b >= high);
        Some([first, self.sorted.get(a)?.1, self.sorted.get(b)?.1])
    }
}

/// Two zero bits between the bits of a `MORTON_BITS`-bit number.
fn spread(v: u32) -> u32 {
    let v = (v | v << 16) & 0x0300_00ff;
    let v = (v | v << 8) & 0x0300_f00f;
    let v = (v | v << 4) & 0x030c_30c3;
    (v | v << 2) & 0x0924_9249
}

/// How often each level is drawn from: mostly as its candidates scored, some evenly.
pub(super) struct Levels {
    share: Vec<f64>,
    score: Vec<f64>,
}

impl Levels {
    pub fn new(count: u32) -> Self {
        let count = count.max(1) as usize;
        Self {
            share: vec![1.0 / count as f64; count],
            score: vec![0.0; count],
        }
    }

    pub fn draw(&self, rng: &mut ChaCha8Rng) -> u32 {
        let mut left: f64 = rng.random();
        let level = self.share.iter().position(|s| {
            left -= s;
            left <= 0.0
        });
        level.unwrap_or(self.share.len() - 1) as u32
    }

    /// A candidate from `level` scored (or turned out to be worth less).
    pub fn credit(&mut self, level: u32, score: f64) {
        if let Some(s) = self.score.get_mut(level as usize) {
            *s = (*s + score).max(0.0);
        }
    }

    /// Draws from now on follow what was credited, per draw.
    pub fn reweigh(&mut self) {
        let rated = self.score.iter().zip(&self.share).map(|(s, p)| s / p);
        let total: f64 = rated.clone().sum();
        if total > 0.0 {
            let even = EVEN_SHARE / self.share.len() as f64;
            let rated: Vec<f64> = rated.collect();
            for (share, rate) in self.share.iter_mut().zip(rated) {
                *share = (1.0 - EVEN_SHARE) * rate / total + even;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Levels, Octree, spread};
    use crate::shape::ransac::cloud::Cloud;
    use crate::shape::ransac::sample::Sample;
    use nalgebra::{Point3, Vector3};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn keys_interleave() {
        assert_eq!(spread(0b11_1111_1111), 0o1_111_111_111);
        assert_eq!(spread(0b10_0000_0101), 0o1_000_000_101);
    }

    #[test]
    fn draws_differ_and_share_a_cell_of_the_level() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let points: Vec<_> = (0..4000)
            .map(|_| Point3::from(Vector3::from_fn(|_, _| rng.random_range(0.0..8.0))))
            .collect();
        let normals = vec![Vector3::z(); 4000];
        let sample = Cloud::of(&points, &normals).sample(4000, &mut rng);
        let tree = Octree::new(&sample, 0.24);
        assert_eq!(tree.levels, 4);
        for level in 0..4 {
            let side = sample.sides_m.max() / f64::from(1u32 << level);
            for _ in 0..200 {
                let Some(drawn) = tree.draw(level, &mut rng) else {
                    continue;
                };
                assert!(drawn[0] != drawn[1] && drawn[0] != drawn[2] && drawn[1] != drawn[2]);
                for axis in 0..3 {
                    let cell = drawn.map(|k| {
                        let v = sample.place(k)[axis] - f64::from(sample.low[axis]);
                        (v / side + 1e-9).min(f64::from(1u32 << level) - 1e-6)
                    });
                    let high = cell.iter().copied().fold(0.0, f64::max);
                    let low = cell.iter().copied().fold(f64::INFINITY, f64::min);
                    assert!((high - 1e-4).floor() <= (low + 1e-4).floor(), "{cell:?}");
                }
            }
        }
    }

    #[test]
    fn every_pair_of_a_cell_is_drawn() {
        let points: Vec<_> = (0..5)
            .map(|i| Point3::new(f64::from(i), 0.0, 0.0))
            .collect();
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let sample = Cloud::of(&points, &[Vector3::z(); 5]).sample(5, &mut rng);
        let tree = Octree::new(&sample, 1.0);
        let mut seen = std::collections::HashSet::new();
        for _ in 0..4000 {
            seen.insert(tree.draw(0, &mut rng).expect("five points"));
        }
        assert_eq!(seen.len(), 5 * 4 * 3);
        assert!(
            Octree::new(&Sample::default(), 1.0)
                .draw(0, &mut rng)
                .is_none()
        );
    }

    #[test]
    fn levels_that_score_are_drawn_more_often() {
        let mut levels = Levels::new(4);
        for _ in 0..10 {
            levels.credit(2, 50.0);
            levels.credit(1, 5.0);
            levels.reweigh();
        }
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut drawn = [0; 4];
        for _ in 0..4000 {
            drawn[levels.draw(&mut rng) as usize] += 1;
        }
        assert!(
            drawn[2] > 2000 && drawn.iter().all(|d| *d > 40),
            "{drawn:?}"
        );
    }
}
