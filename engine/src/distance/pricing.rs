//! Minimum and maximum over long slices, in lanes that the compiler vectorises.

/// Minimum of `costs - column_duals`: the smallest reduced cost of a row, up to its own dual.
#[inline(always)]
pub(super) fn min_reduced_cost<const LANES: usize>(costs: &[f64], column_duals: &[f64]) -> f64 {
    let (c, v) = (costs.chunks_exact(LANES), column_duals.chunks_exact(LANES));
    let mut best = f64::INFINITY;
    for (c, v) in c.remainder().iter().zip(v.remainder()) {
        best = lesser(c - v, best);
    }
    let mut low = [f64::INFINITY; LANES];
    for (c, v) in c.zip(v) {
        for lane in 0..LANES {
            low[lane] = lesser(c[lane] - v[lane], low[lane]);
        }
    }
    low.into_iter().fold(best, |a, b| lesser(b, a))
}

#[inline(always)]
fn lesser(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// Largest magnitude; NaN is ignored.
pub(super) fn max_abs(values: &[f64]) -> f64 {
    const LANES: usize = 4;
    let chunks = values.chunks_exact(LANES);
    let greater = |a: f64, b: f64| if a > b { a } else { b };
    let mut high = [0.0; LANES];
    let rest = chunks
        .remainder()
        .iter()
        .fold(0.0, |a: f64, v| greater(v.abs(), a));
    for chunk in chunks {
        for lane in 0..LANES {
            high[lane] = greater(chunk[lane].abs(), high[lane]);
        }
    }
    high.into_iter().fold(rest, greater)
}
