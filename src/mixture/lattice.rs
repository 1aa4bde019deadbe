//! Points made ready for EM: centred, ordered along a space-filling curve, a structure of arrays.

use super::MixtureError;
use super::curve::along_the_curve;
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Points that share one bounding box, and the width of the inner loops.
pub(super) const BLOCK: usize = 64;

/// One block: coordinates relative to the centre, metres; lanes past the last point weigh nothing.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Block {
    pub x: [f64; BLOCK],
    pub y: [f64; BLOCK],
    pub z: [f64; BLOCK],
    pub weight: [f64; BLOCK],
    /// Where each lane's point stands in the caller's list; only the first `len` count.
    pub index: [u32; BLOCK],
    pub len: usize,
    /// Middle and half extents of the bounding box.
    pub middle: [f64; 3],
    pub half: [f64; 3],
}

/// All blocks.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Lattice {
    pub blocks: Vec<Block>,
    /// Mean of the points, subtracted from all coordinates.
    pub centre: Vector3<f64>,
    pub total_weight: f64,
}

impl Lattice {
    /// Checks and arranges the points. Deterministic. `parallel`: in the pool that the caller stands in.
    pub(super) fn new(
        points: &[Point3<f64>],
        weights: Option<&[f64]>,
        parallel: bool,
    ) -> Result<Self, MixtureError> {
        check_points(points)?;
        let total_weight = match weights {
            Some(weights) => check_weights(points, weights)?,
            None => points.len() as f64,
        };
        let first = points.first().ok_or(MixtureError::NoPoints)?;
        let shift: Vector3<f64> =
            points.iter().map(|p| p - first).sum::<Vector3<f64>>() / points.len() as f64;
        let centre = first.coords + shift;
        let order = along_the_curve(points, parallel);
        let block = |members: &[u32]| Block::new(points, weights, members, centre);
        let blocks = if parallel {
            order.par_chunks(BLOCK).map(block).collect()
        } else {
            order.chunks(BLOCK).map(block).collect()
        };
        Ok(Self {
            blocks,
            centre,
            total_weight,
        })
    }
}

impl Block {
    fn new(
        points: &[Point3<f64>],
        weights: Option<&[f64]>,
        members: &[u32],
        centre: Vector3<f64>,
    ) -> Self {
        let mut block = Self {
            x: [0.0; BLOCK],
            y: [0.0; BLOCK],
            z: [0.0; BLOCK],
            weight: [0.0; BLOCK],
            index: [0; BLOCK],
            len: members.len(),
            middle: [0.0; 3],
            half: [0.0; 3],
        };
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for lane in 0..BLOCK {
            let member = members[lane.min(members.len() - 1)];
            let p = points[member as usize].coords - centre;
            (block.x[lane], block.y[lane], block.z[lane]) = (p.x, p.y, p.z);
            block.index[lane] = member;
            if lane < members.len() {
                block.weight[lane] = weights.map_or(1.0, |w| w[member as usize]);
            }
            for axis in 0..3 {
                low[axis] = low[axis].min(p[axis]);
                high[axis] = high[axis].max(p[axis]);
            }
        }
        block.middle = std::array::from_fn(|a| 0.5 * (low[a] + high[a]));
        block.half = std::array::from_fn(|a| 0.5 * (high[a] - low[a]));
        block
    }
}

pub(super) fn check_points(points: &[Point3<f64>]) -> Result<(), MixtureError> {
    match points.iter().position(|p| !p.iter().all(|v| v.is_finite())) {
        Some(index) => Err(MixtureError::PointNotFinite { index }),
        None => Ok(()),
    }
}

/// Checks the weights and gives their sum.
pub(super) fn check_weights(points: &[Point3<f64>], weights: &[f64]) -> Result<f64, MixtureError> {
    if weights.len() != points.len() {
        return Err(MixtureError::LengthsDiffer {
            array: "point weights",
            got: weights.len(),
            like: "points",
            expected: points.len(),
        });
    }
    for (index, &got) in weights.iter().enumerate() {
        if !got.is_finite() || got < 0.0 {
            return Err(MixtureError::BadPointWeight { index, got });
        }
    }
    let got: f64 = weights.iter().sum();
    if !points.is_empty() && (got <= 0.0 || !got.is_finite()) {
        return Err(MixtureError::NoPointWeight { got });
    }
    Ok(got)
}

#[cfg(test)]
mod tests {
    use super::{BLOCK, Lattice};
    use nalgebra::Point3;

    #[test]
    fn every_point_stands_in_one_block() {
        let points: Vec<Point3<f64>> = (0..150)
            .map(|i| {
                Point3::new(
                    1e6 + f64::from(i * 37 % 150),
                    f64::from(i),
                    -f64::from(i % 7),
                )
            })
            .collect();
        let lattice = Lattice::new(&points, None, false).expect("finite");
        let mut seen: Vec<u32> = lattice
            .blocks
            .iter()
            .flat_map(|b| b.index[..b.len].iter().copied())
            .collect();
        seen.sort_unstable();
        assert_eq!(seen, (0..150).collect::<Vec<u32>>());
        let mass: f64 = lattice.blocks.iter().flat_map(|b| b.weight).sum();
        assert_eq!(
            (mass, lattice.blocks.len()),
            (150.0, 150usize.div_ceil(BLOCK))
        );
    }
}
