//! Number of components by minimum message length (Figueiredo and Jain 2002, "Unsupervised learning of finite mixture
//! models"): EM that subtracts a penalty from the mass of every component and annihilates the lightest, one by one.
//!
//! All components are updated at once instead of in turn; at most one is annihilated per step, which serves the same end.

use super::em::run_with_mass_penalty;
use super::{EmFit, EmSettings, Mixture, MixtureError};
use nalgebra::Point3;

/// Free parameters of a component besides its weight: three of the mean, six of the covariance.
const PARAMETERS: f64 = 9.0;

/// Length of a message that encodes a mixture and `points` points by it, nats (their Eq. 15); less is better. Components
/// without weight cost nothing.
fn message_length(fit: &EmFit, points: f64) -> f64 {
    let alive: Vec<f64> = fit
        .mixture
        .weights
        .iter()
        .copied()
        .filter(|w| *w > 0.0)
        .collect();
    let k = alive.len() as f64;
    let weights: f64 = alive.iter().map(|w| (points * w / 12.0).ln()).sum();
    0.5 * PARAMETERS * weights + 0.5 * k * (points / 12.0).ln() + 0.5 * k * (PARAMETERS + 1.0)
        - points * fit.mean_log_likelihood
}

/// The fit of the least [`message_length`] on the way from `start` down to one component, with that length.
///
/// # Errors
/// As [`super::em::run`].
pub(super) fn fit_least_length(
    points: &[Point3<f64>],
    weights: Option<&[f64]>,
    start: Mixture,
    settings: &EmSettings,
) -> Result<(EmFit, f64), MixtureError> {
    let count = points.len() as f64;
    let mut start = start;
    let mut best: Option<(EmFit, f64)> = None;
    let mut runs = 0;
    loop {
        let mut fit = run_with_mass_penalty(points, weights, start, 0, 0.5 * PARAMETERS, settings)?;
        runs += 1;
        drop_annihilated(&mut fit);
        let length = message_length(&fit, count);
        let Mixture {
            weights: w,
            components,
        } = &fit.mixture;
        let lightest = (0..w.len()).min_by(|&a, &b| w[a].total_cmp(&w[b]));
        let next = lightest.filter(|_| w.len() > 1).map(|k| {
            let (mut w, mut components) = (w.clone(), components.clone());
            w.remove(k);
            components.remove(k);
            Mixture {
                weights: w,
                components,
            }
        });
        if best.as_ref().is_none_or(|(_, least)| length < *least) {
            best = Some((fit, length));
        }
        match (next, best) {
            (Some(fewer), kept) => (start, best) = (fewer, kept),
            (None, Some((fit, length))) => return Ok((EmFit { runs, ..fit }, length)),
            (None, None) => return Err(MixtureError::NoComponents),
        }
    }
}

/// Removes components without weight.
fn drop_annihilated(fit: &mut EmFit) {
    let weights = std::mem::take(&mut fit.mixture.weights);
    let components = std::mem::take(&mut fit.mixture.components);
    let mut kept = 0;
    let mut new_index = Vec::with_capacity(weights.len());
    for &weight in &weights {
        new_index.push((weight > 0.0).then_some(kept));
        kept += usize::from(weight > 0.0);
    }
    let alive = weights
        .into_iter()
        .zip(components)
        .filter(|(w, _)| *w > 0.0);
    (fit.mixture.weights, fit.mixture.components) = alive.unzip();
    fit.collapsed.retain_mut(|(k, _)| match new_index[*k] {
        Some(at) => {
            *k = at;
            true
        }
        None => false,
    });
}
