//! One exact pass of EM over the points: responsibilities and moments together, without a table of points times components.
//! Plain code over fixed blocks, vectorised by [`super::instructions`].

use super::constants::NEGLIGIBLE_BITS;
use super::exponential::{exp2, ln};
use super::instructions::{MAX_LANES, SimdKernel, multiply_add};
use super::point_blocks::{BLOCK_SIZE, Block, PointBlocks};
use super::prepared_component::{ComponentBounds, PreparedComponent};
use std::f64::consts::LN_2;

/// Sums of one component: r, r d (3), r d d^T (xx xy xz yy yz zz), with r the responsibility and d the offset from its mean.
pub(super) type MomentSums = [f64; 10];

/// Sums over the blocks of one task.
#[derive(Debug, Clone)]
pub(super) struct PassSums {
    /// Per component.
    pub moments: Vec<MomentSums>,
    /// Sum over the points of weight times ln f.
    pub log_likelihood: f64,
}

impl PassSums {
    pub(super) fn new(components: usize) -> Self {
        Self {
            moments: vec![[0.0; 10]; components],
            log_likelihood: 0.0,
        }
    }
}

/// Working space of one worker.
#[derive(Debug, Clone)]
pub(super) struct PassScratch {
    /// Moment sums of every component, lane by lane.
    lanes: Vec<[[f64; MAX_LANES]; 10]>,
    logs: Vec<[f64; BLOCK_SIZE]>,
    relevant: Vec<u32>,
    upper_bounds: Vec<f64>,
}

impl PassScratch {
    pub(super) fn new(components: usize) -> Self {
        Self {
            lanes: vec![[[0.0; MAX_LANES]; 10]; components],
            logs: vec![[0.0; BLOCK_SIZE]; components],
            relevant: Vec::with_capacity(components),
            upper_bounds: Vec::with_capacity(components + MAX_LANES),
        }
    }
}

/// One pass over the blocks of a task. `strongest` keeps each block's strongest component from pass to pass: evaluated
/// first, it lets far components be skipped early. Without `moments` the moment sums stay zero.
pub(super) struct EmPass<'a> {
    pub prepared: &'a [PreparedComponent],
    pub bounds: &'a ComponentBounds,
    pub point_blocks: &'a PointBlocks,
    /// Index of the first block; there are as many as entries in `strongest`.
    pub first_block: usize,
    pub strongest: &'a mut [u32],
    pub scratch: &'a mut PassScratch,
    pub pass_sums: &'a mut PassSums,
    pub moments: bool,
}

impl SimdKernel for EmPass<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool, const LANES: usize>(self) {
        let scratch = self.scratch;
        scratch
            .lanes
            .iter_mut()
            .for_each(|l| *l = [[0.0; MAX_LANES]; 10]);
        let mut likelihood = [0.0; LANES];
        for (at, strongest) in (self.first_block..).zip(self.strongest) {
            let (block, weights) = (&self.point_blocks.blocks[at], self.point_blocks.weights(at));
            let first = *strongest as usize;
            let best = evaluate_relevant::<FUSED, LANES>(
                self.prepared,
                self.bounds,
                block,
                first,
                scratch,
            );
            let relevant = &scratch.relevant;
            let logs = &mut scratch.logs[..relevant.len()];
            let share = normalise::<FUSED, LANES>(weights, &best, logs, &mut likelihood);
            if !self.moments {
                continue;
            }
            let mut most = -1.0;
            for (&k, parts) in relevant.iter().zip(logs.iter()) {
                let lanes = &mut scratch.lanes[k as usize];
                let added = accumulate::<FUSED, LANES>(
                    block,
                    &self.prepared[k as usize].mean,
                    parts,
                    &share,
                    lanes,
                );
                if added > most {
                    most = added;
                    *strongest = k;
                }
            }
        }
        self.pass_sums.log_likelihood = likelihood.iter().sum();
        for (sums, lanes) in self.pass_sums.moments.iter_mut().zip(&scratch.lanes) {
            *sums = lanes.map(|lane| lane.iter().sum());
        }
    }
}

/// Evaluates the components that are relevant to the block: their log densities in bits go to `scratch`; returns the largest
/// of every lane.
#[inline(always)]
fn evaluate_relevant<const FUSED: bool, const LANES: usize>(
    prepared: &[PreparedComponent],
    bounds: &ComponentBounds,
    block: &Block,
    first: usize,
    scratch: &mut PassScratch,
) -> [f64; BLOCK_SIZE] {
    let PassScratch {
        logs,
        relevant,
        upper_bounds,
        ..
    } = scratch;
    bounds.upper_bounds::<FUSED>(block, upper_bounds);
    relevant.clear();
    let mut best = [f64::NEG_INFINITY; BLOCK_SIZE];
    if prepared[first].peak > f64::NEG_INFINITY {
        prepared[first].log_densities::<FUSED>(block, &mut best);
        logs[0] = best;
        relevant.push(first as u32);
    }
    let mut floor = min_over_lanes::<LANES>(&best);
    for (k, component) in prepared.iter().enumerate() {
        // The bound of a component without weight is minus infinity.
        if upper_bounds[k] <= floor - NEGLIGIBLE_BITS
            || k == first
            || component.peak == f64::NEG_INFINITY
        {
            continue;
        }
        let log = &mut logs[relevant.len()];
        component.log_densities::<FUSED>(block, log);
        let margin = raise_to::<LANES>(log, &mut best);
        if margin > -NEGLIGIBLE_BITS {
            relevant.push(k as u32);
            floor = min_over_lanes::<LANES>(&best);
        }
    }
    best
}

/// Raises `best` to `log` where that is larger; returns the largest of `log` less the old `best`.
#[inline(always)]
#[expect(
    clippy::needless_range_loop,
    reason = "side-by-side arrays in lockstep vectorise"
)]
fn raise_to<const LANES: usize>(log: &[f64; BLOCK_SIZE], best: &mut [f64; BLOCK_SIZE]) -> f64 {
    let mut margin = [f64::NEG_INFINITY; LANES];
    for start in (0..BLOCK_SIZE).step_by(LANES) {
        for lane in 0..LANES {
            let i = start + lane;
            let over = log[i] - best[i];
            margin[lane] = if over > margin[lane] {
                over
            } else {
                margin[lane]
            };
            best[i] = if log[i] > best[i] { log[i] } else { best[i] };
        }
    }
    margin
        .into_iter()
        .fold(f64::NEG_INFINITY, |a, b| if b > a { b } else { a })
}

#[inline(always)]
fn min_over_lanes<const LANES: usize>(values: &[f64; BLOCK_SIZE]) -> f64 {
    let mut low = [f64::INFINITY; LANES];
    for start in (0..BLOCK_SIZE).step_by(LANES) {
        for lane in 0..LANES {
            let v = values[start + lane];
            low[lane] = if v < low[lane] { v } else { low[lane] };
        }
    }
    low.into_iter()
        .fold(f64::INFINITY, |a, b| if b < a { b } else { a })
}

/// Turns `logs` into densities relative to the best of each lane and adds to the likelihood; returns the factors that turn
/// them into weighted responsibilities.
#[inline(always)]
#[expect(
    clippy::needless_range_loop,
    reason = "side-by-side arrays in lockstep vectorise"
)]
fn normalise<const FUSED: bool, const LANES: usize>(
    weights: &[f64; BLOCK_SIZE],
    best: &[f64; BLOCK_SIZE],
    logs: &mut [[f64; BLOCK_SIZE]],
    likelihood: &mut [f64; LANES],
) -> [f64; BLOCK_SIZE] {
    let mut sum = [0.0; BLOCK_SIZE];
    for log in logs {
        for i in 0..BLOCK_SIZE {
            log[i] = exp2::<FUSED>(log[i] - best[i]);
            sum[i] += log[i];
        }
    }
    let mut share = [0.0; BLOCK_SIZE];
    for start in (0..BLOCK_SIZE).step_by(LANES) {
        for lane in 0..LANES {
            let i = start + lane;
            let log_density = multiply_add::<FUSED>(best[i], LN_2, ln::<FUSED>(sum[i]));
            likelihood[lane] = multiply_add::<FUSED>(weights[i], log_density, likelihood[lane]);
            share[i] = weights[i] / sum[i];
        }
    }
    share
}

/// Adds the moment sums of one component over one block; returns its mass in this block.
#[inline(always)]
#[expect(
    clippy::needless_range_loop,
    reason = "side-by-side arrays in lockstep vectorise"
)]
fn accumulate<const FUSED: bool, const LANES: usize>(
    block: &Block,
    mean: &[f64; 3],
    parts: &[f64; BLOCK_SIZE],
    share: &[f64; BLOCK_SIZE],
    into: &mut [[f64; MAX_LANES]; 10],
) -> f64 {
    let fma = multiply_add::<FUSED>;
    let mut sums = [[0.0; LANES]; 10];
    for start in (0..BLOCK_SIZE).step_by(LANES) {
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
            sums[4][lane] = fma(rx, dx, sums[4][lane]);
            sums[5][lane] = fma(rx, dy, sums[5][lane]);
            sums[6][lane] = fma(rx, dz, sums[6][lane]);
            sums[7][lane] = fma(ry, dy, sums[7][lane]);
            sums[8][lane] = fma(ry, dz, sums[8][lane]);
            sums[9][lane] = fma(rz, dz, sums[9][lane]);
        }
    }
    for (into, sums) in into.iter_mut().zip(&sums) {
        for lane in 0..LANES {
            into[lane] += sums[lane];
        }
    }
    sums[0].iter().sum()
}
