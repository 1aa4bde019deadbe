//! One exact pass of EM over the points: responsibilities and moments together, with no table of
//! points times components. Plain code in fixed blocks, written so that the compiler vectorises it.

use super::constants::NEGLIGIBLE_NATS;
use super::exponential::exp;
use super::lattice::{BLOCK, Block};
use super::symmetric::Eigen;
use super::{Density, Gaussian};

/// Lanes summed side by side; a block is a whole number of them.
const LANES: usize = 4;

/// A component made ready: everything the inner loops read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ready {
    pub mean: [f64; 3],
    /// Lower triangle of the whitening matrix times sqrt(1/2): 00 10 11 20 21 22.
    whiten: [f64; 6],
    /// ln p_k + ln of the density's peak.
    peak: f64,
    /// Eigenvectors over sqrt(2 lambda): bounds the distance to a box.
    axes: [[f64; 3]; 3],
}

impl Ready {
    /// `gaussian` about the lattice's centre; `None` if it has no density. A weight of zero is never near.
    pub(super) fn new(weight: f64, gaussian: &Gaussian) -> Option<Self> {
        let density = Density::of(gaussian)?;
        let w = density.whitening();
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let eigen = Eigen::of(&gaussian.covariance);
        // Half the rounding of the largest eigenvalue: an underestimate of 1/lambda keeps the bound below the truth.
        let slack = f64::EPSILON * 8.0 * eigen.values[2];
        let axes = std::array::from_fn(|i| {
            let scale = half / (eigen.values[i].max(0.0) + slack).sqrt() * (1.0 - 1e-9);
            std::array::from_fn(|r| eigen.vectors[(r, i)] * scale)
        });
        Some(Self {
            mean: gaussian.mean.into(),
            whiten: [
                w[(0, 0)],
                w[(1, 0)],
                w[(1, 1)],
                w[(2, 0)],
                w[(2, 1)],
                w[(2, 2)],
            ]
            .map(|v| v * half),
            peak: weight.ln() + density.log_peak(),
            axes,
        })
    }

    /// No point of the block has a log density above this.
    #[inline]
    fn ceiling(&self, block: &Block) -> f64 {
        self.peak - self.half_mahalanobis_floor(block)
    }

    /// Half the squared Mahalanobis distance of the block's box, from below.
    #[inline]
    pub(super) fn half_mahalanobis_floor(&self, block: &Block) -> f64 {
        let d: [f64; 3] = std::array::from_fn(|a| block.middle[a] - self.mean[a]);
        let mut sum = 0.0;
        for axis in &self.axes {
            let along = axis[0] * d[0] + axis[1] * d[1] + axis[2] * d[2];
            let reach = axis[0].abs() * block.half[0]
                + axis[1].abs() * block.half[1]
                + axis[2].abs() * block.half[2];
            let gap = along.abs() - reach;
            let gap = if gap > 0.0 { gap } else { 0.0 };
            sum += gap * gap;
        }
        sum
    }

    /// Half the squared Mahalanobis distance of every lane.
    #[inline]
    #[expect(
        clippy::needless_range_loop,
        reason = "side-by-side arrays in lockstep vectorise"
    )]
    pub(super) fn half_mahalanobis(&self, block: &Block, out: &mut [f64; BLOCK]) {
        let [w00, w10, w11, w20, w21, w22] = self.whiten;
        let [mx, my, mz] = self.mean;
        for i in 0..BLOCK {
            let (dx, dy, dz) = (block.x[i] - mx, block.y[i] - my, block.z[i] - mz);
            let a = w00 * dx;
            let b = w10 * dx + w11 * dy;
            let c = w20 * dx + w21 * dy + w22 * dz;
            out[i] = a * a + b * b + c * c;
        }
    }
}

/// Sums of one component: r, r d (3), r d d^T (xx xy xz yy yz zz), d from the component's mean.
pub(super) type Sums = [f64; 10];

/// Sums and working space of one run of blocks.
#[derive(Debug, Clone)]
pub(super) struct Tally {
    pub sums: Vec<Sums>,
    /// Sum over points of weight times ln f.
    pub log_likelihood: f64,
    logs: Vec<[f64; BLOCK]>,
    near: Vec<usize>,
}

impl Tally {
    pub(super) fn new(components: usize) -> Self {
        Self {
            sums: vec![[0.0; 10]; components],
            log_likelihood: 0.0,
            logs: vec![[0.0; BLOCK]; components],
            near: Vec::with_capacity(components),
        }
    }

    /// One pass over a run of blocks. `favourites` remembers each block's strongest component: asked
    /// first, it lets the far ones be left out early. `moments` false leaves `sums` at zero.
    pub(super) fn pass(
        &mut self,
        ready: &[Ready],
        blocks: &[Block],
        favourites: &mut [u32],
        moments: bool,
    ) {
        self.log_likelihood = 0.0;
        self.sums.iter_mut().for_each(|s| *s = [0.0; 10]);
        for (block, favourite) in blocks.iter().zip(favourites) {
            self.block(ready, block, favourite, moments);
        }
    }

    fn block(&mut self, ready: &[Ready], block: &Block, favourite: &mut u32, moments: bool) {
        let mut best = [f64::NEG_INFINITY; BLOCK];
        let mut floor = f64::NEG_INFINITY;
        let first = *favourite as usize;
        self.near.clear();
        let others = (0..ready.len()).filter(|&k| k != first);
        for k in std::iter::once(first).chain(others) {
            let component = &ready[k];
            // Also leaves out weight zero, whose peak is minus infinity.
            if component.ceiling(block) <= floor - NEGLIGIBLE_NATS
                || component.peak == f64::NEG_INFINITY
            {
                continue;
            }
            let logs = &mut self.logs[self.near.len()];
            component.half_mahalanobis(block, logs);
            for (log, best) in logs.iter_mut().zip(&mut best) {
                *log = component.peak - *log;
                *best = if *log > *best { *log } else { *best };
            }
            floor = lowest(&best);
            self.near.push(k);
        }

        let mut sum = [0.0; BLOCK];
        for logs in &mut self.logs[..self.near.len()] {
            for i in 0..BLOCK {
                logs[i] = exp(logs[i] - best[i]);
                sum[i] += logs[i];
            }
        }
        for i in 0..block.len {
            self.log_likelihood += block.weight[i] * (best[i] + sum[i].ln());
        }
        if !moments {
            return;
        }
        let mut share = [0.0; BLOCK];
        for i in 0..BLOCK {
            share[i] = block.weight[i] / sum[i];
        }
        let mut most = -1.0;
        for (&k, parts) in self.near.iter().zip(&self.logs) {
            let added = gather(block, &ready[k].mean, parts, &share);
            for (sum, part) in self.sums[k].iter_mut().zip(added) {
                *sum += part;
            }
            if added[0] > most {
                most = added[0];
                *favourite = k as u32;
            }
        }
    }
}

fn lowest(values: &[f64; BLOCK]) -> f64 {
    let mut low = [f64::INFINITY; LANES];
    for part in values.chunks_exact(LANES) {
        for (l, v) in low.iter_mut().zip(part) {
            *l = if *v < *l { *v } else { *l };
        }
    }
    low.into_iter().fold(f64::INFINITY, f64::min)
}

/// The ten sums of one block for one component.
#[inline]
#[expect(
    clippy::needless_range_loop,
    reason = "side-by-side arrays in lockstep vectorise"
)]
fn gather(block: &Block, mean: &[f64; 3], parts: &[f64; BLOCK], share: &[f64; BLOCK]) -> Sums {
    let mut sums = [[0.0; LANES]; 10];
    for start in (0..BLOCK).step_by(LANES) {
        for lane in 0..LANES {
            let i = start + lane;
            let r = parts[i] * share[i];
            let (dx, dy, dz) = (
                block.x[i] - mean[0],
                block.y[i] - mean[1],
                block.z[i] - mean[2],
            );
            let (rx, ry, rz) = (r * dx, r * dy, r * dz);
            sums[0][lane] += r;
            sums[1][lane] += rx;
            sums[2][lane] += ry;
            sums[3][lane] += rz;
            sums[4][lane] += rx * dx;
            sums[5][lane] += rx * dy;
            sums[6][lane] += rx * dz;
            sums[7][lane] += ry * dy;
            sums[8][lane] += ry * dz;
            sums[9][lane] += rz * dz;
        }
    }
    sums.map(|lanes| lanes.iter().sum())
}
