//! One Gaussian in three dimensions (theta_k of paper Eq. 4).

use crate::geometry::Pose;
use nalgebra::{Cholesky, Matrix3, Point3, Vector3};

/// Mean and covariance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gaussian {
    /// mu_k, metres.
    pub mean: Point3<f64>,
    /// Sigma_k, symmetric, positive semi-definite, square metres.
    pub covariance: Matrix3<f64>,
}

impl Gaussian {
    /// Mean and (population, 1/n) covariance of `points`; `None` for an empty set.
    pub fn from_points(points: &[Point3<f64>]) -> Option<Self> {
        let n = points.len() as f64;
        let first = points.first()?;
        let shift = points
            .iter()
            .fold(Vector3::zeros(), |sum, p| sum + (p - first))
            / n;
        let mean = first + shift;
        let covariance = points.iter().fold(Matrix3::zeros(), |sum, p| {
            let d = p - mean;
            sum + d * d.transpose()
        }) / n;
        Some(Self { mean, covariance })
    }

    /// The same with one weight per point, and the sum of the weights; `None` if that is zero.
    pub fn from_weighted_points<'a>(
        points: impl Iterator<Item = (&'a Point3<f64>, f64)> + Clone,
    ) -> Option<(Self, f64)> {
        let first = points.clone().find(|(_, w)| *w > 0.0)?.0;
        let (mut total, mut shift) = (0.0, Vector3::zeros());
        for (p, w) in points.clone() {
            total += w;
            shift += (p - first) * w;
        }
        let mean = first + shift / total;
        let covariance = points.fold(Matrix3::zeros(), |sum, (p, w)| {
            let d = p - mean;
            sum + d * d.transpose() * w
        }) / total;
        Some((Self { mean, covariance }, total))
    }
}

impl Gaussian {
    /// The same in another frame.
    pub fn transformed(&self, other_from_this: &Pose) -> Self {
        let rotation = other_from_this.rotation.to_rotation_matrix().into_inner();
        Self {
            mean: other_from_this * self.mean,
            covariance: rotation * self.covariance * rotation.transpose(),
        }
    }
}

/// A Gaussian prepared for evaluation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct GaussianDensity {
    mean: Point3<f64>,
    /// Inverse of the lower Cholesky factor: `whitening * (x - mean)` is standard normal.
    whitening: Matrix3<f64>,
    /// -(3/2) ln 2 pi - (1/2) ln det Sigma.
    log_peak: f64,
}

impl GaussianDensity {
    /// `None` if the covariance is not positive definite.
    pub(crate) fn new(gaussian: &Gaussian) -> Option<Self> {
        let lower = Cholesky::new(gaussian.covariance)?.unpack();
        let log_root_det: f64 = (0..3).map(|i| lower[(i, i)].ln()).sum();
        let whitening = lower.solve_lower_triangular(&Matrix3::identity())?;
        let log_peak = -1.5 * (2.0 * std::f64::consts::PI).ln() - log_root_det;
        let sound = log_peak.is_finite() && whitening.iter().all(|w| w.is_finite());
        sound.then_some(Self {
            mean: gaussian.mean,
            whitening,
            log_peak,
        })
    }

    /// A density that is zero everywhere.
    pub(crate) fn nowhere() -> Self {
        Self {
            mean: Point3::origin(),
            whitening: Matrix3::zeros(),
            log_peak: f64::NEG_INFINITY,
        }
    }

    /// ln g(x), natural logarithm of a density per cubic metre.
    pub(crate) fn log_at(&self, x: &Point3<f64>) -> f64 {
        self.log_peak - 0.5 * self.mahalanobis_squared(x)
    }

    /// Squared Mahalanobis distance of `x` from the mean.
    pub(super) fn mahalanobis_squared(&self, x: &Point3<f64>) -> f64 {
        (self.whitening * (x - self.mean)).norm_squared()
    }

    /// Inverse of the lower Cholesky factor of the covariance.
    pub(super) fn whitening(&self) -> &Matrix3<f64> {
        &self.whitening
    }

    /// ln of the density at the mean.
    pub(super) fn log_peak(&self) -> f64 {
        self.log_peak
    }
}

#[cfg(test)]
mod tests {
    use super::{Gaussian, GaussianDensity};
    use nalgebra::{Matrix3, Point3, Vector3};

    #[test]
    fn moments_of_two_points_far_from_the_origin() {
        let a = Point3::new(1e6, 0.0, 0.0);
        let b = Point3::new(1e6 + 2.0, 0.0, 4.0);
        let g = Gaussian::from_points(&[a, b]).expect("two points");
        assert_eq!(g.mean, Point3::new(1e6 + 1.0, 0.0, 2.0));
        assert_eq!(g.covariance[(0, 0)], 1.0);
        assert_eq!(g.covariance[(0, 2)], 2.0);
        assert_eq!(g.covariance[(2, 2)], 4.0);
        assert!(Gaussian::from_points(&[]).is_none());
    }

    #[test]
    fn weighted_moments_are_those_of_repeated_points() {
        let a = Point3::new(1.0, 2.0, 3.0);
        let b = Point3::new(-1.0, 0.5, 4.0);
        let (weighted, total) =
            Gaussian::from_weighted_points([(&a, 2.0), (&b, 1.0)].into_iter()).expect("mass");
        let plain = Gaussian::from_points(&[a, a, b]).expect("points");
        assert_eq!(total, 3.0);
        assert!((weighted.mean - plain.mean).norm() < 1e-15);
        assert!((weighted.covariance - plain.covariance).amax() < 1e-15);
    }

    #[test]
    fn density_of_the_standard_normal_and_of_a_plate() {
        let g = Gaussian {
            mean: Point3::new(1.0, 2.0, 3.0),
            covariance: Matrix3::from_diagonal(&Vector3::new(4.0, 9.0, 0.25)),
        };
        // -(3/2) ln 2 pi - ln(2 * 3 * 0.5) - (1 + 1 + 4) / 2
        let expected = -2.756_815_599_614_018 - 3f64.ln() - 3.0;
        let density = GaussianDensity::new(&g).expect("definite");
        let got = density.log_at(&Point3::new(3.0, 5.0, 4.0));
        assert!((got - expected).abs() < 1e-14);
        let plate = Gaussian {
            covariance: Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 0.0)),
            ..g
        };
        assert!(GaussianDensity::new(&plate).is_none());
    }
}
