//! How many components the shortest message needs (Figueiredo and Jain 2002, "Unsupervised learning of finite
//! mixture models"): EM that takes a toll of every component, and ends the lightest one by one.
//!
//! All components step at once, not in turn; that at most one ends per step does what the turns are for.

use super::em::ascend;
use super::{EmSettings, Fit, Mixture, MixtureError};
use nalgebra::Point3;

/// Free numbers of one component besides its weight: three of the mean, six of the covariance.
const NUMBERS: f64 = 9.0;

/// Length of the message that tells a mixture and `points` points coded by it, nats (their Eq. 15); less is
/// better. Components without weight cost nothing.
pub fn message_length(fit: &Fit, points: f64) -> f64 {
    let alive: Vec<f64> = fit
        .mixture
        .weights
        .iter()
        .copied()
        .filter(|w| *w > 0.0)
        .collect();
    let k = alive.len() as f64;
    let weights: f64 = alive.iter().map(|w| (points * w / 12.0).ln()).sum();
    0.5 * NUMBERS * weights + 0.5 * k * (points / 12.0).ln() + 0.5 * k * (NUMBERS + 1.0)
        - points * fit.mean_log_likelihood
}

/// The fit of the least [`message_length`] on the way from `start` down to one component, and that length.
///
/// # Errors
/// As [`super::em::run`].
pub(super) fn shortest(
    points: &[Point3<f64>],
    weights: Option<&[f64]>,
    start: Mixture,
    settings: &EmSettings,
) -> Result<(Fit, f64), MixtureError> {
    let count = points.len() as f64;
    let mut start = start;
    let mut best: Option<(Fit, f64)> = None;
    let mut runs = 0;
    loop {
        let mut fit = ascend(points, weights, start, 0, 0.5 * NUMBERS, settings)?;
        runs += 1;
        drop_ended(&mut fit);
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
            (None, Some((fit, length))) => return Ok((Fit { runs, ..fit }, length)),
            (None, None) => return Err(MixtureError::NoComponents),
        }
    }
}

/// Leaves out components without weight.
fn drop_ended(fit: &mut Fit) {
    let weights = std::mem::take(&mut fit.mixture.weights);
    let components = std::mem::take(&mut fit.mixture.components);
    let mut living = 0;
    let mut places = Vec::with_capacity(weights.len());
    for &weight in &weights {
        places.push((weight > 0.0).then_some(living));
        living += usize::from(weight > 0.0);
    }
    let alive = weights
        .into_iter()
        .zip(components)
        .filter(|(w, _)| *w > 0.0);
    (fit.mixture.weights, fit.mixture.components) = alive.unzip();
    fit.collapsed.retain_mut(|(k, _)| match places[*k] {
        Some(at) => {
            *k = at;
            true
        }
        None => false,
    });
}
