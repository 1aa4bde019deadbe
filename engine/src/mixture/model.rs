//! The Gaussian mixture (Theta of paper Eq. 3) and its invariant.

use super::constants::{SEMI_DEFINITE_TOLERANCE, WEIGHT_SUM_TOLERANCE};
use super::gaussian::GaussianDensity;
use super::linalg::Eigen;
use super::{Gaussian, MixtureError};
use nalgebra::{Matrix3, Point3, Vector3};

/// A Gaussian mixture: `weights[k]` belongs to `components[k]`.
///
/// Invariant (paper Eq. 2): every weight is finite and not negative, and they sum to one within rounding. An empty mixture
/// has neither weights nor components.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mixture {
    /// Mixing probabilities p_k.
    pub weights: Vec<f64>,
    /// The components theta_k.
    pub components: Vec<Gaussian>,
}

impl Mixture {
    /// Checks the invariant; weights whose sum is off by at most 1e-6 are scaled.
    ///
    /// # Errors
    /// Lengths that differ, entries that are not finite, negative weights, a sum that is not one,
    /// covariances that are not symmetric positive semi-definite.
    pub fn try_new(weights: Vec<f64>, components: Vec<Gaussian>) -> Result<Self, MixtureError> {
        if weights.len() != components.len() {
            return Err(MixtureError::LengthsDiffer {
                array: "components",
                got: components.len(),
                like: "weights",
                expected: weights.len(),
            });
        }
        let mut mixture = Self {
            weights,
            components,
        };
        if !mixture.is_empty() {
            let sum = mixture.checked_sum()?;
            if sum.is_nan() || (sum - 1.0).abs() > WEIGHT_SUM_TOLERANCE {
                return Err(MixtureError::WeightSum {
                    got: sum,
                    slack: WEIGHT_SUM_TOLERANCE,
                });
            }
            mixture.weights.iter_mut().for_each(|w| *w /= sum);
        }
        for (component, gaussian) in mixture.components.iter().enumerate() {
            check(component, gaussian)?;
        }
        Ok(mixture)
    }

    /// A mixture from masses, which are scaled to sum to one.
    ///
    /// # Errors
    /// As [`Mixture::try_new`], but the sum may be any finite number above zero.
    pub fn from_masses(masses: Vec<f64>, components: Vec<Gaussian>) -> Result<Self, MixtureError> {
        let mut mixture = Self {
            weights: masses,
            components,
        };
        let sum = mixture.checked_sum()?;
        if !mixture.weights.is_empty() && (sum <= 0.0 || !sum.is_finite()) {
            return Err(MixtureError::WeightSum {
                got: sum,
                slack: WEIGHT_SUM_TOLERANCE,
            });
        }
        mixture.weights.iter_mut().for_each(|w| *w /= sum);
        Self::try_new(mixture.weights, mixture.components)
    }

    fn checked_sum(&self) -> Result<f64, MixtureError> {
        for (component, &got) in self.weights.iter().enumerate() {
            if !got.is_finite() || got < 0.0 {
                return Err(MixtureError::BadWeight { component, got });
            }
        }
        Ok(self.weights.iter().sum())
    }

    /// Number of components K.
    pub fn len(&self) -> usize {
        self.components.len()
    }

    /// Whether there is no component.
    pub fn is_empty(&self) -> bool {
        self.components.is_empty()
    }

    /// Mean and covariance of the whole distribution; `None` without mass.
    pub fn total_moments(&self) -> Option<Gaussian> {
        let total: f64 = self.weights.iter().sum();
        let first = self.components.first()?.mean;
        if total <= 0.0 || !total.is_finite() {
            return None;
        }
        let pairs = || self.weights.iter().zip(&self.components);
        let shift = pairs().fold(Vector3::zeros(), |sum, (w, g)| sum + (g.mean - first) * *w);
        let mean = first + shift / total;
        let covariance = pairs().fold(Matrix3::zeros(), |sum, (w, g)| {
            let d = g.mean - mean;
            sum + (g.covariance + d * d.transpose()) * *w
        }) / total;
        Some(Gaussian { mean, covariance })
    }

    /// ln f(x, Theta) of paper Eq. 1, by log-sum-exp; minus infinity where it underflows.
    ///
    /// # Errors
    /// [`MixtureError::Singular`] if a component with weight has no density.
    pub fn log_density(&self, x: &Point3<f64>) -> Result<f64, MixtureError> {
        let mut logs = Vec::with_capacity(self.len());
        for (component, (&w, g)) in self.weights.iter().zip(&self.components).enumerate() {
            if w > 0.0 {
                let density =
                    GaussianDensity::new(g).ok_or(MixtureError::Singular { component })?;
                logs.push(w.ln() + density.log_at(x));
            }
        }
        let best = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if best == f64::NEG_INFINITY {
            return Ok(best);
        }
        Ok(best + logs.iter().map(|l| (l - best).exp()).sum::<f64>().ln())
    }
}

fn check(component: usize, gaussian: &Gaussian) -> Result<(), MixtureError> {
    if !gaussian.mean.iter().all(|v| v.is_finite()) {
        return Err(MixtureError::NotFinite {
            what: "mean",
            component,
        });
    }
    let c = &gaussian.covariance;
    if !c.iter().all(|v| v.is_finite()) {
        return Err(MixtureError::NotFinite {
            what: "covariance",
            component,
        });
    }
    let values = Eigen::new(c).values;
    let tolerance = SEMI_DEFINITE_TOLERANCE * values[2].abs();
    if values[0] < -tolerance || (c - c.transpose()).amax() > tolerance {
        return Err(MixtureError::NotSemiDefinite {
            component,
            smallest: values[0],
            largest: values[2],
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::Mixture;
    use crate::mixture::{Gaussian, MixtureError};
    use nalgebra::{Matrix3, Point3};

    fn ball(x: f64) -> Gaussian {
        Gaussian {
            mean: Point3::new(x, 0.0, 0.0),
            covariance: Matrix3::identity() * 0.25,
        }
    }

    #[test]
    fn the_invariant_is_checked() {
        let ok =
            Mixture::try_new(vec![0.3, 0.7 + 5e-7], vec![ball(0.0), ball(1.0)]).expect("close");
        assert!((ok.weights.iter().sum::<f64>() - 1.0).abs() < 1e-15);
        assert!(
            Mixture::try_new(vec![], vec![])
                .expect("empty is fine")
                .is_empty()
        );
        let err = |w: Vec<f64>, c: Vec<Gaussian>| Mixture::try_new(w, c).expect_err("refused");
        assert!(matches!(
            err(vec![1.0], vec![]),
            MixtureError::LengthsDiffer { .. }
        ));
        assert!(matches!(
            err(vec![0.4, 0.7], vec![ball(0.0); 2]),
            MixtureError::WeightSum { .. }
        ));
        assert!(matches!(
            err(vec![-0.5, 1.5], vec![ball(0.0); 2]),
            MixtureError::BadWeight { component: 0, .. }
        ));
        assert!(matches!(
            err(vec![f64::NAN], vec![ball(0.0)]),
            MixtureError::BadWeight { .. }
        ));
        assert!(matches!(
            err(vec![1.0], vec![ball(f64::NAN)]),
            MixtureError::NotFinite { .. }
        ));
        let mut bent = ball(0.0);
        bent.covariance[(0, 1)] = 1.0;
        assert!(matches!(
            err(vec![1.0], vec![bent]),
            MixtureError::NotSemiDefinite { .. }
        ));
        let plate = Gaussian {
            covariance: Matrix3::from_diagonal(&nalgebra::Vector3::new(1.0, 1.0, 0.0)),
            ..ball(0.0)
        };
        assert!(Mixture::try_new(vec![1.0], vec![plate]).is_ok());
    }

    #[test]
    fn total_moments_follow_the_law_of_total_variance() {
        let m = Mixture::from_masses(vec![1.0, 3.0], vec![ball(0.0), ball(4.0)]).expect("sound");
        let total = m.total_moments().expect("mass");
        assert_eq!(total.mean, Point3::new(3.0, 0.0, 0.0));
        assert_eq!(total.covariance[(0, 0)], 0.25 + 3.0);
        assert_eq!(total.covariance[(1, 1)], 0.25);
        assert!(Mixture::default().total_moments().is_none());
    }
}
