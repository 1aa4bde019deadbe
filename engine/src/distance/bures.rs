//! Wasserstein-2 between Gaussians: by a closed form where it is accurate, by a polar decomposition elsewhere.

use super::constants::{CLOSED_FORM_MAX_ERROR, CLOSED_FORM_MIN_SHARE};
use crate::mixture::Gaussian;
use crate::mixture::linalg::{Eigen, OneSidedSvd};
use nalgebra::{Matrix3, Point3};

/// Newton steps of the closed form; it converges quadratically from above and needs some five.
const MAX_NEWTON_STEPS: usize = 30;

/// A Gaussian with what its distances to others need.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BuresGaussian {
    mean: Point3<f64>,
    covariance: Matrix3<f64>,
    root: Matrix3<f64>,
    adjugate: Matrix3<f64>,
    trace: f64,
    norm: f64,
    adjugate_norm: f64,
    root_determinant: f64,
}

impl BuresGaussian {
    pub(super) fn new(g: &Gaussian) -> Self {
        let eigen = Eigen::new(&g.covariance);
        let [a, b, c] = [0, 1, 2].map(|i| eigen.values[i].max(0.0));
        let minors = Eigen {
            values: [b * c, a * c, a * b].into(),
            ..eigen
        };
        let adjugate = minors.map(|l| l);
        Self {
            mean: g.mean,
            covariance: g.covariance,
            root: eigen.map(|l| l.max(0.0).sqrt()),
            adjugate,
            trace: a + b + c,
            norm: g.covariance.norm(),
            adjugate_norm: adjugate.norm(),
            root_determinant: a.sqrt() * b.sqrt() * c.sqrt(),
        }
    }

    /// Metres.
    pub(super) fn distance(&self, other: &Self) -> f64 {
        if self.mean == other.mean && self.covariance == other.covariance {
            return 0.0;
        }
        let apart = (self.mean - other.mean).norm_squared();
        let traces = self.trace + other.trace;
        if let Some(fidelity) = self.fidelity(other) {
            let squared = apart + (traces - 2.0 * fidelity);
            if squared > CLOSED_FORM_MIN_SHARE * traces {
                return squared.sqrt();
            }
        }
        (apart + self.shape_squared(other)).sqrt()
    }

    /// `|A - B U|_F^2` with A, B the square roots of the covariances and U the polar factor of B A (Bhatia, Jain and Lim
    /// 2019). No cancellation, and singular covariances are allowed.
    fn shape_squared(&self, other: &Self) -> f64 {
        let polar = OneSidedSvd::new(&(other.root * self.root)).polar();
        (self.root - other.root * polar).norm_squared()
    }

    /// t = tr (A S_b A)^1/2, from the three invariants of A S_b A with the eigenvalues s_i^2: I1 = tr S_a S_b,
    /// I2 = tr adj S_a adj S_b and p = s1 s2 s3. As t^2 = I1 + 2 (s1 s2 + s1 s3 + s2 s3) and the bracket's square is
    /// I2 + 2 p t, t is the only root of a convex function, found by Newton steps from above. `None` where rounding of I1
    /// or I2 is too large.
    fn fidelity(&self, other: &Self) -> Option<f64> {
        let first = self.covariance.dot(&other.covariance);
        let second = self.adjugate.dot(&other.adjugate).max(0.0);
        let third = self.root_determinant * other.root_determinant;
        if first <= 0.0 {
            return None;
        }
        let mut t = (3.0 * first).sqrt();
        let mut pairs = 0.0;
        for _ in 0..MAX_NEWTON_STEPS {
            pairs = (second + 2.0 * third * t).sqrt();
            if pairs <= 0.0 {
                return None;
            }
            let step = (t * t - first - 2.0 * pairs) / (2.0 * (t - third / pairs));
            t -= step;
            if step.abs() <= 4.0 * f64::EPSILON * t {
                break;
            }
        }
        let lost = self.norm * other.norm + self.adjugate_norm * other.adjugate_norm / pairs;
        (4.0 * f64::EPSILON * lost <= CLOSED_FORM_MAX_ERROR * t * t).then_some(t)
    }
}

#[cfg(test)]
mod tests {
    use super::BuresGaussian;
    use crate::mixture::Gaussian;
    use nalgebra::{Matrix3, Point3};
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]
        #[test]
        fn closed_form_and_polar_form_agree(a in proptest::array::uniform9(-1.0..1.0f64), b in proptest::array::uniform9(-1.0..1.0f64), thin in prop_oneof![Just(0.0), Just(1e-6), Just(1e-3), Just(0.1), Just(1.0)]) {
            let of = |m: &[f64; 9]| {
                let mut root = Matrix3::from_row_slice(m);
                root.column_mut(0).scale_mut(thin);
                BuresGaussian::new(&Gaussian { mean: Point3::origin(), covariance: root * root.transpose() })
            };
            let (a, b) = (of(&a), of(&b));
            if let Some(t) = a.fidelity(&b) {
                let traces = a.trace + b.trace;
                prop_assert!((traces - 2.0 * t - a.shape_squared(&b)).abs() < 1e-12 * traces);
            }
        }
    }
}
