//! Normal equations of any number of unknowns: the Levenberg-Marquardt step and covariances.

use super::constants::RIDGE_SHARE;
use nalgebra::{Cholesky, DMatrix, DVector};

/// The normal equations of weighted residuals.
#[derive(Debug, Clone)]
pub(super) struct DenseNormalEquations {
    matrix: DMatrix<f64>,
    right: DVector<f64>,
    /// Half the sum of weighted squares.
    pub(super) cost: f64,
}

impl DenseNormalEquations {
    pub(super) fn new(unknowns: usize) -> Self {
        Self {
            matrix: DMatrix::zeros(unknowns, unknowns),
            right: DVector::zeros(unknowns),
            cost: 0.0,
        }
    }

    /// Adds a residual with the derivatives `slopes` by the unknowns `at`, its weight and its cost.
    pub(super) fn add(
        &mut self,
        at: &[usize],
        slopes: &[f64],
        residual: f64,
        weight: f64,
        cost: f64,
    ) {
        for (i, slope) in at.iter().zip(slopes) {
            let weighted = weight * slope;
            self.right[*i] -= weighted * residual;
            for (j, other) in at.iter().zip(slopes) {
                if j <= i {
                    self.matrix[(*i, *j)] += weighted * other;
                }
            }
        }
        self.cost += cost;
    }

    /// The step with the diagonal increased by the share `damping`; `None` if the unknowns are not determined, which priors
    /// prevent.
    pub(super) fn step(&self, damping: f64) -> Option<DVector<f64>> {
        let mut matrix = self.symmetric();
        for i in 0..matrix.nrows() {
            matrix[(i, i)] *= 1.0 + damping;
        }
        Some(Cholesky::new(matrix)?.solve(&self.right))
    }

    /// Covariance of the unknowns.
    pub(super) fn covariance(&self) -> Option<DMatrix<f64>> {
        Some(Cholesky::new(self.symmetric())?.inverse())
    }

    /// The information matrix: the inverse of a covariance.
    pub(super) fn information(&self) -> DMatrix<f64> {
        self.symmetric()
    }

    /// First-order change of the solution when the residuals of `part` are left out. Unknowns that only `part` determines do
    /// not change.
    pub(super) fn change_without(&self, part: &Self) -> Option<DVector<f64>> {
        let mut matrix = self.symmetric() - part.symmetric();
        for i in 0..matrix.nrows() {
            matrix[(i, i)] += RIDGE_SHARE * self.matrix[(i, i)];
        }
        Some(-Cholesky::new(matrix)?.solve(&part.right))
    }

    fn symmetric(&self) -> DMatrix<f64> {
        let mut matrix = self.matrix.clone();
        matrix.fill_upper_triangle_with_lower_triangle();
        matrix
    }
}

#[cfg(test)]
mod tests {
    use super::DenseNormalEquations;

    #[test]
    fn a_line_through_three_points_has_the_known_slope_and_covariance() {
        // y = 1 + 2 x at x = 0, 1, 2, standard deviation 0.5: covariance 0.25 [[5/6, -1/2], [-1/2, 1/2]].
        let mut normal = DenseNormalEquations::new(2);
        for x in [0.0, 1.0, 2.0] {
            normal.add(&[0, 1], &[1.0, x], -(1.0 + 2.0 * x), 4.0, 0.0);
        }
        let step = normal.step(0.0).expect("determined");
        assert!((step[0] - 1.0).abs() < 1e-12 && (step[1] - 2.0).abs() < 1e-12);
        let covariance = normal.covariance().expect("determined");
        let expected = [0.25 * 5.0 / 6.0, -0.125, 0.125];
        let got = [covariance[(0, 0)], covariance[(0, 1)], covariance[(1, 1)]];
        assert!(got.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12));
        assert!(DenseNormalEquations::new(2).step(0.0).is_none());
    }

    /// The mean of 3, 5 and 10 is 6, and 4 without the last; a second unknown that only the last determines stays.
    #[test]
    fn leaving_a_residual_out_removes_its_influence() {
        let mean = 6.0;
        let mut all = DenseNormalEquations::new(2);
        let mut last = DenseNormalEquations::new(2);
        for y in [3.0, 5.0] {
            all.add(&[0], &[1.0], mean - y, 1.0, 0.0);
        }
        for normal in [&mut all, &mut last] {
            normal.add(&[0], &[1.0], mean - 10.0, 1.0, 0.0);
            normal.add(&[1], &[1.0], 0.0, 1.0, 0.0);
        }
        let moved = all.change_without(&last).expect("determined");
        assert!((moved[0] + 2.0).abs() < 1e-6, "{moved}");
        assert_eq!(moved[1], 0.0);
    }
}
