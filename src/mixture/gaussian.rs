//! One Gaussian density in three dimensions (theta_k of Eq. 4).

use nalgebra::{Matrix3, Point3, Vector3};

/// Mean and covariance of one component.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gaussian {
    /// mu_k, metres.
    pub mean: Point3<f64>,
    /// Sigma_k, symmetric, positive semi-definite, square metres.
    pub covariance: Matrix3<f64>,
}

impl Gaussian {
    /// Mean and (population, 1/n) covariance of `points`; `None` for an empty set.
    pub fn of_points(points: &[Point3<f64>]) -> Option<Self> {
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
}

#[cfg(test)]
mod tests {
    use super::Gaussian;
    use nalgebra::Point3;

    #[test]
    fn moments_of_two_points_far_from_the_origin() {
        let a = Point3::new(1e6, 0.0, 0.0);
        let b = Point3::new(1e6 + 2.0, 0.0, 4.0);
        let g = Gaussian::of_points(&[a, b]).expect("two points");
        assert_eq!(g.mean, Point3::new(1e6 + 1.0, 0.0, 2.0));
        assert_eq!(g.covariance[(0, 0)], 1.0);
        assert_eq!(g.covariance[(0, 2)], 2.0);
        assert_eq!(g.covariance[(2, 2)], 4.0);
        assert!(Gaussian::of_points(&[]).is_none());
    }
}
