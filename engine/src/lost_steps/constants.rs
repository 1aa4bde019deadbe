//! Every figure that decides something in this module, its unit and where it comes from.

/// Shift in the middle of a sweep from which the robot moved, metres: what a surface may lie off without being a novelty.
pub const MOST_SHIFT_M: f64 = 0.02;

/// Turn in the middle of a sweep from which steps were lost, radians: a quarter of a degree. A robot that stands askew does not
/// turn meanwhile, so what is suspected of a whole view is no bound; twice what a visit without loss was ever bent by, and what
/// is left of half a degree in a sweep's last three lines.
pub const LEAST_BEND_RAD: f64 = 0.0044;

/// Share of the flat surfaces below which, and of what either view saw of the other below which, the place is another one.
/// What came hides the reference, what went lay bare; both at once is another room. Emulated rooms against one another: 0.56
/// and 0.67 at most; the same room changed: 0.85 and 0.90 of the better view at least.
pub const OTHER_PLACE: (f64, f64) = (0.65, 0.75);

/// Points that are looked at for a bend.
pub const BEND_POINTS: usize = 12_000;

/// Stretches of a sweep, between which it may be bent: one for each line of the default sweep.
pub const BEND_STRETCHES: usize = 120;

/// Gates of the passes that look for a bend, metres: from what 5 deg are at 5 m to what half a degree is at 3 m.
pub const BEND_GATES_M: [f64; 7] = [0.45, 0.3, 0.2, 0.12, 0.07, 0.05, 0.05];

/// Gate within which places count as agreeing with the reference, metres: several sigmas of the laser's noise at middle ranges.
pub const BEND_AGREE_M: f64 = 0.03;

/// Share of the points that a bend must explain better, to be one: of all, and of the smaller part. Visits of the emulated
/// storeroom, changed or not, gain up to 6e-4 and 0.002 by bends of up to 0.13 deg that are none; half a degree lost gains
/// 0.0012 and 0.012 at least (`service/visits/lost_steps.rs`).
pub const LEAST_BEND_GAIN: [f64; 2] = [8e-4, 0.005];

/// Standard deviation of a place's height over a plane, with what surfaces bend by, metres.
pub const BEND_SIGMA_M: f64 = 0.008;

/// Neighbouring places err together: one in so many counts.
pub const BEND_ALIKE: f64 = 10.0;

/// How far the unknowns of a bent view may go at all, one standard deviation: metres and radians of the pose, metres and its share of the
/// range for the drift, radians and metres of the bend.
pub const BEND_PRIOR_SD: [f64; 12] = [
    0.1, 0.1, 0.1, 0.05, 0.05, 0.05, 0.01, 0.003, 0.1, 0.1, 0.1, 0.1,
];
