//! Efficient RANSAC: draw locally, score on subsets, accept the best candidate once a better one is unlikely to have been
//! missed, refit it.

use super::candidate::{SurfaceCandidate, detection_probability, hit_probability};
use super::cloud::Cloud;
use super::constants::{
    CONVERGED_EPSILONS, DRAWS_PER_BATCH, FIRST_SUBSET, MAX_CANDIDATES, MAX_DRAWS, MIN_SAMPLE,
    MIN_SAMPLED_INLIERS, POLISH_POINTS, POLISH_SUBSET, REFIT_EPSILONS, REFIT_POINTS, REFIT_ROUNDS,
    SIMPLER_SHARE, SUBSET_GROWTH,
};
use super::fit::{fit_surface, plane};
use super::minimal::propose_surfaces;
use super::octree::{LevelWeights, Octree};
use super::patch::largest_patch;
use super::sample::PointSample;
use super::score::{Tolerance, collect_inliers, count_inliers};
use super::surface::UnboundedSurface;
use crate::mixture::InstructionSet;
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;

/// Parameters of the search.
#[derive(Debug, Clone, Copy)]
pub(super) struct SurfaceSearch {
    pub tolerance: Tolerance,
    pub min_points: usize,
    /// Probability that no larger surface was missed.
    pub probability: f64,
    /// Side of the cells through which inliers are connected, metres.
    pub cell_m: f64,
    pub max_radius_m: f64,
    pub instructions: InstructionSet,
}

impl SurfaceSearch {
    /// The next surface in `cloud` and the indices of its inliers, rising; `None` if none with `min_points` is left.
    pub(super) fn next(
        &self,
        cloud: &Cloud,
        rng: &mut ChaCha8Rng,
    ) -> Option<(UnboundedSurface, Vec<u32>)> {
        let min_share = self.min_points as f64 / cloud.len() as f64;
        let wanted = (MIN_SAMPLED_INLIERS as f64 / min_share).ceil() as usize;
        let sample = cloud.sample(wanted.max(MIN_SAMPLE), rng);
        let n = sample.len();
        let octree = Octree::new(&sample, self.tolerance.epsilon_m);
        let mut levels = LevelWeights::new(octree.levels);
        let mut candidates: Vec<SurfaceCandidate> = Vec::new();
        let mut draws = 0;
        loop {
            for _ in 0..DRAWS_PER_BATCH {
                self.draw(
                    &sample,
                    &octree,
                    &mut levels,
                    &mut candidates,
                    min_share,
                    rng,
                );
            }
            draws += DRAWS_PER_BATCH;
            levels.update();
            candidates.sort_by(|a, b| b.upper_share(n).total_cmp(&a.upper_share(n)));
            candidates.truncate(MAX_CANDIDATES);
            let sure = |share| {
                detection_probability(hit_probability(share, octree.levels), draws)
                    >= self.probability
            };
            let last = sure(min_share) || draws >= MAX_DRAWS;
            while let Some(best) = self.take_best(&mut candidates, &sample) {
                let (share, _) = best.share(n);
                // After the last draw, all candidates that may be large enough are refitted.
                let rated = if last { best.upper_share(n) } else { share };
                if rated < min_share || !(last || sure(share)) {
                    candidates.push(best);
                    break;
                }
                if let Some(found) = self.accept(&best.surface, &sample, cloud) {
                    return Some(found);
                }
                // Its points are not connected: it was no surface.
                levels.add_score(best.level, -share);
            }
            if last {
                return None;
            }
        }
    }

    fn draw(
        &self,
        sample: &PointSample,
        octree: &Octree,
        levels: &mut LevelWeights,
        candidates: &mut Vec<SurfaceCandidate>,
        min_share: f64,
        rng: &mut ChaCha8Rng,
    ) {
        let level = levels.draw(rng);
        let Some(drawn) = octree.draw(level, rng) else {
            return;
        };
        let three = drawn.map(|k| (sample.position(k), sample.normal(k)));
        for surface in propose_surfaces(&three, self.tolerance, self.max_radius_m) {
            let mut candidate = SurfaceCandidate::new(surface, level);
            self.score_up_to(&mut candidate, sample, FIRST_SUBSET);
            levels.add_score(level, candidate.share(sample.len()).0);
            if candidate.upper_share(sample.len()) >= min_share {
                candidates.push(candidate);
            }
        }
    }

    /// Scores on the points of the sample up to `to`.
    fn score_up_to(&self, c: &mut SurfaceCandidate, sample: &PointSample, to: usize) {
        let to = to.min(sample.len());
        let range = c.scored..to;
        c.inliers += count_inliers(self.instructions, &c.surface, self.tolerance, sample, range);
        c.scored = c.scored.max(to);
    }

    /// Removes and returns the best candidate; the leading one is fitted and scored on more of the sample until it stays
    /// first.
    fn take_best(
        &self,
        candidates: &mut Vec<SurfaceCandidate>,
        sample: &PointSample,
    ) -> Option<SurfaceCandidate> {
        let n = sample.len();
        loop {
            let top = (0..candidates.len()).rev().max_by(|&a, &b| {
                candidates[a]
                    .upper_share(n)
                    .total_cmp(&candidates[b].upper_share(n))
            })?;
            let best = candidates.get_mut(top)?;
            if !best.polished {
                self.polish(best, sample);
            } else if best.scored < n {
                self.score_up_to(best, sample, SUBSET_GROWTH * best.scored.max(FIRST_SUBSET));
            } else {
                return Some(candidates.swap_remove(top));
            }
        }
    }

    /// Fits a candidate, which a minimal set places only roughly, to the points near it while that adds inliers.
    fn polish(&self, candidate: &mut SurfaceCandidate, sample: &PointSample) {
        candidate.polished = true;
        let wide = self.tolerance.widened(REFIT_EPSILONS);
        let subset = 0..POLISH_SUBSET.min(sample.len());
        for _ in 0..REFIT_ROUNDS {
            let near = collect_inliers(
                self.instructions,
                &candidate.surface,
                wide,
                sample,
                subset.clone(),
            );
            let surface = fit_surface(
                &candidate.surface,
                &subsample(&near, POLISH_POINTS, |k| sample.position(k)),
            );
            if surface.radius_m().is_some_and(|r| r > self.max_radius_m) {
                return;
            }
            let mut better = SurfaceCandidate {
                surface,
                scored: 0,
                inliers: 0,
                ..*candidate
            };
            self.score_up_to(&mut better, sample, candidate.scored);
            if better.inliers <= candidate.inliers {
                return;
            }
            *candidate = better;
        }
    }

    /// The largest connected patch of inliers of `surface`.
    pub(super) fn patch(
        &self,
        surface: &UnboundedSurface,
        tolerance: Tolerance,
        cloud: &Cloud,
    ) -> Vec<u32> {
        largest_patch(self.instructions, surface, tolerance, cloud, self.cell_m)
    }

    /// The surface refitted to its patch in the whole cloud, or a simpler one with nearly as many inliers; `None` if too few
    /// points are connected.
    fn accept(
        &self,
        surface: &UnboundedSurface,
        sample: &PointSample,
        cloud: &Cloud,
    ) -> Option<(UnboundedSurface, Vec<u32>)> {
        let (surface, inliers) = self.refit(surface, sample, cloud)?;
        let own = subsample(&inliers, REFIT_POINTS, |k| cloud.position(k));
        let simpler = self.simpler_surface(&surface, &own);
        let simpler = simpler.and_then(|other| self.refit(&other, sample, cloud));
        let as_good = |kept: &[u32]| kept.len() as f64 >= SIMPLER_SHARE * inliers.len() as f64;
        Some(
            simpler
                .filter(|(_, kept)| as_good(kept))
                .unwrap_or((surface, inliers)),
        )
    }

    /// Refits to the points within `REFIT_EPSILONS`, then to the inliers while that moves the surface.
    fn refit(
        &self,
        surface: &UnboundedSurface,
        sample: &PointSample,
        cloud: &Cloud,
    ) -> Option<(UnboundedSurface, Vec<u32>)> {
        let wide = self.tolerance.widened(REFIT_EPSILONS);
        let mut surface = if sample.len() < cloud.len() {
            // The sample has enough points for a first fit, but is too sparse to be connected.
            let near = 0..sample.len();
            let near = collect_inliers(self.instructions, surface, wide, sample, near);
            fit_surface(
                surface,
                &subsample(&near, REFIT_POINTS, |k| sample.position(k)),
            )
        } else {
            let patch = self.patch(surface, wide, cloud);
            if patch.len() < self.min_points {
                return None;
            }
            fit_surface(
                surface,
                &subsample(&patch, REFIT_POINTS, |k| cloud.position(k)),
            )
        };
        let mut inliers = self.patch(&surface, self.tolerance, cloud);
        for _ in 0..REFIT_ROUNDS {
            if inliers.len() < self.min_points {
                return None;
            }
            let own = subsample(&inliers, REFIT_POINTS, |k| cloud.position(k));
            let again = fit_surface(&surface, &own);
            let moved = |p: &Vector3<f64>| (again.distance_m(p) - surface.distance_m(p)).abs();
            let moved_m = own.iter().map(moved).fold(0.0, f64::max);
            surface = again;
            if moved_m < CONVERGED_EPSILONS * self.tolerance.epsilon_m {
                break;
            }
            inliers = self.patch(&surface, self.tolerance, cloud);
        }
        // Points of a flat patch may be fitted by any radius.
        let in_range = surface.radius_m().is_none_or(|r| r <= self.max_radius_m);
        (in_range && inliers.len() >= self.min_points).then_some((surface, inliers))
    }

    /// A surface with fewer parameters and nearly as many of `own` as inliers: a huge sphere is a plane.
    fn simpler_surface(
        &self,
        surface: &UnboundedSurface,
        own: &[Vector3<f64>],
    ) -> Option<UnboundedSurface> {
        let mean = own.iter().sum::<Vector3<f64>>() / (own.len() as f64).max(1.0);
        let sphere = |point: Vector3<f64>, axis: &Vector3<f64>, radius_m| {
            let centre = point + axis * axis.dot(&(mean - point));
            fit_surface(&UnboundedSurface::Sphere { centre, radius_m }, own)
        };
        let tried = match surface {
            UnboundedSurface::Plane { .. } => [None, None],
            UnboundedSurface::Sphere { .. } => [plane(own), None],
            UnboundedSurface::Cylinder {
                point,
                axis,
                radius_m,
            } => [plane(own), Some(sphere(*point, axis, *radius_m))],
        };
        let inliers = |other: &UnboundedSurface| {
            let epsilon_m = self.tolerance.epsilon_m;
            own.iter()
                .filter(|p| other.distance_m(p).abs() < epsilon_m)
                .count()
        };
        tried
            .into_iter()
            .flatten()
            .find(|other| inliers(other) as f64 >= SIMPLER_SHARE * own.len() as f64)
    }
}

/// Positions of an even selection of at most `max` of the points at `indices`.
fn subsample(
    indices: &[u32],
    max: usize,
    position: impl Fn(u32) -> Vector3<f64>,
) -> Vec<Vector3<f64>> {
    let stride = indices.len().div_ceil(max).max(1);
    indices
        .iter()
        .step_by(stride)
        .map(|&k| position(k))
        .collect()
}
