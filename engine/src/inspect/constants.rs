//! Every figure that decides something in this module, its unit and where it comes from.

/// Share of a sweep's points that count as independent: noise is correlated along the scan by .48, .28, .13 at
/// 1, 2, 3 steps (scip2 section 11), so n points weigh as n / (1 + 2 (.48 + .28 + .13)).
pub const SWEEP_INDEPENDENT_SHARE: f64 = 1.0 / (1.0 + 2.0 * (0.48 + 0.28 + 0.13));

/// Most components of a mixture in the paper's way; its corridor of 400 points has some ten surfaces, a real
/// scan more.
pub const PAPER_MOST_COMPONENTS: usize = 30;
