//! Constants of the simulated sensor. "L1", "D": the recordings of that name in scip2 sections 7 and 11 (a static room,
//! and a standing robot in a large one). "Chosen": no source has the figure; nothing must depend on it.

/// Steps of one mirror turn (PP `ARES`).
pub(crate) const STEPS_PER_TURN: u32 = 1024;
/// Step that looks straight ahead (PP `AFRT`).
pub(crate) const FRONT_STEP: u32 = 384;
/// First step that measures (PP `AMIN`).
pub(crate) const FIRST_STEP: u32 = 44;
/// Last step that measures (PP `AMAX`).
pub(crate) const LAST_STEP: u32 = 725;
/// Smallest range, mm (PP `DMIN`); smaller values are codes.
pub(crate) const MIN_RANGE_MM: f64 = 20.0;
/// Largest range, mm (PP `DMAX`).
pub(crate) const MAX_RANGE_MM: f64 = 5600.0;
/// Range up to which a code 0 proves free space, m (guaranteed range 4095 mm: scip2 section 9).
pub(crate) const FREE_RANGE_M: f64 = 4.0;

/// Code of a beam without return.
pub(crate) const CODE_NOTHING: u32 = 0;
/// Code of a target nearer than [`MIN_RANGE_MM`]: "low intensity". Chosen.
pub(crate) const CODE_TOO_NEAR: u32 = 1;
/// Code of a step that is not measured.
pub(crate) const CODE_NO_STEP: u32 = 19;
/// Codes of a beam without target, with their shares (D; 9 from L1).
pub(crate) const EMPTY_CODES: [(u32, f64); 5] =
    [(0, 0.95), (7, 0.026), (6, 0.012), (1, 0.004), (9, 0.008)];
/// Codes of a dropout, with their shares. Chosen: 7 is frequent, for 33 % of all 7 in L1 lie between two valid values.
pub(crate) const DROPOUT_CODES: [(u32, f64); 5] =
    [(0, 0.50), (7, 0.35), (9, 0.05), (6, 0.05), (1, 0.05)];

/// Standard deviation of a range, (range mm, sigma mm), linear in between: L1's band medians up to 2.5 m, beyond
/// them D's (7-12 mm at 2.5-4 m) and those of a standing rover (4.4-8.9 mm at 3-5.6 m).
pub(crate) const SIGMA_MM: [(f64, f64); 7] = [
    (200.0, 2.2),
    (500.0, 2.1),
    (850.0, 2.6),
    (1250.0, 2.9),
    (2500.0, 3.5),
    (3500.0, 7.5),
    (5600.0, 8.0),
];
/// [`SIGMA_MM`] as a linear law: metres at zero, metres per metre.
pub(crate) const SIGMA_LINE: (f64, f64) = (0.0019, 0.0013);
/// Below this cosine of incidence the deviation grows as its inverse, up to [`MAX_SIGMA_GROWTH`]. Chosen: the 95th
/// percentile of L1 over a room, bad surfaces included, is twice the median.
pub(crate) const FULL_SIGMA_COS: f64 = 0.4;
/// Greatest factor of a grazing incidence on the deviation.
pub(crate) const MAX_SIGMA_GROWTH: f64 = 2.5;

/// Probability that a beam repeats the value of its neighbour. With [`FRESH_CORRELATION`] and [`HOLD_LIMIT_SIGMA`] this
/// gives the correlation of L1 along the scan (0.48, 0.28, 0.13 at 1, 2, 3 steps) and 42 % equal neighbours as the mean of
/// a wall seen squarely (50 %) and a small room with slanted walls (34 %), as `noise/tests.rs` measures.
pub(crate) const HOLD_CHANCE: f64 = 0.60;
/// Correlation of the noise of neighbouring beams before values are held.
pub(crate) const FRESH_CORRELATION: f64 = 0.47;
/// A value is held only within so many sigmas of the beam's own, so that slanted walls stay slanted.
pub(crate) const HOLD_LIMIT_SIGMA: f64 = 1.2;

/// Smallest jump between neighbouring beams at an edge, mm (L1).
pub(crate) const EDGE_JUMP_MM: f64 = 300.0;
/// Share of edges with a mixed pixel (L1).
pub(crate) const MIXED_SHARE: f64 = 0.27;
/// Mixed values keep this share of the jump away from both sides. Chosen.
pub(crate) const MIXED_MARGIN: f64 = 0.1;

/// Probability of a dropout on a good target: 2 % of beams have one in 16 scans (L1).
pub(crate) const DROPOUT_CHANCE: f64 = 0.00126;
/// Below this cosine of incidence dropouts begin; at zero all drop out. Chosen.
pub(crate) const GRAZING_COS: f64 = 0.08;
/// Range from which dropouts grow, mm, and their probability at [`MAX_RANGE_MM`]; linear in between. Chosen: the 10-20 %
/// of flickering beams in D come from a large room.
pub(crate) const FADING: (f64, f64) = (4500.0, 0.10);
/// Reflectance below which dropouts begin; at zero all drop out. Chosen.
pub(crate) const DARK_REFLECTANCE: f64 = 0.05;
/// Reflectance of objects without one in the scene file. Chosen.
pub(crate) const DEFAULT_REFLECTANCE: f64 = 0.5;

/// Cells to which a recorded cloud is thinned before it becomes surfels, m; evens out crowded tilt rows.
pub(crate) const SURFEL_CELL_M: f64 = 0.02;
/// Neighbours that determine the normal of a surfel.
pub(crate) const SURFEL_NEIGHBOURS: usize = 12;
/// A surfel reaches to this neighbour, so that discs overlap.
pub(crate) const SURFEL_REACH_NEIGHBOUR: usize = 6;
/// Bounds of a surfel's radius, m.
pub(crate) const SURFEL_RADIUS_M: (f64, f64) = (0.015, 0.15);
/// Second over first eigenvalue below which neighbours lie on one line and their plane is undetermined.
pub(crate) const SURFEL_LINE_RATIO: f64 = 0.02;
