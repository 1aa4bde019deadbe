//! Which cells a mixture predicts, and which component each is most likely of.

use super::constants::{MIN_COVERAGE, OWN_SIGMA_SHARE, PREDICTED_SIGMAS};
use super::{NoveltyError, PreparedView};
use crate::mixture::linalg::Eigen;
use crate::mixture::{Gaussian, GaussianDensity, Mixture, sigmas_to_nearest};
use nalgebra::{Matrix3, Point3, Vector3};
use rayon::prelude::*;

const MIN_POINTS_PER_TASK: usize = 512;

/// Indices of the `points` that no component predicts to the noise of `prepared`. A component predicts what lies within
/// 2.5 of its own standard deviations, widened by 5 of the noise. `area_m2` is the surface that the mixture stands for.
///
/// # Errors
/// Coordinates that are not finite.
pub(super) fn unpredicted(
    mixture: &Mixture,
    points: &[Point3<f64>],
    area_m2: f64,
    prepared: &PreparedView,
) -> Result<Vec<usize>, NoveltyError> {
    let origin = &prepared.view.origin;
    let sigmas = sigmas_from(mixture, points, area_m2, prepared, |mean| {
        prepared.noise.sigma_m((mean - origin).norm()).powi(2)
    })?;
    Ok((0..points.len())
        .filter(|i| sigmas[*i] > PREDICTED_SIGMAS)
        .collect())
}

/// Distance of each point from the nearest component, in standard deviations of which [`PREDICTED_SIGMAS`] is the bound of
/// what it predicts; infinite beyond that. What scatters through a room is not predicted to its noise: a component that is
/// thicker than flat predicts no more than a flat one, and one that is hardly there nothing. `noise_m2` is the variance of
/// the points at a component's mean, `reference` the view that the mixture is of, `area_m2` the surface that it stands for.
///
/// # Errors
/// Coordinates that are not finite.
pub(super) fn sigmas_from(
    mixture: &Mixture,
    points: &[Point3<f64>],
    area_m2: f64,
    reference: &PreparedView,
    noise_m2: impl Fn(&Point3<f64>) -> f64,
) -> Result<Vec<f64>, NoveltyError> {
    let flat_m2 = reference.split_settings().flat_sigma_m.powi(2);
    let reaches = Mixture {
        weights: mixture
            .weights
            .iter()
            .zip(&mixture.components)
            .map(|(weight, g)| {
                if coverage(g, weight * area_m2) < MIN_COVERAGE {
                    0.0
                } else {
                    *weight
                }
            })
            .collect(),
        components: mixture
            .components
            .iter()
            .map(|g| reach(g, flat_m2, noise_m2(&g.mean)))
            .collect(),
    };
    Ok(sigmas_to_nearest(&reaches, points, 0.0, PREDICTED_SIGMAS)?)
}

/// The Gaussian of which [`PREDICTED_SIGMAS`] is the bound of what `g` predicts.
fn reach(g: &Gaussian, flat_m2: f64, noise_m2: f64) -> Gaussian {
    let axes = Eigen::new(&g.covariance);
    let across: Vector3<f64> = axes.vectors.column(0).into();
    let excess_m2 = (axes.values[0] - flat_m2).max(0.0);
    let own = g.covariance - across * across.transpose() * excess_m2;
    Gaussian {
        mean: g.mean,
        covariance: own * OWN_SIGMA_SHARE.powi(2) + Matrix3::from_diagonal_element(noise_m2),
    }
}

/// The surface of a component over the plate that it spans. A flat part of a wall has about 1.
pub(super) fn coverage(g: &Gaussian, area_m2: f64) -> f64 {
    let axes = Eigen::new(&g.covariance);
    // A uniform plate of side a has the variance a^2 / 12.
    let side_m = |axis: usize| (12.0 * axes.values[axis].max(0.0)).sqrt();
    area_m2 / (side_m(1) * side_m(2)).max(f64::MIN_POSITIVE)
}

/// The component that each point is most likely of; the first on ties. A mixture has one at least.
pub(super) fn most_likely_components(mixture: &Mixture, points: &[Point3<f64>]) -> Vec<u32> {
    let densities: Vec<(f64, GaussianDensity)> = mixture
        .components
        .iter()
        .zip(&mixture.weights)
        .map(|(g, weight)| {
            // A flat component has a density once it is a millimetre thick.
            let thick = Gaussian {
                mean: g.mean,
                covariance: g.covariance + Matrix3::from_diagonal_element(1e-6),
            };
            GaussianDensity::new(&thick).map(|density| (weight.ln(), density))
        })
        .map(|density| density.unwrap_or((f64::NEG_INFINITY, GaussianDensity::nowhere())))
        .collect();
    points
        .par_iter()
        .with_min_len(MIN_POINTS_PER_TASK)
        .map(|p| {
            let mut best = (f64::NEG_INFINITY, 0);
            for (k, (log_weight, density)) in densities.iter().enumerate() {
                let log = log_weight + density.log_at(p);
                if log > best.0 {
                    best = (log, k as u32);
                }
            }
            best.1
        })
        .collect()
}
