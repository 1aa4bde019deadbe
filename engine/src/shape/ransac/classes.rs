//! The class of a single object: the best surface of every class on the same points, with its cost.
//!
//! Where many primitives are sought, the one with most inliers comes first. For one small object that does not decide: a
//! curved surface has the points of a flat one as inliers too, and normals of noisy points are inaccurate. So every class
//! is fitted to the points alone, and its cost is the Bayesian information criterion of a truncated normal distribution.

use super::candidate::{detection_probability, hit_probability};
use super::cloud::Cloud;
use super::constants::{
    CLASS_POINTS, DRAWS_PER_BATCH, MAX_DRAWS, MAX_OBJECT_RADIUS_DIAGONALS, MIN_OBJECT_SHARE,
    STARTS_PER_CLASS, TRIM_SIGMAS,
};
use super::detect::{Detected, RansacSettings, build_search};
use super::extent::bounded_primitive;
use super::fit::{fit_surface, plane};
use super::minimal::propose_surfaces;
use super::octree::{LevelWeights, Octree};
use super::sample::PointSample;
use super::score::count_inliers;
use super::search::SurfaceSearch;
use super::surface::UnboundedSurface;
use crate::shape::constants::{MAX_EFFECTIVE_POINTS, OUTLIER_SIGMAS};
use nalgebra::{Point3, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// The best surface of a class.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::shape) struct ClassFit {
    pub detected: Detected,
    /// -2 ln odds, up to a constant shared by all classes.
    pub cost: f64,
}

/// The best surface of each class on `points`, cheapest first; a class without one is left out. The standard deviation of a
/// point is a third of `settings.epsilon_m`, or more if no class fits that well.
pub(in crate::shape) fn fit_classes(
    points: &[Point3<f64>],
    normals: &[Vector3<f64>],
    settings: &RansacSettings,
    seed: u64,
) -> Vec<ClassFit> {
    let cloud = Cloud::new(points, normals);
    if cloud.len() < settings.min_points.max(3) {
        return Vec::new();
    }
    let search = SurfaceSearch {
        max_radius_m: MAX_OBJECT_RADIUS_DIAGONALS * cloud.diagonal_m(),
        ..build_search(points, &cloud, settings)
    };
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let sample = cloud.sample(CLASS_POINTS, &mut rng);
    let points: Vec<Vector3<f64>> = (0..sample.len() as u32)
        .map(|k| sample.position(k))
        .collect();
    let sigma_m = settings.epsilon_m / OUTLIER_SIGMAS;
    let best: Vec<(UnboundedSurface, f64)> = starts(&search, &sample, &points, &mut rng)
        .iter()
        .filter_map(|starts| {
            let fits = starts.iter().map(|s| trimmed_fit(s, &points, sigma_m));
            let in_range = fits.filter(|s| s.radius_m().is_none_or(|r| r < search.max_radius_m));
            let rated = in_range.map(|s| (s, misfit(&s, &points, sigma_m)));
            rated.min_by(|a, b| a.1.total_cmp(&b.1))
        })
        .collect();
    // The noise law is approximate: if even the best class leaves more, the noise is taken to be larger.
    let least = best.iter().map(|b| b.1).fold(f64::INFINITY, f64::min);
    let sigma_m = sigma_m * least.sqrt().max(1.0);
    let effective_points = (cloud.len() as f64).min(MAX_EFFECTIVE_POINTS);
    let mut fits: Vec<ClassFit> = best
        .iter()
        .filter_map(|(surface, _)| {
            let indices = search.patch(surface, search.tolerance, &cloud);
            let parameter_count = surface.parameter_count() as f64;
            (!indices.is_empty()).then(|| ClassFit {
                detected: Detected {
                    primitive: bounded_primitive(surface, &cloud, &indices),
                    inliers: indices.iter().map(|&k| k as usize).collect(),
                },
                cost: effective_points * misfit(surface, &points, sigma_m)
                    + parameter_count * effective_points.ln(),
            })
        })
        .collect();
    fits.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    fits
}

/// The surfaces of each class with most inliers.
fn starts(
    search: &SurfaceSearch,
    sample: &PointSample,
    points: &[Vector3<f64>],
    rng: &mut ChaCha8Rng,
) -> [Vec<UnboundedSurface>; 3] {
    let octree = Octree::new(sample, search.tolerance.epsilon_m);
    let mut levels = LevelWeights::new(octree.levels);
    let mut best: [Vec<(usize, UnboundedSurface)>; 3] = Default::default();
    let hit = hit_probability(MIN_OBJECT_SHARE, octree.levels);
    let mut draws = 0;
    while detection_probability(hit, draws) < search.probability && draws < MAX_DRAWS {
        for _ in 0..DRAWS_PER_BATCH {
            let level = levels.draw(rng);
            let Some(drawn) = octree.draw(level, rng) else {
                continue;
            };
            let three = drawn.map(|k| (sample.position(k), sample.normal(k)));
            for surface in propose_surfaces(&three, search.tolerance, search.max_radius_m) {
                let all = 0..sample.len();
                let inliers =
                    count_inliers(search.instructions, &surface, search.tolerance, sample, all);
                levels.add_score(level, inliers as f64);
                let best = &mut best[surface.class_index()];
                let rank = best.partition_point(|(other, _)| *other >= inliers);
                best.insert(rank, (inliers, surface));
                best.truncate(STARTS_PER_CLASS);
            }
        }
        draws += DRAWS_PER_BATCH;
        levels.update();
    }
    let mut starts: [Vec<UnboundedSurface>; 3] =
        best.map(|best| best.into_iter().map(|(_, surface)| surface).collect());
    starts[0].extend(plane(points));
    starts
}

/// `start` fitted to the points within ever fewer standard deviations.
fn trimmed_fit(
    start: &UnboundedSurface,
    points: &[Vector3<f64>],
    sigma_m: f64,
) -> UnboundedSurface {
    TRIM_SIGMAS.iter().fold(*start, |surface, sigmas| {
        let near = |p: &&Vector3<f64>| surface.distance_m(p).abs() < sigmas * sigma_m;
        let near: Vec<Vector3<f64>> = points.iter().filter(near).copied().collect();
        fit_surface(&surface, &near)
    })
}

/// Mean squared distance in standard deviations, truncated at `OUTLIER_SIGMAS`.
fn misfit(surface: &UnboundedSurface, points: &[Vector3<f64>], sigma_m: f64) -> f64 {
    let max = OUTLIER_SIGMAS * OUTLIER_SIGMAS;
    let squares = points
        .iter()
        .map(|p| (surface.distance_m(p) / sigma_m).powi(2).min(max));
    squares.sum::<f64>() / (points.len() as f64).max(1.0)
}
