//! Which cells a mixture predicts, and which component each is most likely of.

use super::constants::{MIN_COVERAGE, OWN_SIGMAS, PREDICTED_SIGMAS};
use super::{NoveltyError, PreparedView};
use crate::mixture::linalg::Eigen;
use crate::mixture::{Gaussian, GaussianDensity, Mixture, sigmas_to_nearest};
use nalgebra::{Matrix3, Point3, Vector3};
use rayon::prelude::*;

const MIN_POINTS_PER_TASK: usize = 512;

/// Indices of the `points` that no component predicts to the noise of `prepared`: what lies within 2.5 of a component's own
/// standard deviations, widened by 5 of the noise. `area_m2` is the surface that the mixture stands for.
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
    let noise_m2 = |mean: &Point3<f64>, _: &Vector3<f64>| {
        let noise_m = prepared.noise.sigma_m((mean - origin).norm());
        Matrix3::from_diagonal_element(noise_m.powi(2))
    };
    let flat_sigma_m = prepared.split_settings().flat_sigma_m;
    let predicted = Prediction {
        mixture,
        area_m2,
        flat_sigma_m,
        bound_sigmas: PREDICTED_SIGMAS,
    }
    .of_points(points, noise_m2)?;
    Ok((0..points.len()).filter(|i| !predicted[*i]).collect())
}

/// What a mixture predicts: what lies within [`OWN_SIGMAS`] of a component's own standard deviations, widened by
/// `bound_sigmas` of the scatter of beams. What scatters through a room is not predicted to its noise: a component that is
/// thicker than flat predicts no more than a flat one, and one that is hardly there nothing.
pub(super) struct Prediction<'a> {
    pub mixture: &'a Mixture,
    /// Surface that the mixture stands for.
    pub area_m2: f64,
    /// Thickness of what counts as flat, one standard deviation.
    pub flat_sigma_m: f64,
    pub bound_sigmas: f64,
}

impl Prediction<'_> {
    /// Whether each of `points` is predicted. `scatter_m2` is the covariance of beams at a component's mean, given with its
    /// normal.
    ///
    /// # Errors
    /// Coordinates that are not finite.
    pub(super) fn of_points(
        &self,
        points: &[Point3<f64>],
        scatter_m2: impl Fn(&Point3<f64>, &Vector3<f64>) -> Matrix3<f64>,
    ) -> Result<Vec<bool>, NoveltyError> {
        let weighted = self.mixture.weights.iter().zip(&self.mixture.components);
        let weights = weighted.map(|(weight, g)| {
            if coverage(g, weight * self.area_m2) < MIN_COVERAGE {
                0.0
            } else {
                *weight
            }
        });
        let components = self.mixture.components.iter();
        let reaches = Mixture {
            weights: weights.collect(),
            components: components.map(|g| self.reach(g, &scatter_m2)).collect(),
        };
        let sigmas = sigmas_to_nearest(&reaches, points, 0.0, self.bound_sigmas)?;
        Ok(sigmas.into_iter().map(|s| s <= self.bound_sigmas).collect())
    }

    /// The Gaussian of which `bound_sigmas` is the bound of what `g` predicts.
    fn reach(
        &self,
        g: &Gaussian,
        scatter_m2: impl Fn(&Point3<f64>, &Vector3<f64>) -> Matrix3<f64>,
    ) -> Gaussian {
        let axes = Eigen::new(&g.covariance);
        let across: Vector3<f64> = axes.vectors.column(0).into();
        let excess_m2 = (axes.values[0] - self.flat_sigma_m.powi(2)).max(0.0);
        let own = g.covariance - across * across.transpose() * excess_m2;
        Gaussian {
            mean: g.mean,
            covariance: own * (OWN_SIGMAS / self.bound_sigmas).powi(2)
                + scatter_m2(&g.mean, &across),
        }
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
