//! One ascent of the likelihood: E and M steps in turn until it stops.

use super::component::{Bounds, Ready};
use super::constants::DEAD_SHARE;
use super::em::{Collapse, EmSettings, Fit, Start, Stopped};
use super::kernel::{Pass, Scratch, Sums, Tally};
use super::lattice::Lattice;
use super::symmetric::Eigen;
use super::{Gaussian, Mixture, MixtureError};
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use std::sync::{Mutex, PoisonError};

/// Blocks summed by one worker in one go. Fixed, so that the order of summing never depends on threads.
const RUN: usize = 32;

/// An ascent under way. Coordinates are about the lattice's centre.
pub(super) struct Ascent<'a> {
    lattice: &'a Lattice,
    settings: &'a EmSettings,
    mixture: Mixture,
    frozen: usize,
    ready: Vec<Ready>,
    bounds: Bounds,
    tallies: Vec<Tally>,
    favourites: Vec<u32>,
    /// One for every worker.
    scratch: Vec<Mutex<Scratch>>,
    sums: Vec<Sums>,
    stepped: Vec<bool>,
    /// Mass that every component must hold to live.
    toll: f64,
    /// Whether the last M step ended a component for its toll.
    ended: bool,
}

impl<'a> Ascent<'a> {
    /// From `mixture`, whose first `frozen` components keep mean and covariance; a component's mass counts as
    /// far as it is above `toll`.
    ///
    /// # Errors
    /// A covariance that is singular with no regularisation.
    pub(super) fn new(
        lattice: &'a Lattice,
        mut mixture: Mixture,
        frozen: usize,
        toll: f64,
        settings: &'a EmSettings,
    ) -> Result<Self, MixtureError> {
        let k = mixture.len();
        let workers = match settings.threads {
            1 => 1,
            _ => rayon::current_num_threads(),
        };
        for gaussian in &mut mixture.components {
            gaussian.mean -= lattice.centre;
        }
        let mut ascent = Self {
            lattice,
            settings,
            frozen: frozen.min(k),
            ready: Vec::with_capacity(k),
            bounds: Bounds::default(),
            tallies: vec![Tally::new(k); lattice.blocks.len().div_ceil(RUN)],
            favourites: vec![0; lattice.blocks.len()],
            scratch: (0..workers).map(|_| Mutex::new(Scratch::new(k))).collect(),
            sums: vec![[0.0; 10]; k],
            stepped: vec![false; k],
            toll,
            ended: false,
            mixture,
        };
        ascent.make_ready()?;
        Ok(ascent)
    }

    /// Climbs until it stops.
    ///
    /// # Errors
    /// Points too far from all components, or a covariance that becomes singular.
    pub(super) fn climb(mut self) -> Result<Fit, MixtureError> {
        let settings = self.settings;
        let mut iterations = 0;
        let mut last = f64::NEG_INFINITY;
        let (mean_log_likelihood, stopped) = loop {
            let capped = iterations == settings.iterations;
            let likelihood = self.expect(!capped)?;
            let rests = likelihood - last < settings.tolerance && !self.ended;
            if settings.tolerance > 0.0 && iterations > 0 && rests {
                break (likelihood, Stopped::Converged);
            }
            if capped {
                break (likelihood, Stopped::IterationCap);
            }
            last = likelihood;
            self.maximise()?;
            iterations += 1;
        };
        let collapsed = self.collapsed();
        let mut mixture = self.mixture;
        for gaussian in &mut mixture.components {
            gaussian.mean += self.lattice.centre;
        }
        Ok(Fit {
            mixture,
            mean_log_likelihood,
            iterations,
            stopped,
            collapsed,
            start: Start::Given,
            runs: 1,
            instructions: settings.instructions.or_portable(),
            threads: self.scratch.len(),
        })
    }

    /// The E step, which also gathers what the M step needs if `moments`; gives the mean log-likelihood.
    fn expect(&mut self, moments: bool) -> Result<f64, MixtureError> {
        let (ready, bounds) = (&self.ready, &self.bounds);
        let instructions = self.settings.instructions;
        let lattice = self.lattice;
        let step = |scratch: &mut Scratch, run: usize, tally, favourites| {
            instructions.run(Pass {
                ready,
                bounds,
                lattice,
                first: run * RUN,
                favourites,
                scratch,
                tally,
                moments,
            });
        };
        if self.settings.threads == 1 {
            let scratch = self.scratch[0].get_mut();
            let scratch = scratch.unwrap_or_else(PoisonError::into_inner);
            let runs = self.tallies.iter_mut().zip(self.favourites.chunks_mut(RUN));
            for (run, (tally, favourites)) in runs.enumerate() {
                step(scratch, run, tally, favourites);
            }
        } else {
            let scratch = &self.scratch;
            self.tallies
                .par_iter_mut()
                .zip(self.favourites.par_chunks_mut(RUN))
                .enumerate()
                // One by one: a worker with a long list left would have the others wait for it.
                .with_max_len(1)
                .for_each(|(run, (tally, favourites))| {
                    let worker = rayon::current_thread_index().unwrap_or(0);
                    let scratch = scratch[worker].lock();
                    let mut scratch = scratch.unwrap_or_else(PoisonError::into_inner);
                    step(&mut scratch, run, tally, favourites);
                });
        }
        let sum: f64 = self.tallies.iter().map(|t| t.log_likelihood).sum();
        let mean = sum / self.lattice.total_weight;
        if mean.is_finite() {
            Ok(mean)
        } else {
            Err(MixtureError::OutOfReach)
        }
    }

    /// The M step.
    fn maximise(&mut self) -> Result<(), MixtureError> {
        self.sums.iter_mut().for_each(|s| *s = [0.0; 10]);
        for tally in &self.tallies {
            for (sum, part) in self.sums.iter_mut().zip(&tally.sums) {
                for (s, p) in sum.iter_mut().zip(part) {
                    *s += p;
                }
            }
        }
        let total = self.lattice.total_weight;
        let regularisation = Matrix3::from_diagonal_element(self.settings.regularisation_m2);
        for (k, sums) in self.sums.iter().enumerate() {
            let alive = sums[0] > DEAD_SHARE * total;
            self.mixture.weights[k] = if alive { sums[0] / total } else { 0.0 };
            if alive && k >= self.frozen {
                let (shift, covariance) = moments(sums);
                let gaussian = &mut self.mixture.components[k];
                gaussian.mean += shift;
                gaussian.covariance = covariance + regularisation;
                self.stepped[k] = true;
            }
        }
        if self.toll > 0.0 {
            self.ended = self.take_toll();
        }
        let sum: f64 = self.mixture.weights.iter().sum();
        self.mixture.weights.iter_mut().for_each(|w| *w /= sum);
        self.make_ready()
    }

    /// Takes the toll from every weight. Of those that cannot pay only the lightest ends, and never the last
    /// of all: its points may save the others. Gives whether one ended.
    fn take_toll(&mut self) -> bool {
        let toll = self.toll / self.lattice.total_weight;
        let weights = &mut self.mixture.weights;
        let alive = (0..weights.len()).filter(|&k| weights[k] > 0.0);
        let mut by_weight: Vec<usize> = alive.collect();
        by_weight.sort_by(|&a, &b| weights[a].total_cmp(&weights[b]));
        let ends = by_weight
            .first()
            .copied()
            .filter(|&k| weights[k] <= toll && by_weight.len() > 1);
        for k in by_weight {
            if weights[k] > toll {
                weights[k] -= toll;
            }
        }
        if let Some(k) = ends {
            weights[k] = 0.0;
        }
        ends.is_some()
    }

    fn make_ready(&mut self) -> Result<(), MixtureError> {
        let parts = self.mixture.weights.iter().zip(&self.mixture.components);
        self.ready.clear();
        for (component, (&weight, gaussian)) in parts.enumerate() {
            let ready = make_ready(component, weight, gaussian, self.settings.regularisation_m2)?;
            self.ready.push(ready);
        }
        self.bounds.set(&self.ready);
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
            let flat = regularisation.max(f64::EPSILON * covariance.trace());
            let no_volume = self.stepped[k] && Eigen::of(&own).values[0] <= flat;
            no_volume.then_some((k, Collapse::NoVolume))
        };
        (0..self.mixture.len()).filter_map(state).collect()
    }
}

/// Shift of the mean and the covariance about the new mean.
fn moments(sums: &Sums) -> (Vector3<f64>, Matrix3<f64>) {
    let [n, x, y, z, xx, xy, xz, yy, yz, zz] = *sums;
    let shift = Vector3::new(x, y, z) / n;
    let about_old = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) / n;
    (shift, about_old - shift * shift.transpose())
}

/// Ready for the next pass. A covariance whose thickness drowns in the rounding of its length is
/// evaluated a trace of rounding thicker; the mixture itself keeps what the M step gave.
fn make_ready(
    component: usize,
    weight: f64,
    gaussian: &Gaussian,
    regularisation_m2: f64,
) -> Result<Ready, MixtureError> {
    if let Some(ready) = Ready::new(weight, gaussian) {
        return Ok(ready);
    }
    let trace = gaussian.covariance.trace();
    let floor = regularisation_m2.max(trace * 16.0 * f64::EPSILON);
    for extra in [floor, 100.0 * floor] {
        let thicker = Gaussian {
            covariance: gaussian.covariance + Matrix3::from_diagonal_element(extra),
            ..*gaussian
        };
        if let Some(ready) = Ready::new(weight, &thicker).filter(|_| regularisation_m2 > 0.0) {
            return Ok(ready);
        }
    }
    Err(MixtureError::Singular { component })
}
