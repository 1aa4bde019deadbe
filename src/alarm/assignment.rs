//! Which sighting is which incident, over all pairs at once: the assignment of the greatest total gain, as the transport of
//! unit masses.

use patrold_engine::distance::{CostMatrix, emd_of_costs};

/// Pairs (row, column) of the greatest total gain; each row and column at most once, and no pair without a gain. `gains` is
/// by rows.
pub(super) fn assign(gains: &[Vec<f64>], columns: usize) -> Vec<(usize, usize)> {
    let rows = gains.len();
    // Square, with rows and columns that stand for no partner.
    let size = rows.max(columns);
    let gain = |row: usize, column: usize| {
        let gain = gains.get(row).and_then(|of_row| of_row.get(column));
        gain.copied().unwrap_or(0.0).max(0.0)
    };
    let greatest = gains.iter().flatten().copied().fold(0.0, f64::max);
    if greatest <= 0.0 {
        return Vec::new();
    }
    let costs = (0..size)
        .flat_map(|row| (0..size).map(move |column| (row, column)))
        .map(|(row, column)| greatest - gain(row, column))
        .collect();
    let masses = vec![1.0 / size as f64; size];
    let plan = CostMatrix::from_rows(size, size, costs)
        .and_then(|costs| emd_of_costs(&masses, &masses, &costs).ok())
        .map(|emd| emd.plan)
        .unwrap_or_default();
    // A vertex of the transport polytope of equal masses is a permutation.
    let mut pairs: Vec<(usize, usize)> = plan
        .iter()
        .filter(|flow| flow.mass > 0.5 / size as f64)
        .map(|flow| (flow.from, flow.to))
        .filter(|(row, column)| gain(*row, *column) > 0.0)
        .collect();
    pairs.sort_unstable();
    pairs
}
