//! Localised sampling: points in Morton order, so that every octree cell is one run of them.

use nalgebra::Point3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Bits per axis of a Morton key.
const BITS: u32 = 16;

/// An octree as a sorted list of Morton keys.
pub(super) struct Cells {
    /// Key and index of each point, by key.
    sorted: Vec<(u64, u32)>,
    /// Levels worth sampling from, the root being 0.
    pub levels: u32,
}

impl Cells {
    /// Over `points[i]` for every i of `alive`; cells are not refined below `least_m`.
    pub fn new(points: &[Point3<f64>], alive: &[u32], least_m: f64) -> Self {
        let mut low = Point3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY);
        let mut high = -low;
        for p in alive.iter().filter_map(|&i| points.get(i as usize)) {
            low = low.inf(p);
            high = high.sup(p);
        }
        let side = (high - low).max().max(1e-12);
        let scale = f64::from(1u32 << BITS) * (1.0 - 1e-9) / side;
        let key = |p: &Point3<f64>| {
            let axis = |k: usize| spread(((p[k] - low[k]) * scale) as u64);
            axis(0) | axis(1) << 1 | axis(2) << 2
        };
        let mut sorted: Vec<(u64, u32)> = alive
            .iter()
            .filter_map(|&i| points.get(i as usize).map(|p| (key(p), i)))
            .collect();
        sorted.sort_unstable();
        let levels = (side / least_m.max(1e-12)).log2().floor().clamp(0.0, 10.0) as u32 + 1;
        Self { sorted, levels }
    }

    /// `wanted` different points: the first anywhere, the rest from its cell at `level`. `None`
    /// if the cell is too thinly settled.
    pub fn draw(&self, level: u32, wanted: usize, rng: &mut ChaCha8Rng) -> Option<Vec<u32>> {
        if self.sorted.is_empty() {
            return None;
        }
        let (key, first) = *self.sorted.get(rng.random_range(0..self.sorted.len()))?;
        let shift = 3 * (BITS - level.min(BITS));
        let cell = key >> shift;
        let from = self.sorted.partition_point(|(k, _)| k >> shift < cell);
        let to = self.sorted.partition_point(|(k, _)| k >> shift <= cell);
        if to - from < wanted {
            return None;
        }
        let mut drawn = vec![first];
        for _ in 0..4 * wanted {
            if drawn.len() == wanted {
                break;
            }
            let (_, i) = *self.sorted.get(rng.random_range(from..to))?;
            if !drawn.contains(&i) {
                drawn.push(i);
            }
        }
        (drawn.len() == wanted).then_some(drawn)
    }
}

/// Two zero bits between the bits of a `BITS`-bit number.
fn spread(v: u64) -> u64 {
    let v = v & 0xffff;
    let v = (v | v << 16) & 0x0000_ff00_00ff;
    let v = (v | v << 8) & 0x00f0_0f00_f00f;
    let v = (v | v << 4) & 0x0c30_c30c_30c3;
    (v | v << 2) & 0x2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::{Cells, spread};
    use nalgebra::Point3;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn bits_are_spread_by_three() {
        assert_eq!(spread(0b1011), 0b001_000_001_001);
        assert_eq!(spread(0xffff).count_ones(), 16);
        assert_eq!(spread(1 << 15), 1 << 45);
    }

    #[test]
    fn a_deep_cell_gives_neighbours() {
        let points: Vec<_> = (0..1000)
            .map(|i| Point3::new(f64::from(i) * 1e-3, 0.0, 0.0))
            .collect();
        let alive: Vec<u32> = (0..1000).collect();
        let cells = Cells::new(&points, &alive, 0.01);
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for _ in 0..50 {
            let drawn = cells.draw(5, 3, &mut rng).expect("settled cells");
            let spread = drawn.iter().max().expect("three") - drawn.iter().min().expect("three");
            assert!(spread <= 32, "{drawn:?}");
        }
    }
}
