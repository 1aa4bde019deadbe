//! Morton order of points: neighbours in the list are neighbours in space.

use nalgebra::Point3;
use rayon::prelude::*;

/// log2 of the number of cells along the longest side of the bounding box.
const CELL_BITS: u32 = 10;

/// Bits per pass of the radix sort.
const DIGIT_BITS: u32 = 10;

/// Bit of a key at which the cell begins; below it is the index of the point.
const CELL_SHIFT: u32 = u32::BITS;

/// Point indices in Morton order; points of one cell keep their order. Coordinates must be finite.
/// `parallel` uses the caller's rayon pool.
pub(super) fn morton_order(points: &[Point3<f64>], parallel: bool) -> Vec<u32> {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in points {
        for axis in 0..3 {
            let v = p[axis];
            low[axis] = if v < low[axis] { v } else { low[axis] };
            high[axis] = if v > high[axis] { v } else { high[axis] };
        }
    }
    let widest = (0..3).map(|a| high[a] - low[a]).fold(0.0, f64::max);
    let cells = f64::from((1u32 << CELL_BITS) - 1);
    let scale = if widest > 0.0 && widest.is_finite() {
        cells / widest
    } else {
        0.0
    };
    let cell = |v: f64, axis: usize| spread(((v - low[axis]) * scale) as u32);
    let key = |(i, p): (usize, &Point3<f64>)| {
        let cell = cell(p.x, 0) | cell(p.y, 1) << 1 | cell(p.z, 2) << 2;
        u64::from(cell) << CELL_SHIFT | i as u64
    };
    let keys: Vec<u64> = if parallel {
        points.par_iter().enumerate().map(key).collect()
    } else {
        points.iter().enumerate().map(key).collect()
    };
    radix_sorted(keys)
        .into_iter()
        .map(|key| key as u32)
        .collect()
}

/// Stable radix sort by the cells of the keys, from the least significant digit.
fn radix_sorted(mut from: Vec<u64>) -> Vec<u64> {
    let mut to = vec![0; from.len()];
    let mut counts = vec![0u32; 1 << DIGIT_BITS];
    for shift in (0..3 * CELL_BITS).step_by(DIGIT_BITS as usize) {
        let digit = |key: u64| (key >> (CELL_SHIFT + shift)) as usize & ((1 << DIGIT_BITS) - 1);
        counts.fill(0);
        for &key in &from {
            counts[digit(key)] += 1;
        }
        let mut before = 0;
        for count in &mut counts {
            before += std::mem::replace(count, before);
        }
        for &key in &from {
            let place = &mut counts[digit(key)];
            to[*place as usize] = key;
            *place += 1;
        }
        std::mem::swap(&mut from, &mut to);
    }
    from
}

/// Two zero bits between each of the lowest ten bits.
fn spread(v: u32) -> u32 {
    let mut v = v & 0x3ff;
    v = (v | v << 16) & 0x0300_00ff;
    v = (v | v << 8) & 0x0300_f00f;
    v = (v | v << 4) & 0x030c_30c3;
    (v | v << 2) & 0x0924_9249
}

#[cfg(test)]
mod tests {
    use super::{morton_order, radix_sorted, spread};
    use nalgebra::Point3;

    #[test]
    fn digits_are_interleaved_and_sorting_is_stable() {
        assert_eq!(spread(0b111), 0b1_001_001);
        assert_eq!(spread(0x3ff), 0x0924_9249);
        let keys: Vec<u64> = (0..5000u64)
            .map(|i| (i * 7919 % 611 * 104_729) << 32 | i)
            .collect();
        let mut expected = keys.clone();
        expected.sort_unstable();
        assert_eq!(radix_sorted(keys), expected);
    }

    #[test]
    fn corners_of_a_cube_are_in_morton_order() {
        let corner =
            |i: u32| Point3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2));
        let points: Vec<_> = (0..8).rev().map(corner).collect();
        for parallel in [false, true] {
            assert_eq!(morton_order(&points, parallel), [7, 6, 5, 4, 3, 2, 1, 0]);
            assert_eq!(morton_order(&[corner(3); 4], parallel), [0, 1, 2, 3]);
        }
    }
}
