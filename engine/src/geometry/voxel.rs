//! Thinning: one point per cube of space, so that crowded places do not outvote sparse ones.

use nalgebra::{Point3, Vector3};

/// Marks a free slot of the table.
const FREE: u32 = u32::MAX;

/// A cloud thinned to the means of its voxels.
#[derive(Debug, Clone, Default)]
pub struct Thinned {
    /// Mean of the points of each occupied voxel, metres, in the order in which voxels were first met.
    pub points: Vec<Point3<f64>>,
    /// How many points each mean stands for.
    pub counts: Vec<u32>,
    /// For every input point, the index of its voxel in `points`.
    pub member_of: Vec<u32>,
    /// Finds the voxel of a place.
    pub voxels: Voxels,
}

/// Which voxel holds a place? A hash table with open addressing.
#[derive(Debug, Clone, Default)]
pub struct Voxels {
    inverse: f64,
    slots: Vec<([i32; 3], u32)>,
    mask: usize,
    used: usize,
}

impl Voxels {
    /// A table for about `expected` voxels of side `voxel_m` (above zero), none occupied yet.
    pub(super) fn new(voxel_m: f64, expected: usize) -> Self {
        let size = (2 * expected + 16).next_power_of_two();
        Self {
            inverse: 1.0 / voxel_m,
            slots: vec![([0; 3], FREE); size],
            mask: size - 1,
            used: 0,
        }
    }

    /// Index of the occupied voxel that holds `place`.
    #[inline]
    pub fn find(&self, place: &Point3<f64>) -> Option<usize> {
        let cell = self.cell_of(place);
        let mut slot = spread(cell) & self.mask;
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

    /// Places further than 2^31 voxels from the origin share the outermost ones.
    #[inline]
    fn cell_of(&self, p: &Point3<f64>) -> [i32; 3] {
        let at = |v: f64| {
            let far = i64::from(i32::MAX);
            whole(v * self.inverse).clamp(-far, far) as i32
        };
        [at(p.x), at(p.y), at(p.z)]
    }

    /// The voxel that holds `place` and the 26 around it, each with its middle.
    pub(super) fn around(&self, place: &Point3<f64>) -> [([i32; 3], Point3<f64>); 27] {
        let [x, y, z] = self.cell_of(place);
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

    /// Index of the voxel `cell`, which is `fresh` if nobody stood there.
    pub(super) fn enter(&mut self, cell: [i32; 3], fresh: u32) -> u32 {
        if 2 * self.used >= self.slots.len() {
            self.grow();
        }
        let mut slot = spread(cell) & self.mask;
        while self.slots[slot].1 != FREE {
            if self.slots[slot].0 == cell {
                return self.slots[slot].1;
            }
            slot = (slot + 1) & self.mask;
        }
        self.slots[slot] = (cell, fresh);
        self.used += 1;
        fresh
    }

    fn grow(&mut self) {
        let size = 2 * self.slots.len();
        let old = std::mem::replace(&mut self.slots, vec![([0; 3], FREE); size]);
        self.mask = size - 1;
        for entry in old.into_iter().filter(|e| e.1 != FREE) {
            let mut slot = spread(entry.0) & self.mask;
            while self.slots[slot].1 != FREE {
                slot = (slot + 1) & self.mask;
            }
            self.slots[slot] = entry;
        }
    }
}

/// The largest whole number not above `v`; as fast on processors without an instruction for it.
#[inline]
pub(super) fn whole(v: f64) -> i64 {
    let cut = v as i64;
    cut - i64::from(v < cut as f64)
}

#[inline]
fn spread(cell: [i32; 3]) -> usize {
    let [x, y, z] = cell.map(|v| u64::from(v as u32));
    let mixed = (x.wrapping_mul(0x9e37_79b9_7f4a_7c15)
        ^ y.wrapping_mul(0xc2b2_ae3d_27d4_eb4f)
        ^ z.wrapping_mul(0x1656_67b1_9e37_79f9))
    .wrapping_mul(0x9e37_79b9_7f4a_7c15);
    (mixed >> 32) as usize
}

/// Thins `points` (finite, metres) to voxels of side `voxel_m`, on a grid through the origin of the
/// frame. Deterministic. A side that is not above zero thins nothing.
pub fn thin(points: &[Point3<f64>], voxel_m: f64) -> Thinned {
    if voxel_m.is_nan() || voxel_m <= 0.0 {
        return Thinned {
            points: points.to_vec(),
            counts: vec![1; points.len()],
            member_of: (0..points.len() as u32).collect(),
            voxels: Voxels::default(),
        };
    }
    let mut voxels = Voxels::new(voxel_m, points.len() / 3);
    let mut thinned = Thinned {
        member_of: Vec::with_capacity(points.len()),
        ..Thinned::default()
    };
    let mut shifts: Vec<Vector3<f64>> = Vec::new();
    // Points that follow one another along a scan often share a voxel.
    let (mut last_cell, mut last) = ([0; 3], FREE);
    for p in points {
        let cell = voxels.cell_of(p);
        if cell != last_cell || last == FREE {
            last = voxels.enter(cell, shifts.len() as u32);
            last_cell = cell;
        }
        let at = last as usize;
        if at == shifts.len() {
            thinned.points.push(*p);
            thinned.counts.push(0);
            shifts.push(Vector3::zeros());
        }
        // Relative to the first point: sums of small numbers even far from the origin.
        shifts[at] += p - thinned.points[at];
        thinned.counts[at] += 1;
        thinned.member_of.push(last);
    }
    for ((point, shift), &count) in thinned.points.iter_mut().zip(&shifts).zip(&thinned.counts) {
        *point += shift / f64::from(count);
    }
    thinned.voxels = voxels;
    thinned
}

#[cfg(test)]
mod tests {
    use super::thin;
    use nalgebra::{Point3, Vector3};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn mass_and_mean_are_kept(raw in proptest::collection::vec(proptest::array::uniform3(-2.0..2.0f64), 1..300), far in any::<bool>()) {
            let shift = if far { Vector3::new(1e6, -1e6, 1e6) } else { Vector3::zeros() };
            let points: Vec<_> = raw.iter().map(|p| Point3::from(*p) + shift).collect();
            let thinned = thin(&points, 0.5);
            prop_assert_eq!(thinned.counts.iter().sum::<u32>() as usize, points.len());
            let mean: Vector3<f64> = points.iter().map(|p| p - points[0]).sum();
            let thin_mean: Vector3<f64> =
                thinned.points.iter().zip(&thinned.counts).map(|(p, &n)| (p - points[0]) * f64::from(n)).sum();
            prop_assert!((mean - thin_mean).norm() < 1e-6);
            for (p, &cell) in points.iter().zip(&thinned.member_of) {
                prop_assert!((p - thinned.points[cell as usize]).amax() <= 0.5 + 1e-9);
                prop_assert_eq!(thinned.voxels.find(p), Some(cell as usize));
            }
        }
    }

    #[test]
    fn cells_come_in_the_order_of_their_first_points() {
        let points = [2.1, -0.1, 2.3, -0.3, 0.1].map(|x| Point3::new(x, 0.0, 0.0));
        let thinned = thin(&points, 1.0);
        assert_eq!(thinned.member_of, [0, 1, 0, 1, 2]);
        assert_eq!(thinned.counts, [2, 2, 1]);
        assert!((thinned.points[1].x + 0.2).abs() < 1e-15);
        assert_eq!(thin(&points, 0.0).points, points);
        assert!(thin(&[], 1.0).points.is_empty());
        assert_eq!(thinned.voxels.find(&Point3::new(2.9, 0.5, 0.5)), Some(0));
        assert_eq!(thinned.voxels.find(&Point3::new(3.1, 0.5, 0.5)), None);
    }
}
