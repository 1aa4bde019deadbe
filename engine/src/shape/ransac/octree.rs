//! Localised sampling (Schnabel section 4.3): points close to one another are more often on one primitive. The octree is
//! the points in Morton order, where every cell is a range of them.

use super::constants::{MIN_CELL_EPSILONS, MORTON_BITS, UNIFORM_LEVEL_SHARE};
use super::sample::PointSample;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Points by Morton key.
pub(super) struct Octree {
    /// Key, and index in the sample.
    sorted: Vec<(u32, u32)>,
    /// Number of levels that are drawn from; level 0 is the root.
    pub levels: u32,
}

impl Octree {
    /// Of all points of `sample`; cells smaller than `MIN_CELL_EPSILONS` times `epsilon_m` are not drawn from.
    pub(super) fn new(sample: &PointSample, epsilon_m: f64) -> Self {
        let side = sample.sides_m.max().max(f64::MIN_POSITIVE);
        let scale = (f64::from(1u32 << MORTON_BITS) / side) as f32;
        let [x, y, z] = &sample.positions;
        // Casts saturate: what rounding puts outside the box is in its outermost cell.
        let last = (1 << MORTON_BITS) - 1;
        let [left, front, bottom] = sample.low;
        let cell_index = |v: f32, low: f32| spread_bits((((v - low) * scale) as u32).min(last));
        let mut sorted: Vec<(u32, u32)> = (0u32..)
            .zip(x.iter().zip(y).zip(z))
            .map(|(k, ((x, y), z))| {
                (
                    cell_index(*x, left) | cell_index(*y, front) << 1 | cell_index(*z, bottom) << 2,
                    k,
                )
            })
            .collect();
        sorted.sort_unstable();
        let finest = (side / (MIN_CELL_EPSILONS * epsilon_m).max(f64::MIN_POSITIVE)).log2();
        let levels = finest.floor().clamp(0.0, f64::from(MORTON_BITS)) as u32 + 1;
        Self { sorted, levels }
    }

    /// Indices of three distinct points: the first anywhere, the others from its cell at `level`. `None` if the cell has
    /// fewer.
    pub(super) fn draw(&self, level: u32, rng: &mut ChaCha8Rng) -> Option<[u32; 3]> {
        if self.sorted.len() < 3 {
            return None;
        }
        let first_index = rng.random_range(0..self.sorted.len());
        let (key, first) = *self.sorted.get(first_index)?;
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
        // Two distinct others: indices that skip those taken.
        let a = rng.random_range(from..to - 1);
        let a = a + usize::from(a >= first_index);
        let b = rng.random_range(from..to - 2);
        let (low, high) = (a.min(first_index), a.max(first_index));
        let b = b + usize::from(b >= low);
        let b = b + usize::from(b >= high);
        Some([first, self.sorted.get(a)?.1, self.sorted.get(b)?.1])
    }
}

/// Inserts two zero bits between the bits of a `MORTON_BITS`-bit number.
fn spread_bits(v: u32) -> u32 {
    let v = (v | v << 16) & 0x0300_00ff;
    let v = (v | v << 8) & 0x0300_f00f;
    let v = (v | v << 4) & 0x030c_30c3;
    (v | v << 2) & 0x0924_9249
}

/// Probability of each level: mostly in proportion to the scores of its candidates, the rest uniform.
pub(super) struct LevelWeights {
    share: Vec<f64>,
    score: Vec<f64>,
}

impl LevelWeights {
    pub(super) fn new(count: u32) -> Self {
        let count = count.max(1) as usize;
        Self {
            share: vec![1.0 / count as f64; count],
            score: vec![0.0; count],
        }
    }

    pub(super) fn draw(&self, rng: &mut ChaCha8Rng) -> u32 {
        let mut left: f64 = rng.random();
        let level = self.share.iter().position(|s| {
            left -= s;
            left <= 0.0
        });
        level.unwrap_or(self.share.len() - 1) as u32
    }

    /// Adds the score of a candidate from `level` (negative where a candidate was overrated).
    pub(super) fn add_score(&mut self, level: u32, score: f64) {
        if let Some(s) = self.score.get_mut(level as usize) {
            *s = (*s + score).max(0.0);
        }
    }

    /// Updates the probabilities by the scores per draw.
    pub(super) fn update(&mut self) {
        let rates = self.score.iter().zip(&self.share).map(|(s, p)| s / p);
        let total: f64 = rates.clone().sum();
        if total > 0.0 {
            let even = UNIFORM_LEVEL_SHARE / self.share.len() as f64;
            let rates: Vec<f64> = rates.collect();
            for (share, rate) in self.share.iter_mut().zip(rates) {
                *share = (1.0 - UNIFORM_LEVEL_SHARE) * rate / total + even;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{LevelWeights, Octree, spread_bits};
    use crate::shape::ransac::cloud::Cloud;
    use crate::shape::ransac::sample::PointSample;
    use nalgebra::{Point3, Vector3};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn bits_are_spread_for_morton_keys() {
        assert_eq!(spread_bits(0b11_1111_1111), 0o1_111_111_111);
        assert_eq!(spread_bits(0b10_0000_0101), 0o1_000_000_101);
    }

    #[test]
    fn drawn_points_are_distinct_and_in_one_cell_of_the_level() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let points: Vec<_> = (0..4000)
            .map(|_| Point3::from(Vector3::from_fn(|_, _| rng.random_range(0.0..8.0))))
            .collect();
        let normals = vec![Vector3::z(); 4000];
        let sample = Cloud::new(&points, &normals).sample(4000, &mut rng);
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
                        let v = sample.position(k)[axis] - f64::from(sample.low[axis]);
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
    fn every_ordered_triple_of_a_cell_is_drawn() {
        let points: Vec<_> = (0..5)
            .map(|i| Point3::new(f64::from(i), 0.0, 0.0))
            .collect();
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let sample = Cloud::new(&points, &[Vector3::z(); 5]).sample(5, &mut rng);
        let tree = Octree::new(&sample, 1.0);
        let mut seen = std::collections::HashSet::new();
        for _ in 0..4000 {
            seen.insert(tree.draw(0, &mut rng).expect("five points"));
        }
        assert_eq!(seen.len(), 5 * 4 * 3);
        assert!(
            Octree::new(&PointSample::default(), 1.0)
                .draw(0, &mut rng)
                .is_none()
        );
    }

    #[test]
    fn levels_with_scores_are_drawn_more_often() {
        let mut levels = LevelWeights::new(4);
        for _ in 0..10 {
            levels.add_score(2, 50.0);
            levels.add_score(1, 5.0);
            levels.update();
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
