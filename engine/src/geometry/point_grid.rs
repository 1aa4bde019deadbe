//! A hash grid over points, for neighbour search. Built once, read by many threads.

use super::voxel::floor;
use nalgebra::Point3;
use rayon::prelude::*;

/// Cells per axis run from `-MAX_CELL` to `MAX_CELL`. Points beyond share the outermost cells, which costs time only:
/// distances are always tested.
const MAX_CELL: i64 = 1 << 20;

/// A free slot of the table.
const FREE: u64 = u64::MAX;

/// Columns with more cells than this are searched by bisection.
const MAX_LINEAR_SEARCH: usize = 12;

/// Points sorted into cubic cells, cells into columns along z. A search visits a few columns and reads the points of each
/// in one run. Indices that come back are those of the slice it was built from.
#[derive(Debug, Clone)]
pub struct PointGrid {
    cell: f64,
    inverse: f64,
    /// Column, its first cell, end of its cells; open addressing.
    slots: Vec<(u64, u32, u32)>,
    mask: usize,
    /// Height of each occupied cell and its first point; one more at the end.
    cells: Vec<(i32, u32)>,
    order: Vec<u32>,
    points: Vec<Point3<f64>>,
}

impl PointGrid {
    /// Sorts finite `points` into cells of edge `cell` (same unit as the points, positive). Searches
    /// are cheapest with radii of about one cell.
    pub fn new(points: &[Point3<f64>], cell: f64) -> Self {
        let cell = if cell.is_finite() && cell > 0.0 {
            cell
        } else {
            1.0
        };
        let inverse = 1.0 / cell;
        let mut keyed: Vec<(u64, u32)> = points
            .iter()
            .enumerate()
            .map(|(i, p)| (key(cell_of(p, inverse)), i as u32))
            .collect();
        keyed.par_sort_unstable();
        let mut cells: Vec<(i32, u32)> = Vec::with_capacity(keyed.len() / 2 + 1);
        let mut columns: Vec<(u64, u32, u32)> = Vec::new();
        let mut last = FREE;
        for (at, (k, _)) in keyed.iter().enumerate() {
            if *k == last {
                continue;
            }
            let column = k >> 21;
            match columns.last_mut() {
                Some(open) if open.0 == column => open.2 += 1,
                _ => {
                    let first = cells.len() as u32;
                    columns.push((column, first, first + 1));
                }
            }
            cells.push(((k & 0x1f_ffff) as i32 - MAX_CELL as i32, at as u32));
            last = *k;
        }
        cells.push((i32::MAX, keyed.len() as u32));
        let size = (columns.len() * 2 + 2).next_power_of_two();
        let mask = size - 1;
        let mut slots = vec![(FREE, 0, 0); size];
        for column in columns {
            let mut slot = hash(column.0) & mask;
            while slots[slot].0 != FREE {
                slot = (slot + 1) & mask;
            }
            slots[slot] = column;
        }
        let order: Vec<u32> = keyed.iter().map(|(_, i)| *i).collect();
        let sorted = order.iter().map(|i| points[*i as usize]).collect();
        Self {
            cell,
            inverse,
            slots,
            mask,
            cells,
            order,
            points: sorted,
        }
    }

    /// Calls `visit(index, squared distance)` for every point within `radius` of `centre`, in an
    /// order that depends on the points only.
    #[inline]
    pub fn for_each_within(
        &self,
        centre: &Point3<f64>,
        radius: f64,
        mut visit: impl FnMut(usize, f64),
    ) {
        self.for_each_within_while(centre, radius, |i, d2| {
            visit(i, d2);
            true
        });
    }

    /// As [`Self::for_each_within`], until `visit` returns false.
    #[inline]
    pub(super) fn for_each_within_while(
        &self,
        centre: &Point3<f64>,
        radius: f64,
        mut visit: impl FnMut(usize, f64) -> bool,
    ) {
        let reach = nalgebra::Vector3::repeat(radius);
        let low = cell_of(&(centre - reach), self.inverse);
        let high = cell_of(&(centre + reach), self.inverse);
        let limit = radius * radius;
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for i in self.members(x, y, low[2], high[2]) {
                    let d2 = (self.points[i] - centre).norm_squared();
                    if d2 <= limit && !visit(self.order[i] as usize, d2) {
                        return;
                    }
                }
            }
        }
    }

    /// The nearest point within `radius` and its squared distance; of equals, the one with the lowest index.
    pub fn nearest(&self, centre: &Point3<f64>, radius: f64) -> Option<(usize, f64)> {
        let mut best: Option<(usize, f64)> = None;
        let mut reach = self.cell.min(radius);
        loop {
            self.for_each_within(centre, reach, |i, d2| {
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

    /// The points of one column between two heights, as a range of `points`.
    #[inline]
    fn members(&self, x: i64, y: i64, low: i64, high: i64) -> std::ops::Range<usize> {
        let column = column_of(x, y);
        let mut slot = hash(column) & self.mask;
        loop {
            let (found, from, to) = self.slots[slot];
            if found == column {
                let column_cells = &self.cells[from as usize..=to as usize];
                let inside = &column_cells[..column_cells.len() - 1];
                let first_at = |z: i64| {
                    if inside.len() <= MAX_LINEAR_SEARCH {
                        inside.iter().take_while(|s| i64::from(s.0) < z).count()
                    } else {
                        inside.partition_point(|s| i64::from(s.0) < z)
                    }
                };
                return column_cells[first_at(low)].1 as usize
                    ..column_cells[first_at(high + 1)].1 as usize;
            }
            if found == FREE {
                return 0..0;
            }
            slot = (slot + 1) & self.mask;
        }
    }
}

#[inline]
fn cell_of(p: &Point3<f64>, inverse: f64) -> [i64; 3] {
    let at = |v: f64| floor(v * inverse).clamp(-MAX_CELL, MAX_CELL - 1);
    [at(p.x), at(p.y), at(p.z)]
}

#[inline]
fn column_of(x: i64, y: i64) -> u64 {
    ((x + MAX_CELL) as u64) << 21 | (y + MAX_CELL) as u64
}

fn key(cell: [i64; 3]) -> u64 {
    column_of(cell[0], cell[1]) << 21 | (cell[2] + MAX_CELL) as u64
}

#[inline]
fn hash(key: u64) -> usize {
    (key.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 20) as usize
}

#[cfg(test)]
mod tests {
    use super::PointGrid;
    use nalgebra::Point3;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = Point3<f64>> {
        (-3.0..3.0, -3.0..3.0, -3.0..3.0).prop_map(|(x, y, z)| Point3::new(x, y, z))
    }

    proptest! {
        #[test]
        fn finds_the_same_as_a_full_search(
            points in prop::collection::vec(point(), 1..80), centre in point(), radius in 0.05..2.0,
        ) {
            let grid = PointGrid::new(&points, 0.5);
            let mut found = Vec::new();
            grid.for_each_within(&centre, radius, |i, _| found.push(i));
            found.sort_unstable();
            let all: Vec<usize> = (0..points.len())
                .filter(|i| (points[*i] - centre).norm_squared() <= radius * radius)
                .collect();
            prop_assert_eq!(&found, &all);
            let nearest = all.iter().copied().min_by(|a, b| {
                (points[*a] - centre).norm_squared().total_cmp(&(points[*b] - centre).norm_squared())
            });
            prop_assert_eq!(grid.nearest(&centre, radius).map(|(i, _)| i), nearest);
        }
    }

    #[test]
    fn an_empty_grid_finds_nothing() {
        let grid = PointGrid::new(&[], 0.1);
        assert!(grid.nearest(&Point3::origin(), 1.0).is_none());
    }
}
