//! Efficient RANSAC: draw locally, score by subsets, take the best once a better one is unlikely
//! to have been overlooked, refit it.

use super::candidate::{Candidate, chance, found};
use super::cloud::Cloud;
use super::constants::{
    BATCH, FIRST_SUBSET, LEAST_SAMPLE, LEAST_SAMPLED_INLIERS, MOST_CANDIDATES, MOST_DRAWS,
    POLISH_POINTS, POLISH_SUBSET, REFIT_EPSILONS, REFIT_POINTS, REFIT_ROUNDS, SETTLED_EPSILONS,
    SIMPLER_SHARE, SUBSET_GROWTH,
};
use super::fit::{fitted, plane};
use super::minimal::suggested;
use super::octree::{Levels, Octree};
use super::patch::largest_patch;
use super::sample::Sample;
use super::score::{Tolerance, collect, count};
use super::surface::Surface;
use crate::mixture::Instructions;
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;

/// What is searched for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Search {
    pub tolerance: Tolerance,
    /// Least number of inliers.
    pub min_points: usize,
    /// Wanted certainty that nothing larger was overlooked.
    pub probability: f64,
    /// Side of the cells through which inliers hang together, metres.
    pub cell_m: f64,
    /// Greatest radius, metres.
    pub largest_m: f64,
    pub instructions: Instructions,
}

impl Search {
    /// The next surface among the points of `cloud` and the places of its inliers there, rising;
    /// `None` if there is none left that the settings would want found.
    pub fn next(&self, cloud: &Cloud, rng: &mut ChaCha8Rng) -> Option<(Surface, Vec<u32>)> {
        let least = self.min_points as f64 / cloud.len() as f64;
        let wanted = (LEAST_SAMPLED_INLIERS as f64 / least).ceil() as usize;
        let sample = cloud.sample(wanted.max(LEAST_SAMPLE), rng);
        let n = sample.len();
        let octree = Octree::new(&sample, self.tolerance.epsilon_m);
        let mut levels = Levels::new(octree.levels);
        let mut candidates: Vec<Candidate> = Vec::new();
        let mut draws = 0;
        loop {
            for _ in 0..BATCH {
                self.draw(&sample, &octree, &mut levels, &mut candidates, least, rng);
            }
            draws += BATCH;
            levels.reweigh();
            candidates.sort_by(|a, b| b.upper(n).total_cmp(&a.upper(n)));
            candidates.truncate(MOST_CANDIDATES);
            let sure = |share| found(chance(share, octree.levels), draws) >= self.probability;
            let last = sure(least) || draws >= MOST_DRAWS;
            while let Some(best) = self.best(&mut candidates, &sample) {
                let (share, _) = best.share(n);
                // Where all was drawn that will be, what may be large enough is looked at in full.
                let enough = if last { best.upper(n) } else { share };
                if enough < least || !(last || sure(share)) {
                    candidates.push(best);
                    break;
                }
                if let Some(found) = self.settled(&best.surface, &sample, cloud) {
                    return Some(found);
                }
                // Its points do not hang together: it was never one surface.
                levels.credit(best.level, -share);
            }
            if last {
                return None;
            }
        }
    }

    fn draw(
        &self,
        sample: &Sample,
        octree: &Octree,
        levels: &mut Levels,
        candidates: &mut Vec<Candidate>,
        least: f64,
        rng: &mut ChaCha8Rng,
    ) {
        let level = levels.draw(rng);
        let Some(drawn) = octree.draw(level, rng) else {
            return;
        };
        let three = drawn.map(|k| (sample.place(k), sample.normal(k)));
        for surface in suggested(&three, self.tolerance, self.largest_m) {
            let mut candidate = Candidate::new(surface, level);
            self.extend(&mut candidate, sample, FIRST_SUBSET);
            levels.credit(level, candidate.share(sample.len()).0);
            if candidate.upper(sample.len()) >= least {
                candidates.push(candidate);
            }
        }
    }

    /// Scores on all points of the sample before `to`.
    fn extend(&self, c: &mut Candidate, sample: &Sample, to: usize) {
        let to = to.min(sample.len());
        let range = c.seen..to;
        c.hits += count(self.instructions, &c.surface, self.tolerance, sample, range);
        c.seen = c.seen.max(to);
    }

    /// Takes out the best candidate; promising ones are fitted and scored on more of the sample
    /// until one stands out.
    fn best(&self, candidates: &mut Vec<Candidate>, sample: &Sample) -> Option<Candidate> {
        let n = sample.len();
        loop {
            let top = (0..candidates.len())
                .rev()
                .max_by(|&a, &b| candidates[a].upper(n).total_cmp(&candidates[b].upper(n)))?;
            let best = candidates.get_mut(top)?;
            if !best.polished {
                self.polish(best, sample);
            } else if best.seen < n {
                self.extend(best, sample, SUBSET_GROWTH * best.seen.max(FIRST_SUBSET));
            } else {
                return Some(candidates.swap_remove(top));
            }
        }
    }

    /// A minimal set places a surface roughly; a fit to what lies near it brings it home.
    fn polish(&self, candidate: &mut Candidate, sample: &Sample) {
        candidate.polished = true;
        let wide = self.tolerance.widened(REFIT_EPSILONS);
        let subset = 0..POLISH_SUBSET.min(sample.len());
        for _ in 0..REFIT_ROUNDS {
            let near = collect(
                self.instructions,
                &candidate.surface,
                wide,
                sample,
                subset.clone(),
            );
            let surface = fitted(
                &candidate.surface,
                &some(&near, POLISH_POINTS, |k| sample.place(k)),
            );
            if surface.radius_m().is_some_and(|r| r > self.largest_m) {
                return;
            }
            let mut better = Candidate {
                surface,
                seen: 0,
                hits: 0,
                ..*candidate
            };
            self.extend(&mut better, sample, candidate.seen);
            if better.hits <= candidate.hits {
                return;
            }
            *candidate = better;
        }
    }

    /// The largest connected patch of points on `surface`.
    pub fn patch(&self, surface: &Surface, tolerance: Tolerance, cloud: &Cloud) -> Vec<u32> {
        largest_patch(self.instructions, surface, tolerance, cloud, self.cell_m)
    }

    /// The surface refitted to its patch in all of the cloud, or a simpler one that does as well;
    /// `None` if too few points hang together.
    fn settled(
        &self,
        surface: &Surface,
        sample: &Sample,
        cloud: &Cloud,
    ) -> Option<(Surface, Vec<u32>)> {
        let (surface, inliers) = self.refitted(surface, sample, cloud)?;
        let own = some(&inliers, REFIT_POINTS, |k| cloud.place(k));
        let simpler = self.simpler(&surface, &own);
        let simpler = simpler.and_then(|other| self.refitted(&other, sample, cloud));
        let as_good = |kept: &[u32]| kept.len() as f64 >= SIMPLER_SHARE * inliers.len() as f64;
        Some(
            simpler
                .filter(|(_, kept)| as_good(kept))
                .unwrap_or((surface, inliers)),
        )
    }

    /// Refits on what lies within three epsilons, then on the inliers while that moves it.
    fn refitted(
        &self,
        surface: &Surface,
        sample: &Sample,
        cloud: &Cloud,
    ) -> Option<(Surface, Vec<u32>)> {
        let wide = self.tolerance.widened(REFIT_EPSILONS);
        let mut surface = if sample.len() < cloud.len() {
            // The sample holds enough for a first fit, but is too thin to hang together.
            let near = 0..sample.len();
            let near = collect(self.instructions, surface, wide, sample, near);
            fitted(surface, &some(&near, REFIT_POINTS, |k| sample.place(k)))
        } else {
            let patch = self.patch(surface, wide, cloud);
            if patch.len() < self.min_points {
                return None;
            }
            fitted(surface, &some(&patch, REFIT_POINTS, |k| cloud.place(k)))
        };
        let mut inliers = self.patch(&surface, self.tolerance, cloud);
        for _ in 0..REFIT_ROUNDS {
            if inliers.len() < self.min_points {
                return None;
            }
            let own = some(&inliers, REFIT_POINTS, |k| cloud.place(k));
            let again = fitted(&surface, &own);
            let moved = |p: &Vector3<f64>| (again.distance_m(p) - surface.distance_m(p)).abs();
            let moved_m = own.iter().map(moved).fold(0.0, f64::max);
            surface = again;
            if moved_m < SETTLED_EPSILONS * self.tolerance.epsilon_m {
                break;
            }
            inliers = self.patch(&surface, self.tolerance, cloud);
        }
        // Points of a flat patch can draw a radius out without end.
        let sane = surface.radius_m().is_none_or(|r| r <= self.largest_m);
        (sane && inliers.len() >= self.min_points).then_some((surface, inliers))
    }

    /// A surface of fewer parameters that holds as many of `own` points: a huge ball is a plane.
    fn simpler(&self, surface: &Surface, own: &[Vector3<f64>]) -> Option<Surface> {
        let mean = own.iter().sum::<Vector3<f64>>() / (own.len() as f64).max(1.0);
        let ball = |point: Vector3<f64>, axis: &Vector3<f64>, radius_m| {
            let centre = point + axis * axis.dot(&(mean - point));
            fitted(&Surface::Sphere { centre, radius_m }, own)
        };
        let tried = match surface {
            Surface::Plane { .. } => [None, None],
            Surface::Sphere { .. } => [plane(own), None],
            Surface::Cylinder {
                point,
                axis,
                radius_m,
            } => [plane(own), Some(ball(*point, axis, *radius_m))],
        };
        let near = |other: &Surface| {
            let epsilon_m = self.tolerance.epsilon_m;
            own.iter()
                .filter(|p| other.distance_m(p).abs() < epsilon_m)
                .count()
        };
        tried
            .into_iter()
            .flatten()
            .find(|other| near(other) as f64 >= SIMPLER_SHARE * own.len() as f64)
    }
}

/// Where the points at `places` lie; an even selection of at most about `most`.
fn some(places: &[u32], most: usize, at: impl Fn(u32) -> Vector3<f64>) -> Vec<Vector3<f64>> {
    let stride = places.len().div_ceil(most).max(1);
    places.iter().step_by(stride).map(|&k| at(k)).collect()
}
