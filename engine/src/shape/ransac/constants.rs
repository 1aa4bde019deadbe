//! Every constant that decides something in method A, with unit and origin. "Schnabel" is Schnabel,
//! Wahl, Klein 2007, "Efficient RANSAC for point-cloud shape detection".

// Settings that are derived where none are given.

/// Points through which a primitive hangs together lie no farther apart than this, metres: what
/// makes one novelty (design section 5; 16 rings of a coarse scanner at 4 m).
pub(super) const CONNECTED_M: f64 = 0.16;
/// Greatest angle between a point's normal and a primitive's: estimated normals are that coarse.
pub(super) const CONSENSUS_ANGLE_RAD: f64 = 0.6;
/// The same where normals come with the points: measured normals are good to some 10 deg; wide
/// enough for those, half of what estimated ones want.
pub(super) const GIVEN_NORMALS_ANGLE_RAD: f64 = 0.45;
/// Least share of the points that makes a part.
pub(super) const LEAST_PART_SHARE: f64 = 0.08;
/// Probability with which no larger primitive was overlooked (Schnabel's 1 - p_t).
pub(super) const PROBABILITY: f64 = 0.99;

// Drawing (Schnabel section 4.3).

/// Draws between two looks at the candidates.
pub(super) const BATCH: usize = 32;
/// Draws per primitive at most: bounds the time where primitives of a thousandth are asked for.
pub(super) const MOST_DRAWS: usize = 40_000;
/// Bits per axis of a Morton key: cells down to 1/1024 of the cloud, finer than sampling wants.
pub(super) const MORTON_BITS: u32 = 10;
/// The finest cells drawn from are this many epsilons wide; in smaller ones noise drowns the shape.
pub(super) const LEAST_CELL_EPSILONS: f64 = 4.0;
/// Share of the draws that is spread evenly over the levels, whatever they scored (Schnabel's
/// x = 0.9).
pub(super) const EVEN_SHARE: f64 = 0.1;
/// Share of the sets on one surface whose noise leaves them of use: measured at 5 deg on normals
/// (a ball, 30 and 50 % outliers, 200 seeds each), where Schnabel's 1 misses 2.5 % for 1 % stated.
pub(super) const USABLE_SETS: f64 = 0.25;
/// Radii beyond this many diagonals of the cloud are planes.
pub(super) const LARGEST_DIAGONALS: f64 = 3.0;
/// Least sine between normals that fix an axis: 6 deg, about the error of good normals.
pub(super) const LEAST_SINE: f64 = 0.1;
/// A minimal set lies this many epsilons from its own surface at most: two noisy normals place a
/// surface less well than the fit that follows.
pub(super) const OWN_EPSILONS: f64 = 2.0;

// Scoring (Schnabel section 4.5).

/// Points of the first subset on which a candidate is scored.
pub(super) const FIRST_SUBSET: usize = 256;
/// How much larger every next subset is.
pub(super) const SUBSET_GROWTH: usize = 4;
/// Points of the random sample that search and scores look at, at least: a share of 8 % is known
/// to 0.6 % from it.
pub(super) const LEAST_SAMPLE: usize = 2048;
/// Points of the smallest primitive that the sample holds, at least.
pub(super) const LEAST_SAMPLED_INLIERS: usize = 64;
/// Standard deviations of the hypergeometric interval about a score.
pub(super) const SCORE_SIGMAS: f64 = 1.0;
/// Candidates kept between batches.
pub(super) const MOST_CANDIDATES: usize = 48;

// Fitting.

/// Points are collected within this many epsilons for the refit (Schnabel section 4.6).
pub(super) const REFIT_EPSILONS: f64 = 3.0;
/// Candidates are improved by a fit to points of the sample at most this many...
pub(super) const POLISH_POINTS: usize = 384;
/// ... found among at most this many.
pub(super) const POLISH_SUBSET: usize = 1024;
/// Points that take part in the refit: its error is then a fortieth of the noise.
pub(super) const REFIT_POINTS: usize = 2048;
/// A refit that moves the surface by less than this many epsilons leaves the inliers as they are.
pub(super) const SETTLED_EPSILONS: f64 = 0.1;
/// Rounds of refitting and collecting again, at most.
pub(super) const REFIT_ROUNDS: usize = 3;
/// Gauss-Newton steps at most; starts are close, so it settles in a few.
pub(super) const MOST_STEPS: usize = 12;
/// A step smaller than this share of the size ends a fit: f32 coordinates know no more.
pub(super) const LEAST_STEP: f64 = 1e-7;
/// A simpler class with this share of the inliers is preferred.
pub(super) const SIMPLER_SHARE: f64 = 0.97;

// Classes of one thing.

/// Points that judge a class: beyond, the misfit of the ideal shape tells more than the noise.
pub(super) const JUDGED_POINTS: usize = 1024;
/// A thing's own surface holds at least this share of its points.
pub(super) const LEAST_THING_SHARE: f64 = 0.3;
/// A thing's radius is at most this share of the diagonal about its points: one sees the whole
/// near side, so it is no wider than what is seen.
pub(super) const LARGEST_THING_DIAGONALS: f64 = 0.5;
/// Surfaces of each class that are fitted.
pub(super) const KEPT_PER_CLASS: usize = 3;
/// Points within so many standard deviations take part in one fit after the other.
pub(super) const TRIMS_SIGMAS: [f64; 3] = [6.0, 4.0, 3.0];

// Extents.

/// Points that tell where a surface ends: their spacing is a fortieth of its width.
pub(super) const EXTENT_POINTS: usize = 2048;
/// Fewer points than this end with their outermost one: their density is not known well enough.
pub(super) const LEAST_EXTENT_POINTS: usize = 200;
/// Points of which one window tells a density: one in this many, ...
pub(super) const WINDOW_SHARE: usize = 128;
/// ... and at least so many, whose density is known to a third.
pub(super) const LEAST_WINDOW: usize = 8;
/// A surface ends where its points are this share as dense as in its middle. Strays within
/// epsilon are a tenth as dense or less; a disc loses 2 % of its width.
pub(super) const END_DENSITY: f64 = 0.33;
/// Cells per side of the grid that tells strays beyond a rectangle from its own points.
pub(super) const EXTENT_GRID: usize = 16;
/// Cells with less than this share of the median point's company hold strays.
pub(super) const SPARSE_SHARE: f64 = 0.2;
/// Points that decide how a rectangle is turned within its plane.
pub(super) const RECTANGLE_POINTS: usize = 512;

// Connectivity (Schnabel section 4.4).

/// Pixels of a bitmap at most; cells grow where a surface would need more (a 4 m wall in 2 mm).
pub(super) const MOST_PIXELS: usize = 1 << 22;
/// Cells are at least this many epsilons wide.
pub(super) const CELL_EPSILONS: f64 = 2.0;
/// Cells are at least this many times the distance to the sixth neighbour where none are given.
pub(super) const CELL_SPACINGS: f64 = 2.0;

/// Points that tell how far apart neighbours are.
pub(super) const SPACING_POINTS: usize = 512;
/// Points of those that are asked for theirs.
pub(super) const SPACING_QUERIES: usize = 64;

// Samples on ellipsoids.

/// Least semi-axis, metres: keeps flat components invertible.
pub(super) const LEAST_AXIS_M: f64 = 1e-4;
/// Draws per sample at most; components hidden inside others give none.
pub(super) const DRAWS_PER_SAMPLE: usize = 50;
