//! Every constant of geometry that decides something, with its unit and origin.
//!
//! "Row spacing" is the median angle between neighbouring scan lines of a view; limits are multiples of it, so that they
//! hold for coarse and fine sensors alike. Constants that cost time only stay beside their code.

// Rays of a view (docs/novelty.md sections 2 and 5).

/// Directions around a query are divided into this many equal sectors. Chosen: axes and diagonals of a grid.
pub(super) const SECTORS: usize = 8;

/// Distance, in row spacings, up to which a direction beyond the last rays lies on them. Twice what the pose of one visit leaves
/// open: 0.05 deg where rows are 1 deg apart, a row in its own place from visit to visit.
pub(super) const ON_EDGE_SPACINGS: f64 = 0.1;

/// Radius, in row spacings, within which rays are neighbours of a direction. Chosen: reaches the diagonal of a grid of
/// rows.
pub(super) const NEIGHBOUR_SPACINGS: f64 = 1.6;

/// Radius, in row spacings, within which rays must surround a hole. Chosen.
pub(super) const HULL_SPACINGS: f64 = 40.0;

/// Spacing, in row spacings, of the coarse directions that [`HULL_SPACINGS`] is searched in. Chosen: the hull needs no
/// more detail.
pub(super) const COARSE_SPACINGS: f64 = 4.0;

/// Neighbouring sectors of the hull that must not all be empty: at 16 sectors, a gap of a sixth of a turn.
pub(super) const HULL_GAP_SECTORS: usize = 3;

/// Cell width of the index of directions, in row spacings: a query reads few cells and few rays in vain.
pub(super) const INDEX_SPACINGS: f64 = 0.8;

/// Radius, in row spacings, over which the density of rays is counted. Chosen: some 20 rays of an even pattern.
pub(super) const DENSITY_SPACINGS: f64 = 2.5;

/// Rays further apart than this are no neighbours, radians. Chosen: coarser than any laser scanner.
pub(super) const MAX_NEIGHBOUR_GAP_RAD: f64 = 0.5;

/// Rays at which spacing and density are sampled; more change nothing.
pub(super) const SPACING_SAMPLES: usize = 160;

/// Row spacing where no ray has neighbours, radians: one ray per square of a hundredth of the sphere.
pub(super) const DEFAULT_SPACING_RAD: f64 = 0.35;

/// Bounds of the row spacing, radians. Chosen: beyond any laser scanner on both sides.
pub(super) const SPACING_BOUNDS_RAD: (f64, f64) = (5e-4, 0.5);

/// Share of the ranges below the reach of a sensor: the last hundredth may be stray returns.
pub(super) const REACH_SHARE: f64 = 0.99;

// Relative noise of ranges, before any surface is known (docs/novelty.md section 2).

/// Radius, in row spacings, of the neighbours of a sampled ray: includes the lines above and below.
pub(super) const NOISE_SPACINGS: f64 = 2.2;

/// Rays that are compared with their neighbours; more change nothing.
pub(super) const NOISE_SAMPLES: usize = 1500;

/// Fewest neighbours: three fix a plane, the others leave something to compare.
pub(super) const MIN_NOISE_NEIGHBOURS: usize = 8;

/// Most neighbours used for one ray. Chosen: more are slow and no more exact.
pub(super) const MAX_NOISE_NEIGHBOURS: usize = 40;

/// Shorter ranges are no measurements, metres.
pub(super) const MIN_RANGE_M: f64 = 1e-3;

/// Share of sampled rays that are taken to lie on one plane even in clutter. Chosen.
pub(super) const CALM_SHARE: f64 = 0.25;

/// Absolute deviation, in standard deviations, below which [`CALM_SHARE`] of a normal distribution lies.
pub(super) const CALM_QUANTILE_SIGMAS: f64 = 0.3186;

// Field of view (docs/novelty.md section 5).

/// Bins of a full turn, 2 deg each.
pub(super) const FIELD_BINS: usize = 180;

/// Gaps of this many bins or fewer (30 deg) are holes in a field of view, not its end. Chosen.
pub(super) const HOLE_BINS: usize = 15;

/// The tilt of a line is well known for directions with at least this share along x: within 60 deg of the axis.
pub(super) const MIN_TILT_X: f64 = 0.5;

/// Smallest distance of a direction from the tilt axis (sine of the angle): tilted lines converge nearer to it.
pub(super) const MIN_OFF_TILT_AXIS: f64 = 0.2;

// Surfaces (docs/novelty.md section 2).

/// Fewest cells that fix a plane. Chosen: twice the three that a plane needs.
pub(super) const MIN_PLANE_CELLS: usize = 6;

/// Largest ratio of thickness to the smaller width (standard deviations) of a flat patch. Chosen.
pub(super) const MAX_FLAT_RATIO: f64 = 0.25;

/// Smallest ratio of the two widths: below, the cells lie along one scan line and fix no plane. Chosen.
pub(super) const MIN_WIDTH_RATIO: f64 = 0.2;

/// Largest area that one ray represents, in squares of its distance to the next: a lone ray at a shallow angle.
pub(super) const MAX_RAY_AREA_SPACINGS2: f64 = 4.0;

/// A neighbourhood spans this many row spacings to either side, so that it includes the next scan lines.
pub(super) const PATCH_SPACINGS: f64 = 1.6;

/// Smallest radius of a neighbourhood, in cells. Chosen.
pub(super) const MIN_PATCH_CELLS: f64 = 3.0;

/// Discs of cells that a neighbourhood of surfaces holds at most: a plane that runs along the border between cells fills two, the
/// corner of a room not much more. A ball of cells has as many at [`MIN_PATCH_CELLS`], and more beyond.
pub(super) const MAX_PATCH_DISCS: f64 = 4.0;

/// Largest radius of a neighbourhood, metres (or [`MIN_PATCH_CELLS`] if that is more). Chosen.
pub(super) const MAX_PATCH_RADIUS_M: f64 = 1.0;

/// Radius, in standard deviations of a range, of a neighbourhood that noise makes thick: a disc of radius r has r / 2
/// along its axes, which a flat patch exceeds by [`MAX_FLAT_RATIO`], with a quarter to spare.
pub(super) const NOISY_PATCH_SIGMAS: f64 = 10.0;

/// A neighbourhood thicker than this many standard deviations of a range is so by its shape, not by noise.
pub(super) const MAX_NOISE_THICKNESS_SIGMAS: f64 = 2.0;

/// Factor of the radius where the cells lie along one scan line. Chosen.
pub(super) const ONE_LINE_FACTOR: f64 = 2.5;

// Registration (docs/novelty.md section 4). What a caller may set is in `RegistrationSettings`.

/// Edges of the cubes of the two lookup tables, in cells: the coarse table serves wide gates.
pub(super) const TABLE_CELLS: [f64; 2] = [2.0, 8.0];

/// Gates up to this many cells use the fine table: twice its cubes' edge.
pub(super) const FINE_GATE_CELLS: f64 = 4.0;

/// Shorter steps change nothing; metres and radians.
pub(super) const SMALL_STEP: f64 = 3e-5;

/// Points that one task sums up. Fixes the order of summation, and so the last bits of the result.
pub(super) const POINTS_PER_TASK: usize = 1500;

/// So many neighbouring points of a surface err together and count as one. Chosen.
pub(super) const CORRELATED_POINTS: f64 = 10.0;

/// Standard deviations by which one pose explains a view better than another and is surely the better: by chance 1 in 40.
pub(super) const SURE_LEAD_SIGMAS: f64 = 2.0;

/// Poses that are compared with the best at most, so that the time is bounded.
pub(super) const MAX_CONTENDERS: usize = 8;

/// Edge of the blocks whose cells err together, metres: planes are fitted over neighbourhoods as wide ([`MAX_PATCH_RADIUS_M`]).
pub(super) const BLOCK_M: f64 = 1.0;

/// Smallest variance of residuals, square metres: (1 mm)^2. Chosen.
pub(super) const MIN_NOISE_M2: f64 = 1e-6;

/// Smallest lever arm that turns radians into metres, metres. Chosen.
pub(super) const MIN_LEVER_M: f64 = 0.1;
