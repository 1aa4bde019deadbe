//! Points arranged for EM: centred, in Morton order, in blocks of coordinate arrays.

use super::MixtureError;
use super::morton::morton_order;
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Points per block.
pub(super) const BLOCK_SIZE: usize = 64;

/// One block: coordinates relative to the centre, metres. Lanes after the last point repeat it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Block {
    pub x: [f64; BLOCK_SIZE],
    pub y: [f64; BLOCK_SIZE],
    pub z: [f64; BLOCK_SIZE],
    /// Centre of the bounding box.
    pub middle: [f64; 3],
    /// Half extents of the bounding box.
    pub half: [f64; 3],
}

/// Weights of the lanes; zero after the last point.
#[derive(Debug, Clone, PartialEq)]
enum LaneWeights {
    /// All points weigh 1: those of a full block, and of the last one.
    Uniform(Box<[[f64; BLOCK_SIZE]; 2]>),
    /// Per block.
    PerBlock(Vec<[f64; BLOCK_SIZE]>),
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct PointBlocks {
    pub blocks: Vec<Block>,
    /// Index of every point in the caller's list, block by block.
    pub order: Vec<u32>,
    weights: LaneWeights,
    /// Mean of the points, subtracted from all coordinates.
    pub centre: Vector3<f64>,
    pub total_weight: f64,
}

impl PointBlocks {
    /// Checks and arranges the points. Deterministic. `parallel` uses the caller's rayon pool.
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
        let order = morton_order(points, parallel);
        let block = |members: &[u32]| Block::new(points, members, centre);
        let blocks = if parallel {
            order.par_chunks(BLOCK_SIZE).map(block).collect()
        } else {
            order.chunks(BLOCK_SIZE).map(block).collect()
        };
        let lanes = |members: &[u32], weight: &dyn Fn(u32) -> f64| {
            let mut lanes = [0.0; BLOCK_SIZE];
            for (lane, &member) in lanes.iter_mut().zip(members) {
                *lane = weight(member);
            }
            lanes
        };
        let last = order.len() / BLOCK_SIZE * BLOCK_SIZE;
        let weights = match weights {
            None => {
                let last = lanes(&order[last..], &|_| 1.0);
                LaneWeights::Uniform(Box::new([[1.0; BLOCK_SIZE], last]))
            }
            Some(weights) => {
                let own = |members| lanes(members, &|member| weights[member as usize]);
                LaneWeights::PerBlock(order.chunks(BLOCK_SIZE).map(own).collect())
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

    /// Weights of the lanes of one block.
    #[inline(always)]
    pub(super) fn weights(&self, block: usize) -> &[f64; BLOCK_SIZE] {
        match &self.weights {
            LaneWeights::Uniform(pair) => {
                let [full, last] = &**pair;
                let whole = (block + 1) * BLOCK_SIZE <= self.order.len();
                if whole { full } else { last }
            }
            LaneWeights::PerBlock(own) => &own[block],
        }
    }
}

impl Block {
    fn new(points: &[Point3<f64>], members: &[u32], centre: Vector3<f64>) -> Self {
        let mut block = Self {
            x: [0.0; BLOCK_SIZE],
            y: [0.0; BLOCK_SIZE],
            z: [0.0; BLOCK_SIZE],
            middle: [0.0; 3],
            half: [0.0; 3],
        };
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for lane in 0..BLOCK_SIZE {
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

/// Checks the weights and returns their sum.
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
    use super::{BLOCK_SIZE, PointBlocks};
    use nalgebra::Point3;

    #[test]
    fn every_point_is_in_one_block() {
        let points: Vec<Point3<f64>> = (0..150)
            .map(|i| {
                Point3::new(
                    1e6 + f64::from(i * 37 % 150),
                    f64::from(i),
                    -f64::from(i % 7),
                )
            })
            .collect();
        let arranged = PointBlocks::new(&points, None, false).expect("finite");
        let mut seen = arranged.order.clone();
        seen.sort_unstable();
        assert_eq!(seen, (0..150).collect::<Vec<u32>>());
        for (at, &point) in arranged.order.iter().enumerate() {
            let block = &arranged.blocks[at / BLOCK_SIZE];
            let x = points[point as usize].x - arranged.centre.x;
            assert_eq!(block.x[at % BLOCK_SIZE], x);
        }
        let weight: Vec<f64> = (0..150).map(f64::from).collect();
        let weighted = PointBlocks::new(&points, Some(&weight), true).expect("finite");
        for (at, &point) in weighted.order.iter().enumerate() {
            assert_eq!(
                weighted.weights(at / BLOCK_SIZE)[at % BLOCK_SIZE],
                f64::from(point)
            );
        }
        let mass: f64 = (0..3).flat_map(|b| *arranged.weights(b)).sum();
        assert_eq!(
            (mass, arranged.blocks.len()),
            (150.0, 150usize.div_ceil(BLOCK_SIZE))
        );
    }
}
