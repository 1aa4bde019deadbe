//! Constants of the pipeline: unit and origin of each.

/// Share of a sweep's points that count as independent: noise is correlated along a scan by .48, .28, .13 at 1, 2, 3
/// steps (scip2 section 11), so n points are worth n / (1 + 2 (.48 + .28 + .13)).
pub(super) const SWEEP_INDEPENDENT_SHARE: f64 = 1.0 / (1.0 + 2.0 * (0.48 + 0.28 + 0.13));

/// Most components that the engine `paper` tries: the paper's corridor of 400 points has some ten surfaces, a real scan
/// more.
pub(super) const PAPER_MAX_COMPONENTS: usize = 30;

/// d_GMM from which the engine `paper` finds a change, metres: above what all of 80 quiet pairs reach, 0.0003
/// (`patrold evaluate --seed 5 --pairs 60 --engine paper --view bare`); of 79 of them d_GMM is 0.
pub(super) const PAPER_U_TH_M: f64 = 5e-4;

/// The same of `paper-independent`, metres; a judgement. No value separates quiet pairs from changed ones
/// (`docs/novelty.md section 10`).
pub(super) const PAPER_INDEPENDENT_U_TH_M: f64 = 0.01;
