//! The Earth Mover's Distance of unequal masses: paper Eq. 5 as printed, with min{W, U}.

use super::transport::{total_mass, transport};
use super::{CostMatrix, DistanceError, Flow};

/// The distance of the smaller mass from the best part of the larger one.
#[derive(Debug, Clone, PartialEq)]
pub struct PartialEmd {
    /// Cost of the flows over min{W, U}, in the unit of the ground distance.
    pub d: f64,
    /// W and U, the totals of both sides.
    pub totals: [f64; 2],
    /// The optimal flows, all positive; their masses, in the unit of the totals, sum to min{W, U}.
    pub plan: Vec<Flow>,
    /// How far `d` may be above the optimum; rounding only.
    pub duality_gap: f64,
}

/// Paper Eq. 5: moves the side of less mass onto the other at the least cost, as they stand, and divides by the mass moved.
/// What is left of the larger side costs nothing (it flows to or from a further node at no cost), so this is no metric: two
/// places may both be at 0 from a third that has all of either, however far they are from one another.
///
/// # Errors
/// As [`emd_of_costs`](super::emd_of_costs).
pub fn partial_emd_of_costs(
    left: &[f64],
    right: &[f64],
    costs: &CostMatrix,
) -> Result<PartialEmd, DistanceError> {
    let totals = [total_mass("left", left)?, total_mass("right", right)?];
    let size_mismatch = DistanceError::SizeMismatch {
        rows: costs.rows(),
        columns: costs.columns(),
        left: left.len(),
        right: right.len(),
    };
    if (costs.rows(), costs.columns()) != (left.len(), right.len()) {
        return Err(size_mismatch);
    }
    let moved = totals[0].min(totals[1]);
    // Shares of the mass moved, so that no tolerance depends on the unit.
    let [mut rows, mut columns] =
        [left, right].map(|masses| masses.iter().map(|m| m / moved).collect::<Vec<_>>());
    let excess = (totals[0] - totals[1]) / moved;
    let padded = if excess > 0.0 {
        columns.push(excess);
        with_free_column(costs)
    } else if excess < 0.0 {
        rows.push(-excess);
        with_free_row(costs)
    } else {
        Some(costs.clone())
    };
    let padded = padded.ok_or(size_mismatch)?;
    let solution = transport(&rows, &columns, &padded, None)?;
    let real = |&(from, to, share): &(usize, usize, f64)| {
        Some(Flow {
            from,
            to,
            mass: share * moved,
            distance: costs.get(from, to)?,
        })
    };
    Ok(PartialEmd {
        d: solution.work,
        totals,
        plan: solution.plan.iter().filter_map(real).collect(),
        duality_gap: solution.duality_gap,
    })
}

fn with_free_row(costs: &CostMatrix) -> Option<CostMatrix> {
    let mut values = costs.values().to_vec();
    values.resize(values.len() + costs.columns(), 0.0);
    CostMatrix::from_rows(costs.rows() + 1, costs.columns(), values)
}

fn with_free_column(costs: &CostMatrix) -> Option<CostMatrix> {
    let rows = costs.values().chunks(costs.columns().max(1));
    let values = rows.flat_map(|row| row.iter().copied().chain([0.0]));
    CostMatrix::from_rows(costs.rows(), costs.columns() + 1, values.collect())
}

#[cfg(test)]
mod tests {
    use super::partial_emd_of_costs;
    use crate::distance::{CostMatrix, DistanceError, emd_of_costs};
    use proptest::prelude::*;

    /// |x - y| of positions on a line.
    fn line(left: &[f64], right: &[f64]) -> CostMatrix {
        let row = |x: &f64| right.iter().map(|y| (x - y).abs()).collect::<Vec<_>>();
        let values = left.iter().flat_map(row).collect();
        CostMatrix::from_rows(left.len(), right.len(), values).expect("the right number")
    }

    fn of_line(a: &[(f64, f64)], b: &[(f64, f64)]) -> f64 {
        let of = |side: &[(f64, f64)]| -> (Vec<f64>, Vec<f64>) { side.iter().copied().unzip() };
        let ((x, p), (y, q)) = (of(a), of(b));
        partial_emd_of_costs(&p, &q, &line(&x, &y)).expect("mass").d
    }

    #[test]
    fn worked_by_hand() {
        // (position, mass). One unit goes to the nearer of two.
        assert!((of_line(&[(0.0, 1.0)], &[(1.0, 1.0), (3.0, 1.0)]) - 1.0).abs() < 1e-15);
        // Two of three units move, both from 0, by 1 and by 4 m: 5 / 2. From 10 to 4 it would be 6.
        let (a, b) = ([(0.0, 2.0), (10.0, 1.0)], [(1.0, 1.0), (4.0, 1.0)]);
        assert!((of_line(&a, &b) - 2.5).abs() < 1e-15);
        assert!((of_line(&b, &a) - 2.5).abs() < 1e-15);
        // No metric: one unit at 0, one at 5, and a place with both.
        let both = [(0.0, 1.0), (5.0, 1.0)];
        assert_eq!(of_line(&[(0.0, 1.0)], &both), 0.0);
        assert_eq!(of_line(&both, &[(5.0, 1.0)]), 0.0);
        assert_eq!(of_line(&[(0.0, 1.0)], &[(5.0, 1.0)]), 5.0);
    }

    fn by_linear_programme(left: &[f64], right: &[f64], costs: &CostMatrix) -> f64 {
        use microlp::{ComparisonOp, OptimizationDirection, Problem};
        let moved = left.iter().sum::<f64>().min(right.iter().sum());
        let mut lp = Problem::new(OptimizationDirection::Minimize);
        let f: Vec<_> = costs
            .values()
            .iter()
            .map(|&c| lp.add_var(c, (0.0, f64::INFINITY)))
            .collect();
        let n = right.len();
        for (i, a) in left.iter().enumerate() {
            lp.add_constraint((0..n).map(|j| (f[i * n + j], 1.0)), ComparisonOp::Le, *a);
        }
        for (j, b) in right.iter().enumerate() {
            let column = (0..left.len()).map(|i| (f[i * n + j], 1.0));
            lp.add_constraint(column, ComparisonOp::Le, *b);
        }
        lp.add_constraint(
            f.iter().map(|v| (*v, 1.0)),
            ComparisonOp::Ge,
            moved * (1.0 - 1e-12),
        );
        match lp.solve().expect("feasible") {
            microlp::SolveOutcome::Solution(solution) => solution.objective() / moved,
            microlp::SolveOutcome::Interrupted(_) => f64::NAN,
        }
    }

    proptest! {
        #[test]
        fn it_agrees_with_a_linear_programme(left in proptest::collection::vec(0.05..1.0f64, 1..8), right in proptest::collection::vec(0.05..1.0f64, 1..8), raw in proptest::collection::vec(0.0..10.0f64, 64)) {
            let values = raw[..left.len() * right.len()].to_vec();
            let costs = CostMatrix::from_rows(left.len(), right.len(), values).expect("sized");
            let got = partial_emd_of_costs(&left, &right, &costs).expect("mass");
            prop_assert!((got.d - by_linear_programme(&left, &right, &costs)).abs() < 1e-8);
            prop_assert!(got.duality_gap.abs() < 1e-9);
            let moved: f64 = got.plan.iter().map(|f| f.mass).sum();
            prop_assert!((moved - got.totals[0].min(got.totals[1])).abs() < 1e-12);
            let work: f64 = got.plan.iter().map(|f| f.mass * f.distance).sum();
            prop_assert!((work / moved - got.d).abs() < 1e-12);
        }

        #[test]
        fn equal_totals_give_the_distance_and_its_unit_does_not_matter(left in proptest::collection::vec(0.05..1.0f64, 1..8), right in proptest::collection::vec(0.05..1.0f64, 1..8), raw in proptest::collection::vec(0.0..10.0f64, 64), unit in 1e-6..1e6f64) {
            let values = raw[..left.len() * right.len()].to_vec();
            let costs = CostMatrix::from_rows(left.len(), right.len(), values).expect("sized");
            let scaled = |masses: &[f64], by: f64| masses.iter().map(|m| m * by).collect::<Vec<_>>();
            let (p, q): (f64, f64) = (left.iter().sum(), right.iter().sum());
            let equal = partial_emd_of_costs(&left, &scaled(&right, p / q), &costs).expect("mass");
            prop_assert!((equal.d - emd_of_costs(&left, &right, &costs).expect("mass").d).abs() < 1e-9);
            let d = partial_emd_of_costs(&left, &right, &costs).expect("mass").d;
            let in_unit = partial_emd_of_costs(&scaled(&left, unit), &scaled(&right, unit), &costs);
            prop_assert!((in_unit.expect("mass").d - d).abs() < 1e-9);
        }
    }

    #[test]
    fn bad_masses_and_sizes_are_refused() {
        let costs = line(&[0.0, 1.0], &[0.0]);
        let refused = |left: &[f64], right: &[f64]| {
            partial_emd_of_costs(left, right, &costs).expect_err("refused")
        };
        assert!(matches!(
            refused(&[1.0, -1.0], &[1.0]),
            DistanceError::BadMass {
                side: "left",
                index: 1,
                ..
            }
        ));
        assert!(matches!(
            refused(&[1.0, 1.0], &[0.0]),
            DistanceError::NoMass { side: "right" }
        ));
        let mismatch = DistanceError::SizeMismatch {
            rows: 2,
            columns: 1,
            left: 1,
            right: 1,
        };
        assert_eq!(refused(&[1.0], &[2.0]), mismatch);
        assert_eq!(refused(&[1.0], &[1.0]), mismatch);
    }
}
