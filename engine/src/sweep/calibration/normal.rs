//! Sums of weighted residuals and their derivatives: the normal equations, a step of Levenberg and Marquardt, covariances.

use super::constants::UNDETERMINED_SHARE;
use nalgebra::{Cholesky, DMatrix, DVector};

/// The normal equations of some residuals.
#[derive(Debug, Clone)]
pub struct Normal {
    matrix: DMatrix<f64>,
    right: DVector<f64>,
    /// Half the sum of weighted squares.
    pub cost: f64,
}

impl Normal {
    /// Of `unknowns` unknowns and no residual.
    pub fn new(unknowns: usize) -> Self {
        Self {
            matrix: DMatrix::zeros(unknowns, unknowns),
            right: DVector::zeros(unknowns),
            cost: 0.0,
        }
    }

    /// Adds a residual that moves with the unknowns `at` by `slopes`, its weight, and what it costs.
    pub fn add(&mut self, at: &[usize], slopes: &[f64], residual: f64, weight: f64, cost: f64) {
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

    /// The step that the residuals ask for, held back by `damping` of the diagonal; `None` where the unknowns are not
    /// determined, which priors prevent.
    pub fn step(&self, damping: f64) -> Option<DVector<f64>> {
        let mut matrix = self.symmetric();
        for i in 0..matrix.nrows() {
            matrix[(i, i)] *= 1.0 + damping;
        }
        Some(Cholesky::new(matrix)?.solve(&self.right))
    }

    /// Covariance of the unknowns.
    pub fn covariance(&self) -> Option<DMatrix<f64>> {
        Some(Cholesky::new(self.symmetric())?.inverse())
    }

    /// The whole matrix: the inverse of a covariance.
    pub fn information(&self) -> DMatrix<f64> {
        self.symmetric()
    }

    /// By how much the solution of these equations moves, to first order, when the residuals of `part` are left out of
    /// them. What nothing but `part` determines stays where it is.
    pub fn moved_without(&self, part: &Self) -> Option<DVector<f64>> {
        let mut matrix = self.symmetric() - part.symmetric();
        for i in 0..matrix.nrows() {
            matrix[(i, i)] += UNDETERMINED_SHARE * self.matrix[(i, i)];
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
    use super::Normal;

    #[test]
    fn a_line_through_three_points_has_the_textbooks_slope_and_covariance() {
        // y = 1 + 2 x at x = 0, 1, 2, standard deviation 0.5: covariance 0.25 [[5/6, -1/2], [-1/2, 1/2]].
        let mut normal = Normal::new(2);
        for x in [0.0, 1.0, 2.0] {
            normal.add(&[0, 1], &[1.0, x], -(1.0 + 2.0 * x), 4.0, 0.0);
        }
        let step = normal.step(0.0).expect("determined");
        assert!((step[0] - 1.0).abs() < 1e-12 && (step[1] - 2.0).abs() < 1e-12);
        let covariance = normal.covariance().expect("determined");
        let expected = [0.25 * 5.0 / 6.0, -0.125, 0.125];
        let got = [covariance[(0, 0)], covariance[(0, 1)], covariance[(1, 1)]];
        assert!(got.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12));
        assert!(Normal::new(2).step(0.0).is_none());
    }

    /// A mean of 3, 5 and 10 is 6, and 4 without the last; a second unknown that the last alone tells stays.
    #[test]
    fn what_is_left_out_moves_the_solution_by_what_it_did() {
        let mean = 6.0;
        let mut all = Normal::new(2);
        let mut last = Normal::new(2);
        for y in [3.0, 5.0] {
            all.add(&[0], &[1.0], mean - y, 1.0, 0.0);
        }
        for normal in [&mut all, &mut last] {
            normal.add(&[0], &[1.0], mean - 10.0, 1.0, 0.0);
            normal.add(&[1], &[1.0], 0.0, 1.0, 0.0);
        }
        let moved = all.moved_without(&last).expect("determined");
        assert!((moved[0] + 2.0).abs() < 1e-6, "{moved}");
        assert_eq!(moved[1], 0.0);
    }
}
