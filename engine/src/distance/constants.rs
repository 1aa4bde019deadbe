//! The numbers that decide something in this room, each with its unit and where it comes from.

/// Eigenvalues below this are raised to it before `fm` compares them, square metres: (1 mm)^2, the
/// regularisation of EM. Without a floor a flat component would be infinitely far from every other.
pub const FM_FLOOR_M2: f64 = crate::mixture::constants::REGULARISATION_M2;

/// Relative difference of two sums of masses that still counts as rounding.
pub const BALANCE_SLACK: f64 = 1e-9;

/// Smallest reduced cost worth a pivot, relative to the largest cost: above the rounding of potentials.
pub const PRICE_SLACK: f64 = 1e-13;

/// Pivots allowed per node before giving up; random problems of 1000 by 1000 were seen to need eight
/// (`cargo bench --bench distance`).
pub const PIVOTS_PER_NODE: usize = 10_000;

/// Error of the closed form of W2 that is let pass, relative to the trace of the covariances.
pub const FAST_ERROR: f64 = 1e-13;

/// Share of the covariances' trace that the squared W2 must have for the closed form: below it the
/// difference of traces cancels.
pub const FAST_SHARE: f64 = 1e-2;

/// Edges priced before the best of them enters, at most half of all: fewer make more pivots, more make them dearer;
/// least time at 100 to 1000 by as many (`cargo bench --bench distance`).
pub const PRICED_EDGES: usize = 2000;
