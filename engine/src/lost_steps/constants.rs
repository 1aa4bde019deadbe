//! Constants of the lost-step check: unit and origin of each.

/// Shift in the middle of a sweep from which the robot moved, metres: as far as a surface may be off without being a
/// novelty.
pub(super) const MIN_BEND_SHIFT_M: f64 = 0.02;

/// Rotation in the middle of a sweep from which steps were lost, radians: a quarter of a degree. A robot does not turn during
/// a sweep. Twice the largest bend of visits without loss; what
/// is left of half a degree in the last three lines of a sweep.
pub(super) const MIN_BEND_RAD: f64 = 0.0044;

/// It is another place if less than this share of the flat surfaces agrees and neither view saw more than
/// [`OTHER_PLACE_OVERLAP`] of the other. Emulated rooms against one another reach 0.56 and 0.67 at most; the same room
/// changed, 0.85 and 0.90 of the better view at least.
pub(super) const OTHER_PLACE_AGREEMENT: f64 = 0.65;

/// See [`OTHER_PLACE_AGREEMENT`].
pub(super) const OTHER_PLACE_OVERLAP: f64 = 0.75;

/// Points of the sweep that take part in the fit of a bend, about.
pub(super) const BEND_POINTS: usize = 12_000;

/// Stretches of a sweep, between which it may be bent: one per scan line of the default sweep.
pub(super) const BEND_STRETCHES: usize = 120;

/// Gates of the iterations, metres: from what 5 deg are at 5 m to what half a degree is at 3 m.
pub(super) const BEND_GATES_M: [f64; 7] = [0.45, 0.3, 0.2, 0.12, 0.07, 0.05, 0.05];

/// Gate of the agreement with the reference, metres: several sigmas of the laser's noise at medium range.
pub(super) const BEND_AGREEMENT_GATE_M: f64 = 0.03;

/// Gain in agreement that a bend must bring. Visits of the emulated storeroom without loss, changed or not, gain up to 6e-4
/// by spurious bends of up to 0.13 deg; half a degree lost gains 0.0012 at least (tests of lost steps in
/// `src/service/visits`).
pub(super) const MIN_BEND_GAIN: f64 = 8e-4;

/// The same as a share of the smaller part, before or after the bend: up to 0.002 without loss, 0.012 at least with it.
pub(super) const MIN_BEND_GAIN_OF_SMALLER_PART: f64 = 0.005;

/// Standard deviation of a point's height over a plane, with the curvature of surfaces, metres.
pub(super) const BEND_HEIGHT_SIGMA_M: f64 = 0.008;

/// Errors of neighbouring points are correlated: one in so many counts as independent.
pub(super) const BEND_POINTS_PER_INDEPENDENT: f64 = 10.0;

/// Prior standard deviations of the unknowns: pose in metres and radians, drift in metres and as a share of the range, bend
/// in radians and metres.
pub(super) const BEND_PRIOR_SD: [f64; 12] = [
    0.1, 0.1, 0.1, 0.05, 0.05, 0.05, 0.01, 0.003, 0.1, 0.1, 0.1, 0.1,
];
