//! One run of EM: E and M steps in turn until it stops.

use super::constants::DEAD_SHARE;
use super::em_fit::{Collapse, EmFit, FitStart, StopReason};
use super::em_settings::EmSettings;
use super::kernel::{EmPass, MomentSums, PassScratch, PassSums};
use super::linalg::Eigen;
use super::point_blocks::PointBlocks;
use super::prepared_component::{ComponentBounds, PreparedComponent};
use super::{Gaussian, Mixture, MixtureError};
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use std::sync::{Mutex, PoisonError};

/// Blocks summed by one task. Fixed, so that the order of summing does not depend on the number of threads.
const BLOCKS_PER_TASK: usize = 32;

/// A run in progress. Coordinates are relative to the centre of the points.
pub(super) struct EmState<'a> {
    point_blocks: &'a PointBlocks,
    settings: &'a EmSettings,
    mixture: Mixture,
    frozen: usize,
    prepared: Vec<PreparedComponent>,
    bounds: ComponentBounds,
    /// One per task.
    pass_sums: Vec<PassSums>,
    /// Strongest component of each block.
    strongest: Vec<u32>,
    /// One per worker.
    scratch: Vec<Mutex<PassScratch>>,
    sums: Vec<MomentSums>,
    /// Whether an M step gave the component its shape.
    updated: Vec<bool>,
    /// Mass subtracted from every component in the M step; those without more are annihilated.
    mass_penalty: f64,
    /// Whether the last M step annihilated a component.
    annihilated: bool,
}

impl<'a> EmState<'a> {
    /// A run from `mixture`, whose first `frozen` components keep mean and covariance.
    ///
    /// # Errors
    /// A singular covariance without regularisation.
    pub(super) fn new(
        point_blocks: &'a PointBlocks,
        mut mixture: Mixture,
        frozen: usize,
        mass_penalty: f64,
        settings: &'a EmSettings,
    ) -> Result<Self, MixtureError> {
        let k = mixture.len();
        let workers = match settings.threads {
            1 => 1,
            _ => rayon::current_num_threads(),
        };
        for gaussian in &mut mixture.components {
            gaussian.mean -= point_blocks.centre;
        }
        let mut state = Self {
            point_blocks,
            settings,
            frozen: frozen.min(k),
            prepared: Vec::with_capacity(k),
            bounds: ComponentBounds::default(),
            pass_sums: vec![PassSums::new(k); point_blocks.blocks.len().div_ceil(BLOCKS_PER_TASK)],
            strongest: vec![0; point_blocks.blocks.len()],
            scratch: (0..workers)
                .map(|_| Mutex::new(PassScratch::new(k)))
                .collect(),
            sums: vec![[0.0; 10]; k],
            updated: vec![false; k],
            mass_penalty,
            annihilated: false,
            mixture,
        };
        state.prepare()?;
        Ok(state)
    }

    /// Runs until it converges or reaches the cap.
    ///
    /// # Errors
    /// Points too far from all components, or a covariance that becomes singular.
    pub(super) fn run(mut self) -> Result<EmFit, MixtureError> {
        let settings = self.settings;
        let mut iterations = 0;
        let mut last = f64::NEG_INFINITY;
        let (mean_log_likelihood, stopped) = loop {
            let capped = iterations == settings.iterations;
            let likelihood = self.e_step(!capped)?;
            let converged = likelihood - last < settings.tolerance && !self.annihilated;
            if settings.tolerance > 0.0 && iterations > 0 && converged {
                break (likelihood, StopReason::Converged);
            }
            if capped {
                break (likelihood, StopReason::IterationCap);
            }
            last = likelihood;
            self.m_step()?;
            iterations += 1;
        };
        let collapsed = self.collapsed();
        let mut mixture = self.mixture;
        for gaussian in &mut mixture.components {
            gaussian.mean += self.point_blocks.centre;
        }
        Ok(EmFit {
            mixture,
            mean_log_likelihood,
            iterations,
            stopped,
            collapsed,
            start: FitStart::Given,
            runs: 1,
            instructions: settings.instructions.or_portable(),
            threads: self.scratch.len(),
        })
    }

    /// The E step; also sums the moments for the M step if `moments`. The mean log-likelihood.
    fn e_step(&mut self, moments: bool) -> Result<f64, MixtureError> {
        let (prepared, bounds) = (&self.prepared, &self.bounds);
        let instructions = self.settings.instructions;
        let point_blocks = self.point_blocks;
        let step = |scratch: &mut PassScratch, task: usize, pass_sums, strongest| {
            instructions.run(EmPass {
                prepared,
                bounds,
                point_blocks,
                first_block: task * BLOCKS_PER_TASK,
                strongest,
                scratch,
                pass_sums,
                moments,
            });
        };
        if self.settings.threads == 1 {
            let scratch = self.scratch[0].get_mut();
            let scratch = scratch.unwrap_or_else(PoisonError::into_inner);
            let tasks = self
                .pass_sums
                .iter_mut()
                .zip(self.strongest.chunks_mut(BLOCKS_PER_TASK));
            for (task, (pass_sums, strongest)) in tasks.enumerate() {
                step(scratch, task, pass_sums, strongest);
            }
        } else {
            let scratch = &self.scratch;
            self.pass_sums
                .par_iter_mut()
                .zip(self.strongest.par_chunks_mut(BLOCKS_PER_TASK))
                .enumerate()
                // One task at a time: the others would wait for a worker with a long list left.
                .with_max_len(1)
                .for_each(|(task, (pass_sums, strongest))| {
                    let worker = rayon::current_thread_index().unwrap_or(0);
                    let scratch = scratch[worker].lock();
                    let mut scratch = scratch.unwrap_or_else(PoisonError::into_inner);
                    step(&mut scratch, task, pass_sums, strongest);
                });
        }
        let sum: f64 = self.pass_sums.iter().map(|s| s.log_likelihood).sum();
        let mean = sum / self.point_blocks.total_weight;
        if mean.is_finite() {
            Ok(mean)
        } else {
            Err(MixtureError::LogLikelihoodUnderflow)
        }
    }

    fn m_step(&mut self) -> Result<(), MixtureError> {
        self.sums.iter_mut().for_each(|s| *s = [0.0; 10]);
        for pass_sums in &self.pass_sums {
            for (sum, part) in self.sums.iter_mut().zip(&pass_sums.moments) {
                for (s, p) in sum.iter_mut().zip(part) {
                    *s += p;
                }
            }
        }
        let total = self.point_blocks.total_weight;
        let regularisation = Matrix3::from_diagonal_element(self.settings.regularisation_m2);
        for (k, sums) in self.sums.iter().enumerate() {
            let alive = sums[0] > DEAD_SHARE * total;
            self.mixture.weights[k] = if alive { sums[0] / total } else { 0.0 };
            if alive && k >= self.frozen {
                let (shift, covariance) = moments(sums);
                let gaussian = &mut self.mixture.components[k];
                gaussian.mean += shift;
                gaussian.covariance = covariance + regularisation;
                self.updated[k] = true;
            }
        }
        if self.mass_penalty > 0.0 {
            self.annihilated = self.apply_mass_penalty();
        }
        let sum: f64 = self.mixture.weights.iter().sum();
        self.mixture.weights.iter_mut().for_each(|w| *w /= sum);
        self.prepare()
    }

    /// Subtracts the penalty from every weight above it. Only the lightest component at or below it is annihilated, and never
    /// the last one: its points may save the others. Whether one was.
    fn apply_mass_penalty(&mut self) -> bool {
        let penalty = self.mass_penalty / self.point_blocks.total_weight;
        let weights = &mut self.mixture.weights;
        let alive = (0..weights.len()).filter(|&k| weights[k] > 0.0);
        let mut by_weight: Vec<usize> = alive.collect();
        by_weight.sort_by(|&a, &b| weights[a].total_cmp(&weights[b]));
        let annihilated = by_weight
            .first()
            .copied()
            .filter(|&k| weights[k] <= penalty && by_weight.len() > 1);
        for k in by_weight {
            if weights[k] > penalty {
                weights[k] -= penalty;
            }
        }
        if let Some(k) = annihilated {
            weights[k] = 0.0;
        }
        annihilated.is_some()
    }

    fn prepare(&mut self) -> Result<(), MixtureError> {
        let parts = self.mixture.weights.iter().zip(&self.mixture.components);
        self.prepared.clear();
        for (component, (&weight, gaussian)) in parts.enumerate() {
            let prepared = prepare(component, weight, gaussian, self.settings.regularisation_m2)?;
            self.prepared.push(prepared);
        }
        self.bounds.set(&self.prepared);
        Ok(())
    }

    fn collapsed(&self) -> Vec<(usize, Collapse)> {
        let regularisation = self.settings.regularisation_m2;
        let state = |k: usize| {
            if self.mixture.weights[k] == 0.0 {
                return Some((k, Collapse::NoMass));
            }
            let covariance = &self.mixture.components[k].covariance;
            let own = covariance - Matrix3::from_diagonal_element(regularisation);
            let rounding = regularisation.max(f64::EPSILON * covariance.trace());
            let no_volume = self.updated[k] && Eigen::new(&own).values[0] <= rounding;
            no_volume.then_some((k, Collapse::NoVolume))
        };
        (0..self.mixture.len()).filter_map(state).collect()
    }
}

/// Shift of the mean, and covariance about the new mean.
fn moments(sums: &MomentSums) -> (Vector3<f64>, Matrix3<f64>) {
    let [n, x, y, z, xx, xy, xz, yy, yz, zz] = *sums;
    let shift = Vector3::new(x, y, z) / n;
    let about_old = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) / n;
    (shift, about_old - shift * shift.transpose())
}

/// Prepares a component for the next pass. A covariance whose smallest eigenvalue is lost in rounding is evaluated slightly
/// thicker; the mixture itself keeps what the M step gave.
fn prepare(
    component: usize,
    weight: f64,
    gaussian: &Gaussian,
    regularisation_m2: f64,
) -> Result<PreparedComponent, MixtureError> {
    if let Some(prepared) = PreparedComponent::new(weight, gaussian) {
        return Ok(prepared);
    }
    let trace = gaussian.covariance.trace();
    let floor = regularisation_m2.max(trace * 16.0 * f64::EPSILON);
    for extra in [floor, 100.0 * floor] {
        let thicker = Gaussian {
            covariance: gaussian.covariance + Matrix3::from_diagonal_element(extra),
            ..*gaussian
        };
        let prepared = PreparedComponent::new(weight, &thicker);
        if let Some(prepared) = prepared.filter(|_| regularisation_m2 > 0.0) {
            return Ok(prepared);
        }
    }
    Err(MixtureError::Singular { component })
}
