//! How many components a cloud asks for.

use super::{Fit, MixtureError};

/// Free numbers of a mixture of `components` full Gaussians: three of the mean, six of the covariance,
/// one weight each, less one for the sum.
pub fn free_parameters(components: usize) -> usize {
    (10 * components).saturating_sub(1)
}

/// Bayesian information criterion (Schwarz 1978) of a fit to `points` independent points; less is better.
pub fn bic(fit: &Fit, points: f64) -> f64 {
    free_parameters(fit.mixture.len()) as f64 * points.ln() - 2.0 * points * fit.mean_log_likelihood
}

/// The fit of least [`bic`] among 1 to `max` components, the smaller on ties; numbers of components
/// that exceed the distinct points are not tried.
///
/// # Errors
/// Whatever `fit` gives for one component, and any error of it other than too few points.
pub fn least_bic(
    max: usize,
    points: f64,
    mut fit: impl FnMut(usize) -> Result<Fit, MixtureError>,
) -> Result<Fit, MixtureError> {
    if max == 0 {
        return Err(MixtureError::NoComponents);
    }
    let mut best = fit(1)?;
    let mut runs = best.runs;
    for components in 2..=max {
        match fit(components) {
            Ok(candidate) => {
                runs += candidate.runs;
                if bic(&candidate, points) < bic(&best, points) {
                    best = candidate;
                }
            }
            Err(MixtureError::TooFewPoints { .. }) => break,
            Err(other) => return Err(other),
        }
    }
    Ok(Fit { runs, ..best })
}
