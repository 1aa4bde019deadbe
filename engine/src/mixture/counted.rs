//! A mixture whose components know for how many beams and for how much surface they stand.

use super::constants::REGULARISATION_M2;
use super::linalg::Eigen;
use super::own_share::log_own_shares;
use super::{Gaussian, Mixture, MixtureError};

/// A mixture with beams and area: what [`fuse`](super::fuse) takes and gives.
///
/// Each component has two masses. Its weight is a share of the visible surface, its beams are what was measured of it. A
/// surface seen twice has twice the beams and the same area.
#[derive(Debug, Clone, PartialEq)]
pub struct CountedMixture {
    mixture: Mixture,
    beams: Vec<f64>,
    surface_m2: f64,
}

impl CountedMixture {
    /// `beams[k]` belongs to component k; `surface_m2` is the area of which the weights are shares. Without it the area is
    /// derived from the components: each is a plate ([`plate_area_m2`]) as far as it is the most of what is there (its mean
    /// posterior over the plate, paper Eq. 8), so that components that cover one another count once.
    ///
    /// # Errors
    /// [`MixtureError::NoComponents`]; beams of another number, not finite, negative, or zero where there is weight; an area
    /// that is not above zero and finite.
    pub fn try_new(
        mixture: Mixture,
        beams: Vec<f64>,
        surface_m2: Option<f64>,
    ) -> Result<Self, MixtureError> {
        if mixture.is_empty() {
            return Err(MixtureError::NoComponents);
        }
        if beams.len() != mixture.len() {
            return Err(MixtureError::LengthsDiffer {
                array: "beams",
                got: beams.len(),
                like: "weights",
                expected: mixture.len(),
            });
        }
        let bad = |(&n, &w): (&f64, &f64)| !n.is_finite() || n < 0.0 || (n == 0.0 && w > 0.0);
        if let Some(component) = beams.iter().zip(&mixture.weights).position(bad) {
            return Err(MixtureError::BadBeams {
                component,
                got: beams[component],
            });
        }
        let surface_m2 = surface_m2.unwrap_or_else(|| derived_surface_m2(&mixture, &beams));
        if !(surface_m2.is_finite() && surface_m2 > 0.0) {
            return Err(MixtureError::BadSetting {
                name: "surface_m2",
                got: surface_m2,
                expected: "a finite number above 0",
            });
        }
        Ok(Self {
            mixture,
            beams,
            surface_m2,
        })
    }

    /// The same where only the total of the beams is known: each component has its weight's share of them.
    ///
    /// # Errors
    /// As [`CountedMixture::try_new`].
    pub fn with_total_beams(
        mixture: Mixture,
        total: f64,
        surface_m2: Option<f64>,
    ) -> Result<Self, MixtureError> {
        let beams = mixture.weights.iter().map(|w| w * total).collect();
        Self::try_new(mixture, beams, surface_m2)
    }

    /// The mixture; its weights are shares of [`CountedMixture::surface_m2`].
    pub fn mixture(&self) -> &Mixture {
        &self.mixture
    }

    /// Beams of each component.
    pub fn beams(&self) -> &[f64] {
        &self.beams
    }

    /// Area of the visible surface, square metres.
    pub fn surface_m2(&self) -> f64 {
        self.surface_m2
    }

    /// Mean and covariance of all beams: those of the mixture with the beams as weights. `None` without beams.
    pub fn beam_moments(&self) -> Option<Gaussian> {
        let by_beams = Mixture {
            weights: self.beams.clone(),
            components: self.mixture.components.clone(),
        };
        by_beams.total_moments()
    }
}

/// Area of the uniform plate with the two largest variances of the component, square metres: a plate of side a has the
/// variance a^2 / 12. Variances count as (1 mm)^2 at least.
pub(super) fn plate_area_m2(gaussian: &Gaussian) -> f64 {
    let values = Eigen::new(&gaussian.covariance).values;
    12.0 * (values[1].max(REGULARISATION_M2) * values[2].max(REGULARISATION_M2)).sqrt()
}

fn derived_surface_m2(mixture: &Mixture, beams: &[f64]) -> f64 {
    let counted: Vec<_> = (0..mixture.len()).filter(|&k| beams[k] > 0.0).collect();
    let components: Vec<Gaussian> = counted.iter().map(|&k| mixture.components[k]).collect();
    let beams: Vec<f64> = counted.iter().map(|&k| beams[k]).collect();
    let shares = log_own_shares(&components, &beams);
    let plates = components.iter().map(plate_area_m2);
    plates.zip(shares).map(|(area, own)| area * own.exp()).sum()
}

#[cfg(test)]
mod tests {
    use super::{CountedMixture, plate_area_m2};
    use crate::mixture::{Gaussian, Mixture, MixtureError};
    use nalgebra::{Matrix3, Point3, Vector3};

    /// A plate of 1.2 x 0.6 m and 2 cm thickness at x.
    fn plate(x: f64) -> Gaussian {
        let variances = Vector3::new(1.44 / 12.0, 0.36 / 12.0, 4e-4);
        Gaussian {
            mean: Point3::new(x, 0.0, 0.0),
            covariance: Matrix3::from_diagonal(&variances),
        }
    }

    fn mixture(parts: &[(f64, f64)]) -> Mixture {
        let weights = parts.iter().map(|p| p.0).collect();
        let components = parts.iter().map(|p| plate(p.1)).collect();
        Mixture::from_masses(weights, components).expect("sound")
    }

    #[test]
    fn the_area_of_plates_apart_is_their_sum_and_that_of_copies_is_one() {
        assert!((plate_area_m2(&plate(0.0)) - 0.72).abs() < 1e-12);
        let total = |parts: &[(f64, f64)]| {
            let counted = CountedMixture::with_total_beams(mixture(parts), 100.0, None);
            counted.expect("sound").surface_m2()
        };
        assert!((total(&[(1.0, 0.0), (3.0, 50.0)]) - 1.44).abs() < 1e-9);
        assert!((total(&[(1.0, 0.0), (3.0, 0.0)]) - 0.72).abs() < 1e-9);
    }

    #[test]
    fn what_is_no_count_is_refused() {
        let two = mixture(&[(1.0, 0.0), (1.0, 2.0)]);
        let refused = |beams: &[f64], area| {
            CountedMixture::try_new(two.clone(), beams.to_vec(), area).expect_err("refused")
        };
        assert!(matches!(
            refused(&[1.0], None),
            MixtureError::LengthsDiffer {
                array: "beams",
                got: 1,
                expected: 2,
                ..
            }
        ));
        for (bad, at) in [([5.0, 0.0], 1), ([-1.0, 5.0], 0), ([5.0, f64::NAN], 1)] {
            assert!(
                matches!(refused(&bad, None), MixtureError::BadBeams { component, .. } if component == at)
            );
        }
        for area in [0.0, -1.0, f64::INFINITY, f64::NAN] {
            assert!(matches!(
                refused(&[1.0, 1.0], Some(area)),
                MixtureError::BadSetting {
                    name: "surface_m2",
                    ..
                }
            ));
        }
        assert_eq!(
            CountedMixture::try_new(Mixture::default(), vec![], None),
            Err(MixtureError::NoComponents)
        );
    }
}
