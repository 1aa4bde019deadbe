//! Voxel grid downsampling: one point per cube of space, so that dense regions do not outweigh sparse ones.

use nalgebra::{Point3, Vector3};

/// A free slot of the table.
const FREE: u32 = u32::MAX;

/// A cloud reduced to the means of its voxels.
#[derive(Debug, Clone, Default)]
pub struct DownsampledCloud {
    /// Mean of the points of each occupied voxel, metres, ordered by the first point of each.
    pub points: Vec<Point3<f64>>,
    /// Number of points in each voxel.
    pub(crate) counts: Vec<u32>,
    /// For every input point, the index of its voxel in `points`.
    pub(crate) voxel_of_point: Vec<u32>,
    /// Finds the voxel that holds a point.
    pub(crate) voxels: VoxelTable,
}

/// Finds the occupied voxel that holds a point. A hash table with open addressing.
#[derive(Debug, Clone, Default)]
pub(crate) struct VoxelTable {
    /// One over the side of a voxel.
    inverse: f64,
    slots: Vec<([i32; 3], u32)>,
    mask: usize,
    used: usize,
}

impl VoxelTable {
    /// An empty table for about `expected` voxels of side `voxel_m` (above zero).
    pub(super) fn new(voxel_m: f64, expected: usize) -> Self {
        let size = (2 * expected + 16).next_power_of_two();
        Self {
            inverse: 1.0 / voxel_m,
            slots: vec![([0; 3], FREE); size],
            mask: size - 1,
            used: 0,
        }
    }

    /// Index of the occupied voxel that holds `p`.
    #[inline]
    pub(crate) fn find(&self, p: &Point3<f64>) -> Option<usize> {
        let cell = self.cell_of(p);
        let mut slot = hash(cell) & self.mask;
        loop {
            let (held, index) = *self.slots.get(slot)?;
            if index == FREE {
                return None;
            }
            if held == cell {
                return Some(index as usize);
            }
            slot = (slot + 1) & self.mask;
        }
    }

    /// Points further than 2^31 voxels from the origin share the outermost ones.
    #[inline]
    fn cell_of(&self, p: &Point3<f64>) -> [i32; 3] {
        let at = |v: f64| {
            let far = i64::from(i32::MAX);
            floor(v * self.inverse).clamp(-far, far) as i32
        };
        [at(p.x), at(p.y), at(p.z)]
    }

    /// The voxel that holds `p` and the 26 around it, each with its centre.
    pub(super) fn neighbourhood(&self, p: &Point3<f64>) -> [([i32; 3], Point3<f64>); 27] {
        let [x, y, z] = self.cell_of(p);
        std::array::from_fn(|n| {
            let n = n as i32;
            let cell = [
                x.saturating_add(n % 3 - 1),
                y.saturating_add(n / 3 % 3 - 1),
                z.saturating_add(n / 9 - 1),
            ];
            (
                cell,
                Point3::from(cell.map(|c| (f64::from(c) + 0.5) / self.inverse)),
            )
        })
    }

    /// Index of the voxel `cell`, which becomes `new_index` if it was free.
    pub(super) fn insert(&mut self, cell: [i32; 3], new_index: u32) -> u32 {
        if 2 * self.used >= self.slots.len() {
            self.grow();
        }
        let mut slot = hash(cell) & self.mask;
        while self.slots[slot].1 != FREE {
            if self.slots[slot].0 == cell {
                return self.slots[slot].1;
            }
            slot = (slot + 1) & self.mask;
        }
        self.slots[slot] = (cell, new_index);
        self.used += 1;
        new_index
    }

    fn grow(&mut self) {
        let size = 2 * self.slots.len();
        let old = std::mem::replace(&mut self.slots, vec![([0; 3], FREE); size]);
        self.mask = size - 1;
        for entry in old.into_iter().filter(|e| e.1 != FREE) {
            let mut slot = hash(entry.0) & self.mask;
            while self.slots[slot].1 != FREE {
                slot = (slot + 1) & self.mask;
            }
            self.slots[slot] = entry;
        }
    }
}

/// The largest integer not above `v`; fast on processors without an instruction for it too.
#[inline]
pub(super) fn floor(v: f64) -> i64 {
    let cut = v as i64;
    cut - i64::from(v < cut as f64)
}

#[inline]
fn hash(cell: [i32; 3]) -> usize {
    let [x, y, z] = cell.map(|v| u64::from(v as u32));
    let mixed = (x.wrapping_mul(0x9e37_79b9_7f4a_7c15)
        ^ y.wrapping_mul(0xc2b2_ae3d_27d4_eb4f)
        ^ z.wrapping_mul(0x1656_67b1_9e37_79f9))
    .wrapping_mul(0x9e37_79b9_7f4a_7c15);
    (mixed >> 32) as usize
}

/// Reduces `points` (finite, metres) to the means of voxels of side `voxel_m`, on a grid through the origin of the frame.
/// Deterministic. A side that is not above zero keeps every point.
pub fn voxel_downsample(points: &[Point3<f64>], voxel_m: f64) -> DownsampledCloud {
    if voxel_m.is_nan() || voxel_m <= 0.0 {
        return DownsampledCloud {
            points: points.to_vec(),
            counts: vec![1; points.len()],
            voxel_of_point: (0..points.len() as u32).collect(),
            voxels: VoxelTable::default(),
        };
    }
    let mut voxels = VoxelTable::new(voxel_m, points.len() / 3);
    let mut cloud = DownsampledCloud {
        voxel_of_point: Vec::with_capacity(points.len()),
        ..DownsampledCloud::default()
    };
    let mut sums: Vec<Vector3<f64>> = Vec::new();
    // Points that follow one another along a scan often share a voxel.
    let (mut last_cell, mut last) = ([0; 3], FREE);
    for p in points {
        let cell = voxels.cell_of(p);
        if cell != last_cell || last == FREE {
            last = voxels.insert(cell, sums.len() as u32);
            last_cell = cell;
        }
        let at = last as usize;
        if at == sums.len() {
            cloud.points.push(*p);
            cloud.counts.push(0);
            sums.push(Vector3::zeros());
        }
        // Relative to the first point: the sums stay exact far from the origin.
        sums[at] += p - cloud.points[at];
        cloud.counts[at] += 1;
        cloud.voxel_of_point.push(last);
    }
    for ((point, sum), &count) in cloud.points.iter_mut().zip(&sums).zip(&cloud.counts) {
        *point += sum / f64::from(count);
    }
    cloud.voxels = voxels;
    cloud
}

#[cfg(test)]
mod tests {
    use super::voxel_downsample;
    use nalgebra::{Point3, Vector3};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn mass_and_mean_are_kept(raw in proptest::collection::vec(proptest::array::uniform3(-2.0..2.0f64), 1..300), far in any::<bool>()) {
            let offset = if far { Vector3::new(1e6, -1e6, 1e6) } else { Vector3::zeros() };
            let points: Vec<_> = raw.iter().map(|p| Point3::from(*p) + offset).collect();
            let cloud = voxel_downsample(&points, 0.5);
            prop_assert_eq!(cloud.counts.iter().sum::<u32>() as usize, points.len());
            let mean: Vector3<f64> = points.iter().map(|p| p - points[0]).sum();
            let cloud_mean: Vector3<f64> =
                cloud.points.iter().zip(&cloud.counts).map(|(p, &n)| (p - points[0]) * f64::from(n)).sum();
            prop_assert!((mean - cloud_mean).norm() < 1e-6);
            for (p, &cell) in points.iter().zip(&cloud.voxel_of_point) {
                prop_assert!((p - cloud.points[cell as usize]).amax() <= 0.5 + 1e-9);
                prop_assert_eq!(cloud.voxels.find(p), Some(cell as usize));
            }
        }
    }

    #[test]
    fn voxels_are_ordered_by_their_first_points() {
        let points = [2.1, -0.1, 2.3, -0.3, 0.1].map(|x| Point3::new(x, 0.0, 0.0));
        let cloud = voxel_downsample(&points, 1.0);
        assert_eq!(cloud.voxel_of_point, [0, 1, 0, 1, 2]);
        assert_eq!(cloud.counts, [2, 2, 1]);
        assert!((cloud.points[1].x + 0.2).abs() < 1e-15);
        assert_eq!(voxel_downsample(&points, 0.0).points, points);
        assert!(voxel_downsample(&[], 1.0).points.is_empty());
        assert_eq!(cloud.voxels.find(&Point3::new(2.9, 0.5, 0.5)), Some(0));
        assert_eq!(cloud.voxels.find(&Point3::new(3.1, 0.5, 0.5)), None);
    }
}
