//! A hash grid over points: who lies near a place? Built once, read by many threads.

use nalgebra::Point3;
use rayon::prelude::*;

/// Cells per axis run from `-HALF` to `HALF`; places beyond share the outermost cells, which costs
/// time, never truth, since distances are always tested.
const HALF: i64 = 1 << 20;

/// No cell stands in this slot of the table.
const FREE: u64 = u64::MAX;

/// Points sorted into cubic cells. Indices that come back are those of the slice it was built from.
#[derive(Debug, Clone)]
pub struct Grid {
    cell: f64,
    slots: Vec<(u64, u32, u32)>,
    mask: usize,
    order: Vec<u32>,
    points: Vec<Point3<f64>>,
}

impl Grid {
    /// Sorts finite `points` into cells of edge `cell` (same unit as the points, positive). Searches
    /// are cheapest with radii of about one cell.
    pub fn new(points: &[Point3<f64>], cell: f64) -> Self {
        let cell = if cell.is_finite() && cell > 0.0 {
            cell
        } else {
            1.0
        };
        let mut keyed: Vec<(u64, u32)> = points
            .par_iter()
            .enumerate()
            .map(|(i, p)| (key(cell_of(p, cell)), i as u32))
            .collect();
        keyed.par_sort_unstable();
        let mut cells = 0_usize;
        let mut last = FREE;
        for (k, _) in &keyed {
            if *k != last {
                cells += 1;
                last = *k;
            }
        }
        let size = (cells * 2 + 2).next_power_of_two();
        let mask = size - 1;
        let mut slots = vec![(FREE, 0, 0); size];
        let mut start = 0;
        while start < keyed.len() {
            let k = keyed[start].0;
            let mut end = start + 1;
            while end < keyed.len() && keyed[end].0 == k {
                end += 1;
            }
            let mut slot = spread(k) & mask;
            while slots[slot].0 != FREE {
                slot = (slot + 1) & mask;
            }
            slots[slot] = (k, start as u32, end as u32);
            start = end;
        }
        let order: Vec<u32> = keyed.iter().map(|(_, i)| *i).collect();
        let sorted = order.iter().map(|i| points[*i as usize]).collect();
        Self {
            cell,
            slots,
            mask,
            order,
            points: sorted,
        }
    }

    /// Edge of a cell.
    pub fn cell(&self) -> f64 {
        self.cell
    }

    /// Calls `visit(index, squared distance)` for every point within `radius` of `place`, in an
    /// order that depends on the points only.
    pub fn for_each_within(
        &self,
        place: &Point3<f64>,
        radius: f64,
        mut visit: impl FnMut(usize, f64),
    ) {
        let reach = nalgebra::Vector3::repeat(radius);
        let low = cell_of(&(place - reach), self.cell);
        let high = cell_of(&(place + reach), self.cell);
        let limit = radius * radius;
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    for i in self.members([x, y, z]) {
                        let d2 = (self.points[i] - place).norm_squared();
                        if d2 <= limit {
                            visit(self.order[i] as usize, d2);
                        }
                    }
                }
            }
        }
    }

    /// The nearest point within `radius`, with its squared distance; the lowest index among equals.
    pub fn nearest(&self, place: &Point3<f64>, radius: f64) -> Option<(usize, f64)> {
        let mut best: Option<(usize, f64)> = None;
        let mut reach = self.cell.min(radius);
        loop {
            self.for_each_within(place, reach, |i, d2| {
                if best.is_none_or(|(j, b)| d2 < b || (d2 == b && i < j)) {
                    best = Some((i, d2));
                }
            });
            if best.is_some() || reach >= radius {
                return best;
            }
            reach = (2.0 * reach).min(radius);
        }
    }

    fn members(&self, cell: [i64; 3]) -> std::ops::Range<usize> {
        let k = key(cell);
        let mut slot = spread(k) & self.mask;
        loop {
            let (found, start, end) = self.slots[slot];
            if found == k {
                return start as usize..end as usize;
            }
            if found == FREE {
                return 0..0;
            }
            slot = (slot + 1) & self.mask;
        }
    }
}

fn cell_of(p: &Point3<f64>, cell: f64) -> [i64; 3] {
    let at = |v: f64| ((v / cell).floor() as i64).clamp(-HALF, HALF - 1);
    [at(p.x), at(p.y), at(p.z)]
}

fn key(cell: [i64; 3]) -> u64 {
    let part = |v: i64| (v + HALF) as u64;
    part(cell[0]) << 42 | part(cell[1]) << 21 | part(cell[2])
}

fn spread(key: u64) -> usize {
    (key.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 20) as usize
}

#[cfg(test)]
mod tests {
    use super::Grid;
    use nalgebra::Point3;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = Point3<f64>> {
        (-3.0..3.0, -3.0..3.0, -3.0..3.0).prop_map(|(x, y, z)| Point3::new(x, y, z))
    }

    proptest! {
        #[test]
        fn finds_what_a_full_search_finds(
            points in prop::collection::vec(point(), 1..80), place in point(), radius in 0.05..2.0,
        ) {
            let grid = Grid::new(&points, 0.5);
            let mut found = Vec::new();
            grid.for_each_within(&place, radius, |i, _| found.push(i));
            found.sort_unstable();
            let all: Vec<usize> = (0..points.len())
                .filter(|i| (points[*i] - place).norm_squared() <= radius * radius)
                .collect();
            prop_assert_eq!(&found, &all);
            let nearest = all.iter().copied().min_by(|a, b| {
                (points[*a] - place).norm_squared().total_cmp(&(points[*b] - place).norm_squared())
            });
            prop_assert_eq!(grid.nearest(&place, radius).map(|(i, _)| i), nearest);
        }
    }

    #[test]
    fn an_empty_grid_answers() {
        let grid = Grid::new(&[], 0.1);
        assert!(grid.nearest(&Point3::origin(), 1.0).is_none());
    }
}
