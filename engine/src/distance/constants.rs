//! Constants of the distance: unit and origin of each.

/// Floor of the eigenvalues that `fm` compares, square metres: (1 mm)^2, the regularisation of EM. Without it a flat
/// component would be infinitely far from every other.
pub(super) const FM_FLOOR_M2: f64 = crate::mixture::constants::REGULARISATION_M2;

/// Relative difference of two sums of masses up to which they count as equal: rounding.
pub(super) const MASS_TOLERANCE: f64 = 1e-9;

/// Smallest reduced cost worth a pivot, relative to the largest cost: above the rounding of potentials.
pub(super) const REDUCED_COST_TOLERANCE: f64 = 1e-13;

/// Pivots per node before giving up; random problems of 1000 by 1000 need some eight (`cargo bench --bench distance`).
pub(super) const MAX_PIVOTS_PER_NODE: usize = 10_000;

/// Error of the closed form of W2 that is accepted, relative to its fidelity term.
pub(super) const CLOSED_FORM_MAX_ERROR: f64 = 1e-13;

/// Least ratio of squared W2 to the trace of the covariances for the closed form: below it the difference of traces
/// cancels.
pub(super) const CLOSED_FORM_MIN_SHARE: f64 = 1e-2;

/// Edges priced before the best of them enters, at most half of all: with fewer there are more pivots, with more each
/// takes longer. Fastest for 100 to 1000 nodes a side (`cargo bench --bench distance`).
pub(super) const PRICED_EDGES: usize = 2000;
