//! Components prepared for the inner loops. Log densities are in bits, since 2^x is cheaper than e^x.

use super::Gaussian;
use super::gaussian::GaussianDensity;
use super::instructions::{MAX_LANES, multiply_add};
use super::point_blocks::{BLOCK_SIZE, Block};
use std::f64::consts::LOG2_E;

/// Margin of the bounds against rounding, as a share of every distance.
const BOUND_MARGIN: f64 = 1e-9;

/// One component as the inner loops read it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PreparedComponent {
    pub mean: [f64; 3],
    /// Lower triangle (00 10 11 20 21 22) of the whitening matrix, scaled so that the squared norm of the whitened offset is
    /// half the squared Mahalanobis distance in bits.
    whiten: [f64; 6],
    /// log2 of weight times density at the mean; minus infinity for weight zero.
    pub peak: f64,
}

impl PreparedComponent {
    /// `gaussian` is relative to the centre of the points; `None` if its covariance is singular.
    pub(super) fn new(weight: f64, gaussian: &Gaussian) -> Option<Self> {
        let density = GaussianDensity::new(gaussian)?;
        let w = density.whitening();
        let scale = (0.5 * LOG2_E).sqrt();
        let lower = [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)];
        Some(Self {
            mean: gaussian.mean.into(),
            whiten: lower.map(|at| w[at] * scale),
            peak: (weight.ln() + density.log_peak()) * LOG2_E,
        })
    }

    /// Half the squared Mahalanobis distance of every lane, in bits.
    #[inline(always)]
    pub(super) fn half_mahalanobis_bits<const FUSED: bool>(
        &self,
        block: &Block,
        out: &mut [f64; BLOCK_SIZE],
    ) {
        let from_zero = Self { peak: 0.0, ..*self };
        from_zero.log_densities::<FUSED>(block, out);
        out.iter_mut().for_each(|o| *o = -*o);
    }

    /// log2 of weight times density at every lane.
    #[inline(always)]
    #[expect(
        clippy::needless_range_loop,
        reason = "side-by-side arrays in lockstep vectorise"
    )]
    pub(super) fn log_densities<const FUSED: bool>(
        &self,
        block: &Block,
        out: &mut [f64; BLOCK_SIZE],
    ) {
        let fma = multiply_add::<FUSED>;
        let [w00, w10, w11, w20, w21, w22] = self.whiten;
        let [mx, my, mz] = self.mean;
        for i in 0..BLOCK_SIZE {
            let (dx, dy, dz) = (block.x[i] - mx, block.y[i] - my, block.z[i] - mz);
            let a = w00 * dx;
            let b = fma(w11, dy, w10 * dx);
            let c = fma(w22, dz, fma(w21, dy, w20 * dx));
            out[i] = fma(-c, c, fma(-b, b, fma(-a, a, self.peak)));
        }
    }
}

/// All components as a structure of arrays, to bound their densities over a block at once.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct ComponentBounds {
    mean: [Vec<f64>; 3],
    whiten: [Vec<f64>; 6],
    peak: Vec<f64>,
}

impl ComponentBounds {
    pub(super) fn set(&mut self, prepared: &[PreparedComponent]) {
        let padded = prepared.len().next_multiple_of(MAX_LANES);
        let fill =
            |into: &mut Vec<f64>, value: &dyn Fn(&PreparedComponent) -> f64, padding: f64| {
                into.clear();
                into.extend(prepared.iter().map(value));
                into.resize(padded, padding);
            };
        for (axis, into) in self.mean.iter_mut().enumerate() {
            fill(into, &|r| r.mean[axis], 0.0);
        }
        for (entry, into) in self.whiten.iter_mut().enumerate() {
            fill(into, &|r| r.whiten[entry] * (1.0 - BOUND_MARGIN), 0.0);
        }
        fill(&mut self.peak, &|r| r.peak, f64::NEG_INFINITY);
    }

    /// For every component an upper bound of its log density over the block, in bits.
    #[inline(always)]
    pub(super) fn upper_bounds<const FUSED: bool>(&self, block: &Block, out: &mut Vec<f64>) {
        let fma = multiply_add::<FUSED>;
        let len = self.peak.len();
        out.resize(len, 0.0);
        let [mx, my, mz] = [0, 1, 2].map(|a| &self.mean[a][..len]);
        let [w00, w10, w11, w20, w21, w22] = [0, 1, 2, 3, 4, 5].map(|e| &self.whiten[e][..len]);
        let ([x, y, z], [hx, hy, hz]) = (block.middle, block.half);
        let out = &mut out[..len];
        let peak = &self.peak[..len];
        for k in 0..len {
            let (dx, dy, dz) = (x - mx[k], y - my[k], z - mz[k]);
            let gap = |along: f64, reach: f64| {
                let gap = along.abs() - reach;
                if gap > 0.0 { gap } else { 0.0 }
            };
            let a = gap(w00[k] * dx, w00[k].abs() * hx);
            let b = gap(
                fma(w11[k], dy, w10[k] * dx),
                fma(w11[k].abs(), hy, w10[k].abs() * hx),
            );
            let c = gap(
                fma(w22[k], dz, fma(w21[k], dy, w20[k] * dx)),
                fma(w22[k].abs(), hz, fma(w21[k].abs(), hy, w20[k].abs() * hx)),
            );
            out[k] = fma(-c, c, fma(-b, b, fma(-a, a, peak[k])));
        }
    }
}
