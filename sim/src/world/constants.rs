//! Every figure of the simulated sensor, with its unit and origin. "L1", "D": the recordings of that name in the
//! sensor's protocol notes (sections 7 and 11: a static room, and a robot that stood still in a large one). "Chosen":
//! no source has the figure; the choice is plausible and nothing must depend on it.

/// Steps of one mirror turn (PP `ARES`).
pub const STEPS_PER_TURN: u32 = 1024;
/// Step that looks straight ahead (PP `AFRT`).
pub const FRONT_STEP: u32 = 384;
/// First step that measures (PP `AMIN`).
pub const FIRST_STEP: u32 = 44;
/// Last step that measures (PP `AMAX`).
pub const LAST_STEP: u32 = 725;
/// Smallest range that is a range, mm (PP `DMIN`); what is less is a code.
pub const MIN_RANGE_MM: f64 = 20.0;
/// Largest range, mm (PP `DMAX`); beyond it nothing comes back.
pub const MAX_RANGE_MM: f64 = 5600.0;
/// Range up to which a code 0 proves free space, m (guaranteed range 4095 mm, SCIP 1.1 `V`).
pub const FREE_RANGE_M: f64 = 4.0;

/// Code "nothing there".
pub const CODE_NOTHING: u32 = 0;
/// Code for a target nearer than [`MIN_RANGE_MM`]: "low intensity". Chosen.
pub const CODE_TOO_NEAR: u32 = 1;
/// Code of a step that the sensor cannot measure.
pub const CODE_NO_STEP: u32 = 19;
/// Codes of a beam that meets nothing, with their shares (D; 9 from L1).
pub const EMPTY_CODES: [(u32, f64); 5] =
    [(0, 0.95), (7, 0.026), (6, 0.012), (1, 0.004), (9, 0.008)];
/// Codes of a beam that loses its target, with their shares. Chosen: errors first, for 7 often stands between two
/// valid values (33 % of all 7 in L1).
pub const DROPOUT_CODES: [(u32, f64); 5] = [(0, 0.50), (7, 0.35), (9, 0.05), (6, 0.05), (1, 0.05)];

/// Standard deviation of a range, (range mm, sigma mm), linear in between: L1's band medians up to 2.5 m, beyond
/// them D's (7-12 mm at 2.5-4 m) and those of a standing rover (4.4-8.9 mm at 3-5.6 m).
pub const SIGMA_MM: [(f64, f64); 7] = [
    (200.0, 2.2),
    (500.0, 2.1),
    (850.0, 2.6),
    (1250.0, 2.9),
    (2500.0, 3.5),
    (3500.0, 7.5),
    (5600.0, 8.0),
];
/// The line that stands for [`SIGMA_MM`] where a law is asked for: metres at zero, metres per metre.
pub const SIGMA_LINE: (f64, f64) = (0.0019, 0.0013);
/// Below this cosine of incidence the deviation grows as its inverse, up to [`MAX_SIGMA_GROWTH`]. Chosen. L1's 95th
/// percentile over a room is twice its median, which takes bad surfaces too: this model has none but by reflectance.
pub const FULL_SIGMA_COS: f64 = 0.4;
/// The most that a flat incidence multiplies the deviation by.
pub const MAX_SIGMA_GROWTH: f64 = 2.5;

/// Chance that a beam repeats its neighbour's value. With [`FRESH_CORRELATION`] and [`HOLD_LIMIT_SIGMA`] this gives L1's
/// correlation along the scan (.48 .28 .13 at 1 2 3 steps) and 42 % equal neighbours as the mean of a wall seen squarely
/// (50 %) and a small room with slanted ones (34 %), as `noise/tests.rs` measures.
pub const HOLD_CHANCE: f64 = 0.60;
/// Correlation of neighbouring beams' noise before values are held.
pub const FRESH_CORRELATION: f64 = 0.47;
/// A value is held only within so many sigmas of what the beam would give by itself, so that slanted walls stay slanted.
pub const HOLD_LIMIT_SIGMA: f64 = 1.2;

/// Jump between neighbouring beams that makes an edge, mm (L1).
pub const EDGE_JUMP_MM: f64 = 300.0;
/// Share of edges with a value in between (L1).
pub const MIXED_SHARE: f64 = 0.27;
/// Mixed values keep this share of the jump's width away from both sides. Chosen.
pub const MIXED_MARGIN: f64 = 0.1;

/// Chance that a beam with a good target gives a code: 2 % of beams do at least once in 16 scans (L1).
pub const DROPOUT_CHANCE: f64 = 0.00126;
/// Below this cosine of incidence targets get lost; at zero always. Chosen.
pub const GRAZING_COS: f64 = 0.08;
/// Range from which targets get lost, mm, and the chance at [`MAX_RANGE_MM`]; linear in between. Chosen: D's 10-20 % of
/// flickering beams come from a large room.
pub const FADING: (f64, f64) = (4500.0, 0.10);
/// Reflectance below which targets get lost; at zero always. Chosen.
pub const DARK_REFLECTANCE: f64 = 0.05;
/// Reflectance of what the scene file gives none. Chosen.
pub const DEFAULT_REFLECTANCE: f64 = 0.5;

/// Side of the cells to which a recorded cloud is thinned before it becomes surfels, m; evens out crowded tilt rows.
pub const SURFEL_CELL_M: f64 = 0.02;
/// Neighbours that give a surfel its normal.
pub const SURFEL_NEIGHBOURS: usize = 12;
/// A surfel reaches as far as this neighbour, so that discs overlap.
pub const SURFEL_REACH_NEIGHBOUR: usize = 6;
/// Bounds of a surfel's radius, m.
pub const SURFEL_RADIUS_M: (f64, f64) = (0.015, 0.15);
/// Second over first eigenvalue below which neighbours lie on one line and their plane is unknown.
pub const SURFEL_LINE_RATIO: f64 = 0.02;
