//! Constants of method A, with unit and origin. "Schnabel" is Schnabel, Wahl, Klein 2007, "Efficient RANSAC for point-cloud
//! shape detection".

// Defaults of the settings.

/// Side of the cells through which a primitive is connected, metres: the gap that is bridged within one novelty
/// (docs/novelty.md section 6; 16 rings of a coarse scanner at 4 m).
pub(super) const CONNECTIVITY_CELL_M: f64 = 0.16;
/// Greatest angle between a point's normal and a primitive's: estimated normals are that coarse.
pub(super) const CONSENSUS_ANGLE_RAD: f64 = 0.6;
/// The same for measured normals, which are good to some 10 deg.
pub(super) const GIVEN_NORMALS_ANGLE_RAD: f64 = 0.45;
/// Least share of the points in a part.
pub(super) const MIN_PART_SHARE: f64 = 0.08;
/// Probability that no larger primitive was missed (Schnabel's 1 - p_t).
pub(super) const DETECTION_PROBABILITY: f64 = 0.99;

// Drawing (Schnabel section 4.3).

/// Draws before the candidates are compared.
pub(super) const DRAWS_PER_BATCH: usize = 32;
/// Draws per primitive at most: bounds the time where primitives of a thousandth of the points are wanted.
pub(super) const MAX_DRAWS: usize = 40_000;
/// Bits per axis of a Morton key: cells down to 1/1024 of the cloud, finer than sampling needs.
pub(super) const MORTON_BITS: u32 = 10;
/// The finest cells drawn from are this many epsilons wide; in smaller ones noise hides the shape.
pub(super) const MIN_CELL_EPSILONS: f64 = 4.0;
/// Share of the draws that is uniform over the levels, whatever their scores (Schnabel's x = 0.9).
pub(super) const UNIFORM_LEVEL_SHARE: f64 = 0.1;
/// Share of the sets on one surface that are usable despite their noise: measured with 5 deg on normals (a sphere, 30 and
/// 50 % outliers, 200 seeds each), where Schnabel's 1 misses 2.5 % instead of 1 %.
pub(super) const USABLE_SET_SHARE: f64 = 0.25;
/// Surfaces with radii beyond this many diagonals of the cloud are planes.
pub(super) const MAX_RADIUS_DIAGONALS: f64 = 3.0;
/// Least sine of the angle between normals that fix an axis: 6 deg, about the error of good normals.
pub(super) const MIN_SINE: f64 = 0.1;
/// Distance of a minimal set from its own surface at most, in epsilons: noisy normals place a surface less well than the
/// fit that follows.
pub(super) const MINIMAL_SET_EPSILONS: f64 = 2.0;

// Scoring (Schnabel section 4.5).

/// Points of the first subset on which a candidate is scored.
pub(super) const FIRST_SUBSET: usize = 256;
/// Ratio of the sizes of successive subsets.
pub(super) const SUBSET_GROWTH: usize = 4;
/// Least size of the random sample that is searched and scored: a share of 8 % is known to 0.6 % from it.
pub(super) const MIN_SAMPLE: usize = 2048;
/// Least expected number of points of the smallest primitive in the sample.
pub(super) const MIN_SAMPLED_INLIERS: usize = 64;
/// Standard deviations of the hypergeometric interval about a score.
pub(super) const SCORE_SIGMAS: f64 = 1.0;
/// Candidates kept between batches.
pub(super) const MAX_CANDIDATES: usize = 48;

// Fitting.

/// Points are collected within this many epsilons for the refit (Schnabel section 4.6).
pub(super) const REFIT_EPSILONS: f64 = 3.0;
/// Points of the sample to which a candidate is fitted, at most ...
pub(super) const POLISH_POINTS: usize = 384;
/// ... among this many.
pub(super) const POLISH_SUBSET: usize = 1024;
/// Points of the refit: its error is then a fortieth of the noise.
pub(super) const REFIT_POINTS: usize = 2048;
/// A refit that moves the surface by less than this many epsilons has converged.
pub(super) const CONVERGED_EPSILONS: f64 = 0.1;
/// Rounds of refitting and collecting again, at most.
pub(super) const REFIT_ROUNDS: usize = 3;
/// Gauss-Newton steps at most; starts are close, so it converges in a few.
pub(super) const MAX_FIT_STEPS: usize = 12;
/// A step smaller than this share of the size ends a fit: the precision of f32 coordinates.
pub(super) const MIN_STEP: f64 = 1e-7;
/// A simpler class with this share of the inliers is preferred.
pub(super) const SIMPLER_SHARE: f64 = 0.97;

// Classes of a single object.

/// Points to which the classes are fitted: beyond, the misfit of the ideal shape matters more than the noise.
pub(super) const CLASS_POINTS: usize = 1024;
/// Least share of an object's points on its surface.
pub(super) const MIN_OBJECT_SHARE: f64 = 0.3;
/// Greatest radius of an object, as a share of the diagonal of its points: the whole near side is visible, so the object is
/// no wider than its points.
pub(super) const MAX_OBJECT_RADIUS_DIAGONALS: f64 = 0.5;
/// Starts of each class that are fitted.
pub(super) const STARTS_PER_CLASS: usize = 3;
/// Standard deviations within which points take part in the successive fits.
pub(super) const TRIM_SIGMAS: [f64; 3] = [6.0, 4.0, 3.0];

// Extents.

/// Points from which an extent is measured: their spacing is a fortieth of the width.
pub(super) const EXTENT_POINTS: usize = 2048;
/// With fewer points, the outermost one is the end: their density is not known well enough.
pub(super) const MIN_EXTENT_POINTS: usize = 200;
/// Share of the points in a window of which the density is taken: one in this many, ...
pub(super) const WINDOW_SHARE: usize = 128;
/// ... and at least so many points, whose density is known to a third.
pub(super) const MIN_WINDOW: usize = 8;
/// A surface ends where its density is this share of that in the middle. Foreign points within epsilon are a tenth as dense
/// or less; a disc loses 2 % of its width.
pub(super) const END_DENSITY: f64 = 0.33;
/// Cells per side of the grid that separates the points of a rectangle from foreign ones around it.
pub(super) const EXTENT_GRID: usize = 16;
/// Cells with less than this share of the points in the median point's cell are sparse.
pub(super) const SPARSE_SHARE: f64 = 0.2;
/// Points that decide the rotation of a rectangle within its plane.
pub(super) const RECTANGLE_POINTS: usize = 512;

// Connectivity (Schnabel section 4.4).

/// Pixels of a bitmap at most; cells are enlarged where a surface would need more (a 4 m wall in 2 mm).
pub(super) const MAX_PIXELS: usize = 1 << 22;
/// Cells are at least this many epsilons wide.
pub(super) const MIN_CONNECTIVITY_EPSILONS: f64 = 2.0;
/// Cells are at least this many times the distance to the sixth neighbour where none are given.
pub(super) const CONNECTIVITY_SPACINGS: f64 = 2.0;

/// Points from which the spacing is measured ...
pub(super) const SPACING_POINTS: usize = 512;
/// ... at this many of them.
pub(super) const SPACING_QUERIES: usize = 64;

// Samples on ellipsoids.

/// Least semi-axis, metres: keeps flat components invertible.
pub(super) const MIN_SEMI_AXIS_M: f64 = 1e-4;
/// Draws per sample at most; components inside others give none.
pub(super) const DRAWS_PER_SAMPLE: usize = 50;
