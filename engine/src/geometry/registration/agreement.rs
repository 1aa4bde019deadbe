//! How well a view agrees with the reference, along each way in which it could move.

use super::normal_equations::{MatchedPoint, NormalEquations, jacobian};
use super::settings::RegistrationSettings;
use crate::geometry::constants::BLOCK_M;
use crate::geometry::{SurfacePatch, Surfaces, voxel_downsample};
use nalgebra::{Matrix6, Point3, Vector3};

/// Flat cells of a view, each with what it says about the directions in which the view can move. A floor says nothing about a
/// way along it, however large it is.
pub(super) struct Witnesses {
    /// Means of the cells, frame of the view, metres.
    pub(super) points: Vec<Point3<f64>>,
    /// Share of each cell in all that resists a motion, summed over the directions that the surfaces fix and divided by their
    /// number. The shares sum to one.
    shares: Vec<f64>,
    /// The block of each cell, which err together ([`BLOCK_M`]).
    pub(super) blocks: Vec<u32>,
    /// What the blocks would have if every cell agreed.
    pub(super) block_shares: BlockAgreements,
}

/// How well a view agrees with the reference, from 0 to 1.
pub(super) struct Agreement {
    /// Mean over its flat cells.
    pub(super) mean: f64,
    /// Mean where every direction that its surfaces fix counts alike.
    pub(super) by_direction: f64,
}

/// The parts of blocks in an [`Agreement`], which is their sum.
pub(super) struct BlockAgreements {
    pub(super) mean: Vec<f64>,
    pub(super) by_direction: Vec<f64>,
}

impl BlockAgreements {
    fn zero(blocks: usize) -> Self {
        Self {
            mean: vec![0.0; blocks],
            by_direction: vec![0.0; blocks],
        }
    }
}

impl Witnesses {
    /// Some of the flat cells of `surfaces`, at most `max_points`, as seen from `origin`.
    pub(super) fn new(
        surfaces: &Surfaces,
        origin: &Point3<f64>,
        max_points: usize,
        settings: &RegistrationSettings,
    ) -> Self {
        let flat: Vec<&SurfacePatch> = surfaces.patches.iter().filter(|p| p.flat).collect();
        let step = flat.len().div_ceil(max_points.max(1)).max(1);
        let chosen = || flat.iter().step_by(step);
        let mut equations = NormalEquations::new();
        for patch in chosen() {
            equations.add(&on_itself(patch, origin), f64::INFINITY);
        }
        let (eigen, scale) = equations.eigenpairs();
        // Takes a derivative to what it says of each fixed direction, in units of what all cells say of it.
        let whitened = Matrix6::from_fn(|row, column| {
            let value = eigen.eigenvalues[row];
            match value >= settings.min_observability {
                true => scale[column] * eigen.eigenvectors[(column, row)] / value.sqrt(),
                false => 0.0,
            }
        });
        let part =
            |p: &&SurfacePatch| (whitened * jacobian(&p.normal, &(p.mean - origin))).norm_squared();
        let mut shares: Vec<f64> = chosen().map(part).collect();
        let total = shares.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        shares.iter_mut().for_each(|share| *share /= total);
        let points: Vec<Point3<f64>> = chosen().map(|p| p.mean).collect();
        let blocks = voxel_downsample(&points, BLOCK_M);
        let mut view = Self {
            points,
            shares,
            blocks: blocks.voxel_of_point,
            block_shares: BlockAgreements::zero(blocks.points.len()),
        };
        view.block_shares = view.block_agreements(|_| 1.0);
        view
    }

    /// The parts of the blocks in the [`Agreement`].
    pub(super) fn block_agreements(&self, agrees: impl Fn(&Point3<f64>) -> f64) -> BlockAgreements {
        let mut sums = BlockAgreements::zero(self.block_shares.mean.len());
        let n = (self.points.len() as f64).max(1.0);
        for ((point, share), block) in self.points.iter().zip(&self.shares).zip(&self.blocks) {
            let agreement = agrees(point);
            sums.mean[*block as usize] += agreement / n;
            sums.by_direction[*block as usize] += share * agreement;
        }
        sums
    }

    /// Mean of `agrees`, from 0 to 1 for each cell.
    pub(super) fn agreement(&self, agrees: impl Fn(&Point3<f64>) -> f64) -> Agreement {
        let blocks = self.block_agreements(agrees);
        Agreement {
            mean: blocks.mean.iter().sum(),
            by_direction: blocks.by_direction.iter().sum(),
        }
    }
}

/// A cell that lies on its own plane.
fn on_itself(patch: &SurfacePatch, origin: &Point3<f64>) -> MatchedPoint {
    MatchedPoint {
        lever: patch.mean - origin,
        ray: Vector3::zeros(),
        range_m: 0.0,
        height_m: 0.0,
        normal: patch.normal,
    }
}
