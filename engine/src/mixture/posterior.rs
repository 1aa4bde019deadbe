//! Which component a point is of: the posterior of paper Eq. 8 and 9.

use super::gaussian::GaussianDensity;
use super::{Mixture, MixtureError};
use nalgebra::Point3;

/// A mixture prepared for P(k | x) = p_k g(x; mu_k, Sigma_k) / f(x) (paper Eq. 8).
#[derive(Debug, Clone, PartialEq)]
pub struct Posterior {
    /// ln p_k and the density; `None` for a component without weight.
    components: Vec<Option<(f64, GaussianDensity)>>,
}

impl Posterior {
    /// Prepares a mixture.
    ///
    /// # Errors
    /// [`MixtureError::NoComponents`] where none has weight; [`MixtureError::Singular`] if one with weight has no density.
    pub fn new(mixture: &Mixture) -> Result<Self, MixtureError> {
        let parts = mixture.weights.iter().zip(&mixture.components).enumerate();
        let prepared = parts.map(|(component, (&weight, gaussian))| {
            if weight <= 0.0 {
                return Ok(None);
            }
            let density =
                GaussianDensity::new(gaussian).ok_or(MixtureError::Singular { component })?;
            Ok(Some((weight.ln(), density)))
        });
        let components = prepared.collect::<Result<Vec<_>, _>>()?;
        if components.iter().all(Option::is_none) {
            return Err(MixtureError::NoComponents);
        }
        Ok(Self { components })
    }

    /// P(k | x) of every component: from 0 to 1, summing to one (paper Eq. 9). However far `x` is from all components, since
    /// only ratios of densities enter.
    ///
    /// # Errors
    /// [`MixtureError::LogLikelihoodUnderflow`] where even their logarithms overflow, or `x` is not finite.
    pub fn at(&self, x: &Point3<f64>) -> Result<Vec<f64>, MixtureError> {
        let logs: Vec<f64> = self.log_joints(x).collect();
        let best = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if !best.is_finite() {
            return Err(MixtureError::LogLikelihoodUnderflow);
        }
        let odds: Vec<f64> = logs.iter().map(|l| (l - best).exp()).collect();
        let total: f64 = odds.iter().sum();
        Ok(odds.into_iter().map(|o| o / total).collect())
    }

    /// The component of the greatest posterior, the first of equal ones.
    pub fn most_probable(&self, x: &Point3<f64>) -> usize {
        let logs = self.log_joints(x).enumerate();
        let best = logs.fold((0, f64::NEG_INFINITY), |best, (k, log)| {
            if log > best.1 { (k, log) } else { best }
        });
        best.0
    }

    /// ln p_k g(x; mu_k, Sigma_k) of every component.
    fn log_joints<'a>(&'a self, x: &'a Point3<f64>) -> impl Iterator<Item = f64> + 'a {
        self.components.iter().map(move |component| {
            let joint = component.as_ref();
            joint.map_or(f64::NEG_INFINITY, |(log_weight, density)| {
                log_weight + density.log_at(x)
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Posterior;
    use crate::mixture::{Gaussian, Mixture, MixtureError};
    use nalgebra::{Matrix3, Point3};
    use proptest::prelude::*;

    fn ball(x: f64, sigma: f64) -> Gaussian {
        Gaussian {
            mean: Point3::new(x, 0.0, 0.0),
            covariance: Matrix3::identity() * (sigma * sigma),
        }
    }

    fn mixture(parts: &[(f64, Gaussian)]) -> Mixture {
        let (weights, components) = parts.iter().copied().unzip();
        Mixture::from_masses(weights, components).expect("sound")
    }

    #[test]
    fn worked_by_hand() {
        let at = |m: &Mixture, x: f64| {
            let prepared = Posterior::new(m).expect("densities");
            let p = prepared.at(&Point3::new(x, 0.0, 0.0)).expect("finite");
            let best = prepared.most_probable(&Point3::new(x, 0.0, 0.0));
            assert!(p.iter().all(|other| *other <= p[best]));
            p
        };
        // Equal balls 2 m apart, weights 1/4 and 3/4. Half-way the densities are equal; at the first mean the second
        // density is e^-2 of the first: (1/4) / (1/4 + 3/4 e^-2) = 0.711235.
        let two = mixture(&[(0.25, ball(0.0, 1.0)), (0.75, ball(2.0, 1.0))]);
        assert!((at(&two, 1.0)[0] - 0.25).abs() < 1e-12);
        assert!((at(&two, 0.0)[0] - 0.711_234_594).abs() < 1e-9);
        // One inside the other, twice as wide: its density at the mean is an eighth. 3 m off it is
        // e^(-9/8 + 9/2) / 8 = 3.653 times the narrow one.
        let nested = mixture(&[(0.5, ball(0.0, 1.0)), (0.5, ball(0.0, 2.0))]);
        assert!((at(&nested, 0.0)[0] - 8.0 / 9.0).abs() < 1e-12);
        let ratio = (27.0f64 / 8.0).exp() / 8.0;
        assert!((at(&nested, 3.0)[1] - ratio / (1.0 + ratio)).abs() < 1e-12);
        // 1000 sigmas away, where every density is 0 in f64, the nearer one has it all.
        assert_eq!(at(&two, 1000.0), [0.0, 1.0]);
    }

    #[test]
    fn components_without_weight_have_none_and_those_without_density_are_refused() {
        let with_empty = Mixture {
            weights: vec![0.0, 1.0],
            components: vec![ball(0.0, 0.0), ball(1.0, 1.0)],
        };
        let prepared = Posterior::new(&with_empty).expect("a density");
        assert_eq!(prepared.at(&Point3::origin()), Ok(vec![0.0, 1.0]));
        let nan = Point3::new(f64::NAN, 0.0, 0.0);
        assert_eq!(prepared.at(&nan), Err(MixtureError::LogLikelihoodUnderflow));
        let flat = mixture(&[(1.0, ball(0.0, 0.0))]);
        let refused = MixtureError::Singular { component: 0 };
        assert_eq!(Posterior::new(&flat), Err(refused));
        let none = Posterior::new(&Mixture::default());
        assert_eq!(none, Err(MixtureError::NoComponents));
    }

    proptest! {
        #[test]
        fn it_keeps_eq_9_and_is_the_share_of_the_density(parts in proptest::collection::vec((0.01..1.0f64, -3.0..3.0f64, 0.2..2.0f64), 1..8), x in -5.0..5.0f64) {
            let parts: Vec<(f64, Gaussian)> = parts.into_iter().map(|(w, at, sigma)| (w, ball(at, sigma))).collect();
            let whole = mixture(&parts);
            let x = Point3::new(x, 0.3, -0.2);
            let posterior = Posterior::new(&whole).expect("densities").at(&x).expect("finite");
            prop_assert!((posterior.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            prop_assert!(posterior.iter().all(|p| (0.0..=1.0).contains(p)));
            for (k, p) in posterior.iter().enumerate() {
                let alone = mixture(&[(1.0, whole.components[k])]).log_density(&x).expect("a density");
                let share = whole.weights[k] * (alone - whole.log_density(&x).expect("a density")).exp();
                prop_assert!((p - share).abs() < 1e-12);
            }
        }
    }
}
