//! Exact optimal transport between two lists of masses (paper Eq. 5 with W = U).

use super::constants::{MASS_TOLERANCE, MAX_PIVOTS_PER_NODE};
use super::pricing::min_reduced_cost;
use super::simplex::Simplex;
use super::{CostMatrix, DistanceError};
use crate::mixture::instructions::{InstructionSet, SimdKernel};

/// An optimal plan with the duals that prove it optimal.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TransportPlan {
    /// Sum of flow times cost.
    pub work: f64,
    /// (row, column, flow) where flow is positive, by row, then column; at most rows + columns - 1.
    pub plan: Vec<(usize, usize, f64)>,
    /// u_i: cost per additional mass in row i, up to a constant shared with `column_duals`.
    pub row_duals: Vec<f64>,
    /// v_j; u_i + v_j <= c_ij everywhere.
    pub column_duals: Vec<f64>,
    /// `work` less the value of the duals, a lower bound of every plan.
    pub duality_gap: f64,
}

/// Moves `left` (rows) onto `right` (columns) at the least cost. Exact; network simplex. `prices` are duals of the columns of
/// a similar problem, if any: they change the time, and not the answer but among plans of equal cost.
///
/// # Errors
/// Masses that are negative, not finite, without sum or unbalanced; costs not finite or of another size.
pub(super) fn transport(
    left: &[f64],
    right: &[f64],
    costs: &CostMatrix,
    prices: Option<&[f64]>,
) -> Result<TransportPlan, DistanceError> {
    let (m, n) = (left.len(), right.len());
    if (costs.rows(), costs.columns()) != (m, n) {
        return Err(DistanceError::SizeMismatch {
            rows: costs.rows(),
            columns: costs.columns(),
            left: m,
            right: n,
        });
    }
    let (total_left, total_right) = (total_mass("left", left)?, total_mass("right", right)?);
    if (total_left - total_right).abs() > MASS_TOLERANCE * total_left.max(total_right) {
        return Err(DistanceError::Unbalanced {
            left: total_left,
            right: total_right,
        });
    }
    if let Some(at) = costs.values().iter().position(|c| !c.is_finite()) {
        return Err(DistanceError::BadCost {
            row: at / n,
            column: at % n,
        });
    }
    let massive = |masses: &[f64]| {
        (0..masses.len())
            .filter(|&i| masses[i] > 0.0)
            .collect::<Vec<_>>()
    };
    let (rows, columns) = (massive(left), massive(right));
    let compact = (rows.len() < m || columns.len() < n).then(|| {
        let row = |&r: &usize| columns.iter().map(move |&c| costs.values()[r * n + c]);
        rows.iter().flat_map(row).collect::<Vec<f64>>()
    });
    let compact = compact.as_deref().unwrap_or(costs.values());
    let masses = |all: &[f64], kept: &[usize]| kept.iter().map(|&i| all[i]).collect::<Vec<_>>();
    let prices = prices
        .filter(|prices| prices.len() == n && prices.iter().all(|price| price.is_finite()))
        .map(|prices| masses(prices, &columns));
    let mut simplex = Simplex::new(
        &masses(left, &rows),
        &masses(right, &columns),
        compact,
        prices.as_deref(),
    );
    simplex
        .solve((rows.len() + columns.len()) * MAX_PIVOTS_PER_NODE)
        .map_err(|pivots| DistanceError::NotConverged { pivots })?;

    let mut plan: Vec<_> = simplex
        .flows()
        .map(|(r, c, f)| (rows[r], columns[c], f))
        .collect();
    plan.sort_unstable_by_key(|&(r, c, _)| (r, c));
    let work = plan
        .iter()
        .map(|&(r, c, f)| f * costs.values()[r * n + c])
        .sum();
    let (row_duals, column_duals) =
        feasible_duals(simplex.column_duals(), (&rows, &columns), costs);
    let value =
        |masses: &[f64], duals: &[f64]| masses.iter().zip(duals).map(|(a, b)| a * b).sum::<f64>();
    let duality_gap = work - value(left, &row_duals) - value(right, &column_duals);
    Ok(TransportPlan {
        work,
        plan,
        row_duals,
        column_duals,
        duality_gap,
    })
}

/// The sum of the masses of one side, above zero.
pub(super) fn total_mass(side: &'static str, masses: &[f64]) -> Result<f64, DistanceError> {
    for (index, &got) in masses.iter().enumerate() {
        if !got.is_finite() || got < 0.0 {
            return Err(DistanceError::BadMass { side, index, got });
        }
    }
    let total: f64 = masses.iter().sum();
    if total <= 0.0 || !total.is_finite() {
        return Err(DistanceError::NoMass { side });
    }
    Ok(total)
}

/// Duals of all rows and columns, those without mass included, with u + v <= c kept exactly. The columns of the simplex
/// give every row its u = min (c - v); those give a column without mass its v; rows without mass are lowered to that.
fn feasible_duals(
    v: &[f64],
    (rows, columns): (&[usize], &[usize]),
    costs: &CostMatrix,
) -> (Vec<f64>, Vec<f64>) {
    let (m, n) = (costs.rows(), costs.columns());
    let mut column_duals = vec![f64::INFINITY; n];
    for (&column, &v) in columns.iter().zip(v) {
        column_duals[column] = v;
    }
    // An unknown dual is minus infinity, so that it binds no row.
    let binding: Vec<f64> = column_duals
        .iter()
        .map(|&v| if v == f64::INFINITY { -v } else { v })
        .collect();
    let mut row_duals = min_of_rows(costs, &binding);
    if columns.len() < n {
        for &row in rows {
            let costs = &costs.values()[row * n..(row + 1) * n];
            for (v, (c, known)) in column_duals.iter_mut().zip(costs.iter().zip(&binding)) {
                if *known == f64::NEG_INFINITY {
                    *v = v.min(c - row_duals[row]);
                }
            }
        }
        if rows.len() < m {
            row_duals = min_of_rows(costs, &column_duals);
        }
    }
    (row_duals, column_duals)
}

/// The minimum of cost less `columns` in every row.
fn min_of_rows(costs: &CostMatrix, columns: &[f64]) -> Vec<f64> {
    InstructionSet::best().run(MinOfRows { costs, columns })
}

/// The loop of [`min_of_rows`].
struct MinOfRows<'a> {
    costs: &'a CostMatrix,
    columns: &'a [f64],
}

impl SimdKernel for MinOfRows<'_> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn run<const FUSED: bool, const LANES: usize>(self) -> Vec<f64> {
        let rows = self.costs.values().chunks_exact(self.columns.len());
        rows.map(|row| min_reduced_cost::<LANES>(row, self.columns))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::transport;
    use crate::distance::{CostMatrix, DistanceError};
    use proptest::prelude::*;

    fn matrix(m: usize, n: usize, values: Vec<f64>) -> CostMatrix {
        CostMatrix::from_rows(m, n, values).expect("the right number of values")
    }

    /// Checks that the plan moves the masses and that the duals prove it best; gives the work.
    fn work_of_proven_plan(left: &[f64], right: &[f64], costs: &CostMatrix) -> f64 {
        let t = transport(left, right, costs, None).expect("balanced");
        let (mut rows, mut columns) = (vec![0.0; left.len()], vec![0.0; right.len()]);
        for &(r, c, f) in &t.plan {
            assert!(f > 0.0);
            rows[r] += f;
            columns[c] += f;
        }
        let scale: f64 = left.iter().sum();
        for (a, b) in rows.iter().zip(left).chain(columns.iter().zip(right)) {
            assert!((a - b).abs() <= 1e-12 * scale, "{a} {b}");
        }
        let largest = costs.values().iter().fold(0.0, |a: f64, c| a.max(c.abs()));
        for (i, u) in t.row_duals.iter().enumerate() {
            for (j, v) in t.column_duals.iter().enumerate() {
                assert!(u + v <= costs.get(i, j).expect("inside") + 1e-12 * largest);
            }
        }
        assert!(
            t.duality_gap.abs() <= 1e-10 * scale * (largest + 1e-300),
            "{}",
            t.duality_gap
        );
        assert!(t.plan.len() < left.len() + right.len());
        t.work
    }

    fn normalised(mut w: Vec<f64>) -> Vec<f64> {
        let s: f64 = w.iter().sum();
        w.iter_mut().for_each(|v| *v /= s);
        w
    }

    fn masses() -> impl Strategy<Value = Vec<f64>> {
        let mass = prop_oneof![3 => Just(1.0), 1 => Just(0.0), 2 => 0.01..1.0f64, 1 => Just(1e-300), 1 => Just(1e-17)];
        proptest::collection::vec(mass, 1..14)
            .prop_filter("some mass", |w| w.iter().sum::<f64>() > 0.0)
            .prop_map(normalised)
    }

    fn by_linear_programme(left: &[f64], right: &[f64], costs: &CostMatrix) -> f64 {
        use microlp::{ComparisonOp, OptimizationDirection, Problem};
        let mut lp = Problem::new(OptimizationDirection::Minimize);
        let f: Vec<_> = costs
            .values()
            .iter()
            .map(|&c| lp.add_var(c, (0.0, f64::INFINITY)))
            .collect();
        let n = right.len();
        for (i, a) in left.iter().enumerate() {
            lp.add_constraint((0..n).map(|j| (f[i * n + j], 1.0)), ComparisonOp::Eq, *a);
        }
        for (j, b) in right.iter().enumerate().skip(1) {
            lp.add_constraint(
                (0..left.len()).map(|i| (f[i * n + j], 1.0)),
                ComparisonOp::Eq,
                *b,
            );
        }
        match lp.solve().expect("feasible") {
            microlp::SolveOutcome::Solution(solution) => solution.objective(),
            microlp::SolveOutcome::Interrupted(_) => f64::NAN,
        }
    }

    proptest! {
        #[test]
        fn every_plan_is_feasible_and_its_duals_prove_it(left in masses(), right in masses(), raw in proptest::collection::vec(0.0..10.0f64, 196), coarse in any::<bool>()) {
            let (m, n) = (left.len(), right.len());
            let values: Vec<f64> = raw[..m * n].iter().map(|c| if coarse { c.floor() / 3.0 } else { *c }).collect();
            let costs = matrix(m, n, values);
            let work = work_of_proven_plan(&left, &right, &costs);
            let turned: Vec<f64> = (0..n * m).map(|e| costs.values()[(e % m) * n + e / m]).collect();
            prop_assert!((work_of_proven_plan(&right, &left, &matrix(n, m, turned)) - work).abs() < 1e-11);
        }

        #[test]
        fn work_agrees_with_a_linear_programme(left in proptest::collection::vec(0.05..1.0f64, 2..9), right in proptest::collection::vec(0.05..1.0f64, 2..9), raw in proptest::collection::vec(0.0..10.0f64, 64)) {
            let (left, right) = (normalised(left), normalised(right));
            let costs = matrix(left.len(), right.len(), raw[..left.len() * right.len()].to_vec());
            let got = work_of_proven_plan(&left, &right, &costs);
            prop_assert!((got - by_linear_programme(&left, &right, &costs)).abs() < 1e-8);
        }
    }

    #[test]
    fn problems_full_of_ties_terminate() {
        for n in [2usize, 7, 40, 120] {
            let even = vec![1.0 / n as f64; n];
            let values = (0..n * n).map(|e| ((e / n + e % n) % 3) as f64).collect();
            work_of_proven_plan(&even, &even, &matrix(n, n, values));
            assert_eq!(
                work_of_proven_plan(&even, &even, &matrix(n, n, vec![1.0; n * n])),
                even.iter().sum::<f64>()
            );
            assert_eq!(
                work_of_proven_plan(&even, &even, &matrix(n, n, vec![0.0; n * n])),
                0.0
            );
        }
    }

    #[test]
    fn bad_masses_and_costs_are_refused() {
        let c = matrix(1, 2, vec![1.0, 2.0]);
        let err =
            |l: &[f64], r: &[f64], c: &CostMatrix| transport(l, r, c, None).expect_err("refused");
        assert!(matches!(
            err(&[1.0], &[0.5, 0.6], &c),
            DistanceError::Unbalanced { .. }
        ));
        assert!(matches!(
            err(&[1.0], &[1.0], &c),
            DistanceError::SizeMismatch { .. }
        ));
        assert!(matches!(
            err(&[0.0], &[0.0, 0.0], &c),
            DistanceError::NoMass { side: "left" }
        ));
        assert!(matches!(
            err(&[1.0], &[-1.0, 2.0], &c),
            DistanceError::BadMass { index: 0, .. }
        ));
        let c = matrix(1, 2, vec![1.0, f64::NAN]);
        assert!(matches!(
            err(&[1.0], &[0.5, 0.5], &c),
            DistanceError::BadCost { row: 0, column: 1 }
        ));
    }
}
