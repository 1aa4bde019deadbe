//! Constants of the pipeline: unit and origin of each.

/// Share of a sweep's points that count as independent: noise is correlated along a scan by .48, .28, .13 at 1, 2, 3
/// steps (scip2 section 11), so n points are worth n / (1 + 2 (.48 + .28 + .13)).
pub(super) const SWEEP_INDEPENDENT_SHARE: f64 = 1.0 / (1.0 + 2.0 * (0.48 + 0.28 + 0.13));

/// Most components that the engine `paper` tries: the paper's corridor of 400 points has some ten surfaces, a real scan
/// more.
pub(super) const PAPER_MAX_COMPONENTS: usize = 30;

/// d_GMM from which the engines `paper` and `paper-independent` find a change, metres. No one value suits all places:
/// 29 of 48 quiet pairs of `paper` stay below this one (`patrold evaluate --seed 4 --pairs 36 --engine paper --view bare`);
/// `--u-th quiet` takes the threshold of each place from quiet visits.
pub(super) const PAPER_U_TH_M: f64 = 0.01;
