//! Refits a mixture to new points: its components are frozen, only their weights are free, and new components are added only
//! where points are unexplained. Two independent fits of one place end in different local optima; a refit does not
//! (`docs/novelty.md section 3`).

use super::constants::{REFIT_MAX_ITERATIONS, REGULARISATION_M2, UNEXPLAINED_SIGMAS};
use super::em::run_frozen;
use super::instructions::{InstructionSet, SimdKernel};
use super::point_blocks::{BLOCK_SIZE, PointBlocks};
use super::prepared_component::{ComponentBounds, PreparedComponent};
use super::split::{SplitSettings, split_until_flat};
use super::{EmSettings, Gaussian, Mixture, MixtureError};
use nalgebra::{Matrix3, Point3};
use std::f64::consts::LOG2_E;

/// Which points the reference mixture does not explain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Unexplained<'a> {
    /// Those beyond a Mahalanobis distance from every component that has weight.
    Beyond {
        /// Mahalanobis distance.
        sigmas: f64,
        /// Variance of the noise of the points, added to every component, square metres.
        noise_m2: f64,
    },
    /// Those with these indices.
    Listed(&'a [usize]),
}

impl Default for Unexplained<'_> {
    fn default() -> Self {
        Self::Beyond {
            sigmas: UNEXPLAINED_SIGMAS,
            noise_m2: REGULARISATION_M2,
        }
    }
}

/// Settings of a refit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RefitSettings {
    /// How unexplained points are split into new components.
    pub split: SplitSettings,
    /// EM of the weights and the new components.
    pub em: EmSettings,
}

impl Default for RefitSettings {
    fn default() -> Self {
        Self {
            split: SplitSettings::default(),
            em: EmSettings {
                iterations: REFIT_MAX_ITERATIONS,
                ..EmSettings::default()
            },
        }
    }
}

/// Result of a refit.
#[derive(Debug, Clone, PartialEq)]
pub struct Refit {
    /// The reference's components in their order, then the new ones.
    pub mixture: Mixture,
    /// Number of the reference's components.
    pub frozen: usize,
    /// Indices of the unexplained points, ascending.
    pub unexplained: Vec<usize>,
    /// Weighted mean over the points of ln f, nats.
    pub mean_log_likelihood: f64,
}

/// Refits `reference` to `points` (metres; `weights` 1 if absent).
///
/// # Errors
/// As [`super::em::run`]; an index in [`Unexplained::Listed`] out of range.
pub fn refit(
    reference: &Mixture,
    points: &[Point3<f64>],
    weights: Option<&[f64]>,
    unexplained: Unexplained<'_>,
    settings: &RefitSettings,
) -> Result<Refit, MixtureError> {
    let unexplained = match unexplained {
        Unexplained::Listed(listed) => sorted_indices(listed, points.len())?,
        Unexplained::Beyond { sigmas, noise_m2 } => {
            let distances = sigmas_to_nearest(reference, points, noise_m2, sigmas)?;
            (0..points.len())
                .filter(|&i| distances[i] > sigmas)
                .collect()
        }
    };
    let weight = |i: usize| weights.and_then(|w| w.get(i).copied()).unwrap_or(1.0);
    let total: f64 = (0..points.len()).map(weight).sum();
    let new_mass: f64 = unexplained.iter().map(|&i| weight(i)).sum();
    let mut masses: Vec<f64> = reference
        .weights
        .iter()
        .map(|w| w * (total - new_mass))
        .collect();
    // A component without weight could never gain any: every one gets a point's share at least.
    let min_mass = total / points.len().max(1) as f64;
    masses.iter_mut().for_each(|m| *m = m.max(min_mass));
    let mut components = reference.components.clone();
    if new_mass > 0.0 {
        let new_points: Vec<Point3<f64>> = unexplained.iter().map(|&i| points[i]).collect();
        let new_weights: Vec<f64> = unexplained.iter().map(|&i| weight(i)).collect();
        let new = split_until_flat(&new_points, Some(&new_weights), &settings.split)?;
        masses.extend(new.weights.iter().map(|w| w * new_mass));
        components.extend(new.components);
    }
    let start = Mixture {
        weights: masses,
        components,
    };
    let fit = run_frozen(points, weights, start, reference.len(), &settings.em)?;
    let mut mixture = fit.mixture;
    // Exactly: centring for the fit moved the means by rounding.
    mixture.components[..reference.len()].copy_from_slice(&reference.components);
    Ok(Refit {
        mixture,
        frozen: reference.len(),
        unexplained,
        mean_log_likelihood: fit.mean_log_likelihood,
    })
}

fn sorted_indices(listed: &[usize], len: usize) -> Result<Vec<usize>, MixtureError> {
    let mut indices = listed.to_vec();
    indices.sort_unstable();
    indices.dedup();
    match indices.last() {
        Some(&index) if index >= len => Err(MixtureError::NoSuchPoint { index, len }),
        _ => Ok(indices),
    }
}

/// Least Mahalanobis distance of every point from the components of `mixture` that have weight, each widened by `noise_m2`.
/// Infinite beyond `cap`, so that far components are not visited.
///
/// # Errors
/// Coordinates that are not finite; a component without volume if `noise_m2` is 0.
pub(crate) fn sigmas_to_nearest(
    mixture: &Mixture,
    points: &[Point3<f64>],
    noise_m2: f64,
    cap: f64,
) -> Result<Vec<f64>, MixtureError> {
    let mut nearest = vec![f64::INFINITY; points.len()];
    if points.is_empty() {
        return Ok(nearest);
    }
    let point_blocks = PointBlocks::new(points, None, false)?;
    let mut prepared = Vec::with_capacity(mixture.len());
    for (component, (&weight, g)) in mixture.weights.iter().zip(&mixture.components).enumerate() {
        if weight > 0.0 {
            let wide = Gaussian {
                mean: g.mean - point_blocks.centre,
                covariance: g.covariance + Matrix3::from_diagonal_element(noise_m2),
            };
            prepared.push(
                PreparedComponent::new(weight, &wide)
                    .ok_or(MixtureError::Singular { component })?,
            );
        }
    }
    let mut bounds = ComponentBounds::default();
    bounds.set(&prepared);
    InstructionSet::best().run(NearestComponents {
        prepared: &prepared,
        bounds: &bounds,
        point_blocks: &point_blocks,
        cap,
        nearest: &mut nearest,
    });
    Ok(nearest)
}

/// The loop of [`sigmas_to_nearest`].
struct NearestComponents<'a> {
    prepared: &'a [PreparedComponent],
    bounds: &'a ComponentBounds,
    point_blocks: &'a PointBlocks,
    cap: f64,
    nearest: &'a mut [f64],
}

impl SimdKernel for NearestComponents<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool, const LANES: usize>(self) {
        // ln of the density falls by half the squared distance, in nats.
        let bits = 0.5 * LOG2_E;
        let cap = self.cap * self.cap * bits;
        let mut upper_bounds = Vec::new();
        let mut distances = [0.0; BLOCK_SIZE];
        let indices = self.point_blocks.order.chunks(BLOCK_SIZE);
        for (block, indices) in self.point_blocks.blocks.iter().zip(indices) {
            self.bounds.upper_bounds::<FUSED>(block, &mut upper_bounds);
            let mut best = [f64::INFINITY; BLOCK_SIZE];
            for (component, upper_bound) in self.prepared.iter().zip(&upper_bounds) {
                if component.peak - upper_bound > cap {
                    continue;
                }
                component.half_mahalanobis_bits::<FUSED>(block, &mut distances);
                for (best, distance) in best.iter_mut().zip(&distances) {
                    *best = if *distance < *best { *distance } else { *best };
                }
            }
            for (&index, distance) in indices.iter().zip(best) {
                let sigmas = (distance / bits).sqrt();
                self.nearest[index as usize] = if sigmas > self.cap {
                    f64::INFINITY
                } else {
                    sigmas
                };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{RefitSettings, Unexplained, refit, sigmas_to_nearest};
    use crate::mixture::gaussian::GaussianDensity;
    use crate::mixture::split::{SplitSettings, split_until_flat};
    use crate::mixture::{Mixture, MixtureError};
    use nalgebra::{Point3, Vector3};

    /// A floor of 4 m by 3 m.
    fn floor() -> Vec<Point3<f64>> {
        (0..6000)
            .map(|i| {
                let t = f64::from(i);
                Point3::new(
                    t * 0.754_877 % 4.0,
                    t * 0.569_84 % 3.0,
                    0.01 * (t * 1.3).sin(),
                )
            })
            .collect()
    }

    fn reference() -> Mixture {
        split_until_flat(&floor(), None, &SplitSettings::default()).expect("splits")
    }

    #[test]
    fn the_same_cloud_needs_no_new_component() {
        let (reference, points) = (reference(), floor());
        let same = refit(
            &reference,
            &points,
            None,
            Unexplained::default(),
            &RefitSettings::default(),
        )
        .expect("fits");
        assert_eq!(
            (same.frozen, same.mixture.len()),
            (reference.len(), reference.len())
        );
        assert_eq!(same.mixture.components, reference.components);
        assert!(same.unexplained.is_empty());
        for (a, b) in same.mixture.weights.iter().zip(&reference.weights) {
            assert!((a - b).abs() < 0.03, "{a} {b}");
        }
    }

    #[test]
    fn an_object_above_the_floor_gets_components_of_its_own() {
        let (reference, mut points) = (reference(), floor());
        let centre = Point3::new(2.0, 1.5, 1.0);
        points.extend((0..300).map(|i| {
            let t = f64::from(i);
            centre + Vector3::new(t.sin(), (t * 1.7).cos(), (t * 0.3).sin()) * 0.15
        }));
        let found = refit(
            &reference,
            &points,
            None,
            Unexplained::default(),
            &RefitSettings::default(),
        )
        .expect("fits");
        assert_eq!(found.unexplained, (6000..6300).collect::<Vec<_>>());
        assert!(found.mixture.len() > reference.len());
        let new: f64 = found.mixture.weights[found.frozen..].iter().sum();
        assert!((new - 300.0 / 6300.0).abs() < 1e-6, "{new}");
        for g in &found.mixture.components[found.frozen..] {
            assert!((g.mean - centre).norm() < 0.3);
        }
        let listed: Vec<usize> = (6000..6300).rev().collect();
        let with_listed = refit(
            &reference,
            &points,
            None,
            Unexplained::Listed(&listed),
            &RefitSettings::default(),
        )
        .expect("fits");
        assert_eq!(with_listed, found);
        let err = refit(
            &reference,
            &points,
            None,
            Unexplained::Listed(&[6300]),
            &RefitSettings::default(),
        );
        assert_eq!(
            err,
            Err(MixtureError::NoSuchPoint {
                index: 6300,
                len: 6300
            })
        );
    }

    #[test]
    fn sigmas_equal_those_of_a_full_search() {
        let (reference, points) = (reference(), floor());
        let far: Vec<_> = points
            .iter()
            .step_by(7)
            .map(|p| p + Vector3::z() * 0.05 * p.x)
            .collect();
        let got = sigmas_to_nearest(&reference, &far, 0.0, 6.0).expect("volume");
        for (p, got) in far.iter().zip(got) {
            let full = reference
                .components
                .iter()
                .map(|g| {
                    GaussianDensity::new(g)
                        .expect("volume")
                        .mahalanobis_squared(p)
                        .sqrt()
                })
                .fold(f64::INFINITY, f64::min);
            assert!(if full > 6.0 {
                got.is_infinite()
            } else {
                (full - got).abs() < 1e-8
            });
        }
    }
}
