//! Points made ready for EM: centred, ordered along a space-filling curve, a structure of arrays.

use super::MixtureError;
use super::curve::along_the_curve;
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Points that share one bounding box, and the width of the inner loops.
pub(super) const BLOCK: usize = 64;

/// One block: coordinates relative to the centre, metres; lanes past the last point repeat it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Block {
    pub x: [f64; BLOCK],
    pub y: [f64; BLOCK],
    pub z: [f64; BLOCK],
    /// Middle and half extents of the bounding box.
    pub middle: [f64; 3],
    pub half: [f64; 3],
}

/// What the lanes of the blocks weigh; lanes past the last point weigh nothing.
#[derive(Debug, Clone, PartialEq)]
enum Weights {
    /// All points alike: a full block's, and the last block's.
    Even(Box<[[f64; BLOCK]; 2]>),
    /// Every block's own.
    Own(Vec<[f64; BLOCK]>),
}

/// All blocks.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Lattice {
    pub blocks: Vec<Block>,
    /// Where every point stands in the caller's list, block by block.
    pub order: Vec<u32>,
    weights: Weights,
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
        let block = |members: &[u32]| Block::new(points, members, centre);
        let blocks = if parallel {
            order.par_chunks(BLOCK).map(block).collect()
        } else {
            order.chunks(BLOCK).map(block).collect()
        };
        let lanes = |members: &[u32], weight: &dyn Fn(u32) -> f64| {
            let mut lanes = [0.0; BLOCK];
            for (lane, &member) in lanes.iter_mut().zip(members) {
                *lane = weight(member);
            }
            lanes
        };
        let last = order.len() / BLOCK * BLOCK;
        let weights = match weights {
            None => {
                let last = lanes(&order[last..], &|_| 1.0);
                Weights::Even(Box::new([[1.0; BLOCK], last]))
            }
            Some(weights) => {
                let own = |members| lanes(members, &|member| weights[member as usize]);
                Weights::Own(order.chunks(BLOCK).map(own).collect())
            }
        };
        Ok(Self {
            blocks,
            order,
            weights,
            centre,
            total_weight,
        })
    }

    /// What the lanes of one block weigh.
    #[inline(always)]
    pub(super) fn weights(&self, block: usize) -> &[f64; BLOCK] {
        match &self.weights {
            Weights::Even(pair) => {
                let [full, last] = &**pair;
                let whole = (block + 1) * BLOCK <= self.order.len();
                if whole { full } else { last }
            }
            Weights::Own(own) => &own[block],
        }
    }
}

impl Block {
    fn new(points: &[Point3<f64>], members: &[u32], centre: Vector3<f64>) -> Self {
        let mut block = Self {
            x: [0.0; BLOCK],
            y: [0.0; BLOCK],
            z: [0.0; BLOCK],
            middle: [0.0; 3],
            half: [0.0; 3],
        };
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for lane in 0..BLOCK {
            let member = members[lane.min(members.len() - 1)];
            let p = points[member as usize].coords - centre;
            (block.x[lane], block.y[lane], block.z[lane]) = (p.x, p.y, p.z);
            for axis in 0..3 {
                low[axis] = if p[axis] < low[axis] {
                    p[axis]
                } else {
                    low[axis]
                };
                high[axis] = if p[axis] > high[axis] {
                    p[axis]
                } else {
                    high[axis]
                };
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
        let mut seen = lattice.order.clone();
        seen.sort_unstable();
        assert_eq!(seen, (0..150).collect::<Vec<u32>>());
        for (at, &point) in lattice.order.iter().enumerate() {
            let block = &lattice.blocks[at / BLOCK];
            let x = points[point as usize].x - lattice.centre.x;
            assert_eq!(block.x[at % BLOCK], x);
        }
        let weight: Vec<f64> = (0..150).map(f64::from).collect();
        let heavy = Lattice::new(&points, Some(&weight), true).expect("finite");
        for (at, &point) in heavy.order.iter().enumerate() {
            assert_eq!(heavy.weights(at / BLOCK)[at % BLOCK], f64::from(point));
        }
        let mass: f64 = (0..3).flat_map(|b| *lattice.weights(b)).sum();
        assert_eq!(
            (mass, lattice.blocks.len()),
            (150.0, 150usize.div_ceil(BLOCK))
        );
    }
}
