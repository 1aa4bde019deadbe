//! One exact pass of EM over the points: responsibilities and moments together, with no table of
//! points times components. Plain code in fixed blocks, which [`super::instructions`] has vectorised.

use super::component::{Bounds, Ready};
use super::constants::NEGLIGIBLE_BITS;
use super::exponential::{exp2, ln};
use super::instructions::{Loops, WIDEST, multiply_add};
use super::lattice::{BLOCK, Block, Lattice};
use std::f64::consts::LN_2;

/// Sums of one component: r, r d (3), r d d^T (xx xy xz yy yz zz), d from the component's mean.
pub(super) type Sums = [f64; 10];

/// What one run of blocks adds up to.
#[derive(Debug, Clone)]
pub(super) struct Tally {
    pub sums: Vec<Sums>,
    /// Sum over points of weight times ln f.
    pub log_likelihood: f64,
}

impl Tally {
    pub(super) fn new(components: usize) -> Self {
        Self {
            sums: vec![[0.0; 10]; components],
            log_likelihood: 0.0,
        }
    }
}

/// Working space of one worker.
#[derive(Debug, Clone)]
pub(super) struct Scratch {
    /// Sums of every component, lane by lane.
    lanes: Vec<[[f64; WIDEST]; 10]>,
    logs: Vec<[f64; BLOCK]>,
    near: Vec<u32>,
    ceilings: Vec<f64>,
}

impl Scratch {
    pub(super) fn new(components: usize) -> Self {
        Self {
            lanes: vec![[[0.0; WIDEST]; 10]; components],
            logs: vec![[0.0; BLOCK]; components],
            near: Vec::with_capacity(components),
            ceilings: Vec::with_capacity(components + WIDEST),
        }
    }
}

/// One pass over a run of blocks. `favourites` remembers each block's strongest component: asked
/// first, it lets the far ones be left out early. `moments` false leaves the sums at zero.
pub(super) struct Pass<'a> {
    pub ready: &'a [Ready],
    pub bounds: &'a Bounds,
    pub lattice: &'a Lattice,
    /// The first block of the run; as many follow as there are favourites.
    pub first: usize,
    pub favourites: &'a mut [u32],
    pub scratch: &'a mut Scratch,
    pub tally: &'a mut Tally,
    pub moments: bool,
}

impl Loops for Pass<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool, const LANES: usize>(self) {
        let scratch = self.scratch;
        scratch
            .lanes
            .iter_mut()
            .for_each(|l| *l = [[0.0; WIDEST]; 10]);
        let mut likelihood = [0.0; LANES];
        for (at, favourite) in (self.first..).zip(self.favourites) {
            let (block, weights) = (&self.lattice.blocks[at], self.lattice.weights(at));
            let first = *favourite as usize;
            let best = nearest::<FUSED, LANES>(self.ready, self.bounds, block, first, scratch);
            let near = &scratch.near;
            let logs = &mut scratch.logs[..near.len()];
            let share = shares::<FUSED, LANES>(weights, &best, logs, &mut likelihood);
            if !self.moments {
                continue;
            }
            let mut most = -1.0;
            for (&k, parts) in near.iter().zip(logs.iter()) {
                let lanes = &mut scratch.lanes[k as usize];
                let added = gather::<FUSED, LANES>(
                    block,
                    &self.ready[k as usize].mean,
                    parts,
                    &share,
                    lanes,
                );
                if added > most {
                    most = added;
                    *favourite = k;
                }
            }
        }
        self.tally.log_likelihood = likelihood.iter().sum();
        for (sums, lanes) in self.tally.sums.iter_mut().zip(&scratch.lanes) {
            *sums = lanes.map(|lane| lane.iter().sum());
        }
    }
}

/// Binary log densities of the components that matter to the block, in `scratch`, and the best of every lane.
#[inline(always)]
fn nearest<const FUSED: bool, const LANES: usize>(
    ready: &[Ready],
    bounds: &Bounds,
    block: &Block,
    first: usize,
    scratch: &mut Scratch,
) -> [f64; BLOCK] {
    let Scratch {
        logs,
        near,
        ceilings,
        ..
    } = scratch;
    bounds.ceilings::<FUSED>(block, ceilings);
    near.clear();
    let mut best = [f64::NEG_INFINITY; BLOCK];
    if ready[first].peak > f64::NEG_INFINITY {
        ready[first].log_densities::<FUSED>(block, &mut best);
        logs[0] = best;
        near.push(first as u32);
    }
    let mut floor = lowest::<LANES>(&best);
    for (k, component) in ready.iter().enumerate() {
        // A component without weight has a ceiling of minus infinity, above which nothing lies.
        if ceilings[k] <= floor - NEGLIGIBLE_BITS
            || k == first
            || component.peak == f64::NEG_INFINITY
        {
            continue;
        }
        let log = &mut logs[near.len()];
        component.log_densities::<FUSED>(block, log);
        let margin = raise::<LANES>(log, &mut best);
        if margin > -NEGLIGIBLE_BITS {
            near.push(k as u32);
            floor = lowest::<LANES>(&best);
        }
    }
    best
}

/// Raises `best` to `log` where that is more; gives the largest of `log` less the old best.
#[inline(always)]
#[expect(
    clippy::needless_range_loop,
    reason = "side-by-side arrays in lockstep vectorise"
)]
fn raise<const LANES: usize>(log: &[f64; BLOCK], best: &mut [f64; BLOCK]) -> f64 {
    let mut margin = [f64::NEG_INFINITY; LANES];
    for start in (0..BLOCK).step_by(LANES) {
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
fn lowest<const LANES: usize>(values: &[f64; BLOCK]) -> f64 {
    let mut low = [f64::INFINITY; LANES];
    for start in (0..BLOCK).step_by(LANES) {
        for lane in 0..LANES {
            let v = values[start + lane];
            low[lane] = if v < low[lane] { v } else { low[lane] };
        }
    }
    low.into_iter()
        .fold(f64::INFINITY, |a, b| if b < a { b } else { a })
}

/// Makes `logs` densities relative to the best of each lane and adds up the likelihood; gives what turns
/// them into weighted responsibilities.
#[inline(always)]
#[expect(
    clippy::needless_range_loop,
    reason = "side-by-side arrays in lockstep vectorise"
)]
fn shares<const FUSED: bool, const LANES: usize>(
    weights: &[f64; BLOCK],
    best: &[f64; BLOCK],
    logs: &mut [[f64; BLOCK]],
    likelihood: &mut [f64; LANES],
) -> [f64; BLOCK] {
    let mut sum = [0.0; BLOCK];
    for log in logs {
        for i in 0..BLOCK {
            log[i] = exp2::<FUSED>(log[i] - best[i]);
            sum[i] += log[i];
        }
    }
    let mut share = [0.0; BLOCK];
    for start in (0..BLOCK).step_by(LANES) {
        for lane in 0..LANES {
            let i = start + lane;
            let log_density = multiply_add::<FUSED>(best[i], LN_2, ln::<FUSED>(sum[i]));
            likelihood[lane] = multiply_add::<FUSED>(weights[i], log_density, likelihood[lane]);
            share[i] = weights[i] / sum[i];
        }
    }
    share
}

/// Adds the ten sums of one block for one component; gives the first of them, for this block alone.
#[inline(always)]
#[expect(
    clippy::needless_range_loop,
    reason = "side-by-side arrays in lockstep vectorise"
)]
fn gather<const FUSED: bool, const LANES: usize>(
    block: &Block,
    mean: &[f64; 3],
    parts: &[f64; BLOCK],
    share: &[f64; BLOCK],
    into: &mut [[f64; WIDEST]; 10],
) -> f64 {
    let fma = multiply_add::<FUSED>;
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
