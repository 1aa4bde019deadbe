//! Number of components by the Bayesian information criterion (Schwarz 1978).

use super::{EmFit, MixtureError};

/// Free parameters of a mixture of `components` full Gaussians: three of the mean, six of the covariance, one weight each,
/// less one for the sum.
fn free_parameters(components: usize) -> usize {
    (10 * components).saturating_sub(1)
}

/// The criterion for a fit to `points` independent points; less is better.
fn bic(fit: &EmFit, points: f64) -> f64 {
    free_parameters(fit.mixture.len()) as f64 * points.ln() - 2.0 * points * fit.mean_log_likelihood
}

/// The fit of least [`bic`] among 1 to `max` components, the smaller on ties. Stops at the number of distinct points.
///
/// # Errors
/// Those of `fit`, except too few points for more than one component.
pub(super) fn least_bic(
    max: usize,
    points: f64,
    mut fit: impl FnMut(usize) -> Result<EmFit, MixtureError>,
) -> Result<EmFit, MixtureError> {
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
    Ok(EmFit { runs, ..best })
}
