//! One thing, of which class: the best surface of every class on the same points, and what each
//! costs.
//!
//! Where many primitives are sought the one with most inliers comes first. Of one small thing that
//! is no judge: a bent surface holds the points of a flat one as well, and normals of noisy points
//! tell little. So every class is drawn, fitted to the points alone, and pays for what it leaves
//! unexplained and for its parameters (the Bayesian information criterion of a truncated normal).

use super::candidate::{chance, found};
use super::cloud::Cloud;
use super::constants::{
    BATCH, JUDGED_POINTS, KEPT_PER_CLASS, LARGEST_THING_DIAGONALS, LEAST_THING_SHARE, MOST_DRAWS,
    TRIMS_SIGMAS,
};
use super::detect::{Detected, RansacSettings, searched};
use super::extent::covered;
use super::fit::{fitted, plane};
use super::minimal::suggested;
use super::octree::{Levels, Octree};
use super::sample::Sample;
use super::score::count;
use super::search::Search;
use super::surface::Surface;
use crate::shape::constants::{MOST_WITNESSES, OUTLIER_SIGMAS};
use nalgebra::{Point3, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// A class's best surface.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::shape) struct Judged {
    pub detected: Detected,
    /// -2 ln of its odds, up to a constant that all classes share.
    pub cost: f64,
}

/// The best surface of each class on `points`, cheapest first; a class without one is left out.
/// A third of `settings.epsilon_m` is taken for the standard deviation of a point, or more if no
/// class comes that near.
pub(in crate::shape) fn classes(
    points: &[Point3<f64>],
    normals: &[Vector3<f64>],
    settings: &RansacSettings,
    seed: u64,
) -> Vec<Judged> {
    let cloud = Cloud::of(points, normals);
    if cloud.len() < settings.min_points.max(3) {
        return Vec::new();
    }
    let search = Search {
        largest_m: LARGEST_THING_DIAGONALS * cloud.diagonal_m(),
        ..searched(points, &cloud, settings)
    };
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let sample = cloud.sample(JUDGED_POINTS, &mut rng);
    let at: Vec<Vector3<f64>> = (0..sample.len() as u32).map(|k| sample.place(k)).collect();
    let sigma_m = settings.epsilon_m / OUTLIER_SIGMAS;
    let best: Vec<(Surface, f64)> = starts(&search, &sample, &at, &mut rng)
        .iter()
        .filter_map(|starts| {
            let trimmed = starts.iter().map(|s| trimmed(s, &at, sigma_m));
            let sane = trimmed.filter(|s| s.radius_m().is_none_or(|r| r < search.largest_m));
            let rated = sane.map(|s| (s, misfit(&s, &at, sigma_m)));
            rated.min_by(|a, b| a.1.total_cmp(&b.1))
        })
        .collect();
    // Noise is known as a law only: the best class is not blamed for more of it.
    let least = best.iter().map(|b| b.1).fold(f64::INFINITY, f64::min);
    let sigma_m = sigma_m * least.sqrt().max(1.0);
    let witnesses = (cloud.len() as f64).min(MOST_WITNESSES);
    let mut judged: Vec<Judged> = best
        .iter()
        .filter_map(|(surface, _)| {
            let places = search.patch(surface, search.tolerance, &cloud);
            let parameters = surface.parameters() as f64;
            (!places.is_empty()).then(|| Judged {
                detected: Detected {
                    primitive: covered(surface, &cloud, &places),
                    inliers: places.iter().map(|&k| k as usize).collect(),
                },
                cost: witnesses * misfit(surface, &at, sigma_m) + parameters * witnesses.ln(),
            })
        })
        .collect();
    judged.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    judged
}

/// Promising surfaces of each class.
fn starts(
    search: &Search,
    sample: &Sample,
    at: &[Vector3<f64>],
    rng: &mut ChaCha8Rng,
) -> [Vec<Surface>; 3] {
    let octree = Octree::new(sample, search.tolerance.epsilon_m);
    let mut levels = Levels::new(octree.levels);
    let mut kept: [Vec<(usize, Surface)>; 3] = Default::default();
    let thing = chance(LEAST_THING_SHARE, octree.levels);
    let mut draws = 0;
    while found(thing, draws) < search.probability && draws < MOST_DRAWS {
        for _ in 0..BATCH {
            let level = levels.draw(rng);
            let Some(drawn) = octree.draw(level, rng) else {
                continue;
            };
            let three = drawn.map(|k| (sample.place(k), sample.normal(k)));
            for surface in suggested(&three, search.tolerance, search.largest_m) {
                let all = 0..sample.len();
                let hits = count(search.instructions, &surface, search.tolerance, sample, all);
                levels.credit(level, hits as f64);
                let best = &mut kept[surface.class()];
                let place = best.partition_point(|(other, _)| *other >= hits);
                best.insert(place, (hits, surface));
                best.truncate(KEPT_PER_CLASS);
            }
        }
        draws += BATCH;
        levels.reweigh();
    }
    let mut starts: [Vec<Surface>; 3] =
        kept.map(|best| best.into_iter().map(|(_, surface)| surface).collect());
    starts[0].extend(plane(at));
    starts
}

/// `start` fitted to the points near it, nearer each time.
fn trimmed(start: &Surface, at: &[Vector3<f64>], sigma_m: f64) -> Surface {
    TRIMS_SIGMAS.iter().fold(*start, |surface, sigmas| {
        let near = |p: &&Vector3<f64>| surface.distance_m(p).abs() < sigmas * sigma_m;
        let near: Vec<Vector3<f64>> = at.iter().filter(near).copied().collect();
        fitted(&surface, &near)
    })
}

/// Mean over the points of the squared distance in standard deviations, each at most that of an
/// outlier.
fn misfit(surface: &Surface, at: &[Vector3<f64>], sigma_m: f64) -> f64 {
    let most = OUTLIER_SIGMAS * OUTLIER_SIGMAS;
    let squares = at
        .iter()
        .map(|p| (surface.distance_m(p) / sigma_m).powi(2).min(most));
    squares.sum::<f64>() / (at.len() as f64).max(1.0)
}
