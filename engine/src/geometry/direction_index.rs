//! Neighbour search among unit vectors. The unit sphere is cut into bands of equal height, each band into equal steps of
//! the diamond angle, which replaces the azimuth and needs no trigonometry.

use super::voxel::floor;
use nalgebra::Vector3;

/// Limit of the number of cells, per direction.
const MAX_CELLS_PER_DIRECTION: f64 = 4.0;

/// The limit is never below this.
const MIN_CELL_LIMIT: f64 = 4096.0;

/// Unit vectors sorted into cells of the sphere. Indices that come back are those of the slice it was built from.
#[derive(Debug, Clone)]
pub(super) struct DirectionIndex {
    low_z: f64,
    /// One over the width of a cell.
    inverse: f64,
    bands: usize,
    steps: usize,
    /// First direction of each cell, band by band, one more at the end.
    starts: Vec<u32>,
    order: Vec<u32>,
    sorted: Vec<Vector3<f64>>,
}

impl DirectionIndex {
    /// Sorts `units` into cells of about `width_rad`. Zero vectors are never found.
    pub(super) fn new(units: &[Vector3<f64>], width_rad: f64) -> Self {
        let is_unit = |u: &Vector3<f64>| u.norm_squared() > 0.25;
        let (low_z, high_z) = units
            .iter()
            .filter(|u| is_unit(u))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), u| {
                (low.min(u.z), high.max(u.z))
            });
        let (low_z, high_z) = if low_z <= high_z {
            (low_z, high_z)
        } else {
            (0.0, 0.0)
        };
        let max_cells = (MAX_CELLS_PER_DIRECTION * units.len() as f64).max(MIN_CELL_LIMIT);
        let span = high_z - low_z;
        // Square cells of side c number (span / c + 1)(4 / c).
        let min_width = ((4.0 * span / max_cells).sqrt()).max(4.0 / max_cells);
        let width = width_rad.max(min_width).min(1.0);
        let inverse = 1.0 / width;
        let bands = floor(span * inverse) as usize + 1;
        let steps = floor(4.0 * inverse) as usize + 1;
        let mut index = Self {
            low_z,
            inverse,
            bands,
            steps,
            starts: vec![0; bands * steps + 1],
            order: Vec::new(),
            sorted: Vec::new(),
        };
        let cells: Vec<Option<u32>> = units
            .iter()
            .map(|u| is_unit(u).then(|| index.cell(u) as u32))
            .collect();
        for cell in cells.iter().flatten() {
            index.starts[*cell as usize + 1] += 1;
        }
        for i in 1..index.starts.len() {
            index.starts[i] += index.starts[i - 1];
        }
        let count = index.starts.last().copied().unwrap_or(0) as usize;
        index.order = vec![0; count];
        let mut next = index.starts.clone();
        for (i, cell) in cells.iter().enumerate() {
            if let Some(cell) = cell {
                let slot = &mut next[*cell as usize];
                index.order[*slot as usize] = i as u32;
                *slot += 1;
            }
        }
        index.sorted = index.order.iter().map(|i| units[*i as usize]).collect();
        index
    }

    /// Calls `visit(index, offset from u)` for every direction within the chord `radius` (radians, for small
    /// ones) of the unit vector `u`, in an order that depends on the directions only.
    #[inline]
    pub(super) fn for_each_within(
        &self,
        u: &Vector3<f64>,
        radius: f64,
        mut visit: impl FnMut(usize, &Vector3<f64>),
    ) {
        let limit = radius * radius;
        let low = floor((u.z - radius - self.low_z) * self.inverse).max(0);
        let high = floor((u.z + radius - self.low_z) * self.inverse).min(self.bands as i64 - 1);
        // The azimuth changes by asin(radius / level) at most, the diamond angle by no more than the azimuth.
        let level = (u.x * u.x + u.y * u.y).sqrt();
        let half_width = if level > 2.0 * radius {
            1.05 * radius / level
        } else {
            4.0
        };
        let middle = diamond_angle(u);
        let steps = self.steps as i64;
        let (first, last) = if 2.0 * half_width + 2.0 / self.inverse >= 4.0 {
            (0, steps - 1)
        } else {
            (
                floor((middle - half_width) * self.inverse),
                floor((middle + half_width) * self.inverse),
            )
        };
        for band in low..=high {
            // The last step is cut short where the turn ends; ranges that cross it are read in two parts.
            let row = band * steps;
            let mut read = |from: i64, to: i64| {
                let range = self.starts[(row + from) as usize] as usize
                    ..self.starts[(row + to + 1) as usize] as usize;
                for (d, i) in self.sorted[range.clone()].iter().zip(&self.order[range]) {
                    let off = d - u;
                    if off.norm_squared() <= limit {
                        visit(*i as usize, &off);
                    }
                }
            };
            if first < 0 {
                let wrapped = floor((middle - half_width + 4.0) * self.inverse).clamp(0, steps - 1);
                read(0, last.min(steps - 1));
                if wrapped > last {
                    read(wrapped, steps - 1);
                }
            } else if last >= steps || (middle + half_width) >= 4.0 {
                let wrapped =
                    floor((middle + half_width - 4.0) * self.inverse).clamp(-1, steps - 1);
                read(first, steps - 1);
                if wrapped >= 0 && wrapped < first {
                    read(0, wrapped);
                }
            } else {
                read(first, last);
            }
        }
    }

    #[inline]
    fn cell(&self, u: &Vector3<f64>) -> usize {
        let band = floor((u.z - self.low_z) * self.inverse).clamp(0, self.bands as i64 - 1);
        let step = floor(diamond_angle(u) * self.inverse).clamp(0, self.steps as i64 - 1);
        band as usize * self.steps + step as usize
    }
}

/// The diamond angle: rises with the azimuth from 0 to 4 over a full turn, by half to one per radian.
#[inline]
fn diamond_angle(u: &Vector3<f64>) -> f64 {
    let sum = u.x.abs() + u.y.abs();
    if sum <= 0.0 {
        return 0.0;
    }
    let t = u.y / sum;
    let angle = if u.x < 0.0 {
        2.0 - t
    } else if u.y < 0.0 {
        4.0 + t
    } else {
        t
    };
    if angle >= 4.0 { 0.0 } else { angle }
}

#[cfg(test)]
mod tests {
    use super::DirectionIndex;
    use nalgebra::Vector3;
    use proptest::prelude::*;

    fn unit() -> impl Strategy<Value = Vector3<f64>> {
        (-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64, 0..6)
            .prop_filter("a direction", |(x, y, z, _)| x * x + y * y + z * z > 0.01)
            .prop_map(|(x, y, z, kind)| {
                // Poles, axes and the seam of the turn are frequent.
                let v = match kind {
                    0 => Vector3::new(0.01 * x, 0.01 * y, z.signum()),
                    1 => Vector3::new(1.0, 0.01 * y, 0.1 * z),
                    2 => Vector3::new(0.01 * x, y.signum(), 0.1 * z),
                    3 => Vector3::new(-1.0, 0.01 * y, 0.0),
                    _ => Vector3::new(x, y, z),
                };
                v.normalize()
            })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]
        #[test]
        fn finds_the_same_as_a_full_search(
            units in prop::collection::vec(unit(), 1..120), at in unit(), radius in 0.001..0.9f64, width in 0.005..0.5f64,
        ) {
            let index = DirectionIndex::new(&units, width);
            let mut found = Vec::new();
            index.for_each_within(&at, radius, |i, off| {
                assert!((units[i] - at - off).norm() < 1e-12);
                found.push(i);
            });
            found.sort_unstable();
            let all: Vec<usize> = (0..units.len())
                .filter(|i| (units[*i] - at).norm_squared() <= radius * radius)
                .collect();
            prop_assert_eq!(found, all);
        }
    }

    #[test]
    fn zero_vectors_are_never_found() {
        let index = DirectionIndex::new(&[Vector3::zeros(), Vector3::x()], 0.1);
        let mut found = Vec::new();
        index.for_each_within(&Vector3::x(), 2.0, |i, _| found.push(i));
        assert_eq!(found, [1]);
        DirectionIndex::new(&[], 0.1).for_each_within(&Vector3::x(), 2.0, |_, _| panic!("empty"));
    }
}
