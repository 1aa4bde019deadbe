//! Missing returns that prove nothing: where a surface goes on across the edge of what did not come back, the other view lost
//! sight of it, and nothing was taken away (`docs/novelty.md section 5`).
//!
//! A thing that is gone ends at its own outline, where the ranges jump. A gap of the sensor, a field of view that is smaller
//! than before, and something that swallows light all cut through surfaces that go on beside them.

use super::constants::{LOOKED_AT_SPACINGS, ON_PLANE_SIGMAS, STRAY_SHARE};
use super::{Evidence, NoveltySettings, ObserverView, PreparedView, Visibility};
use crate::geometry::SurfacePatch;
use nalgebra::Point3;
use std::ops::RangeInclusive;

/// Points of one view that the other lost: they deviate, no beam went through them, and they are neighbours by direction.
#[derive(Debug)]
struct LostSet {
    points: Vec<usize>,
    /// Pairs of neighbours across its edge where the surface goes on.
    goes_on: usize,
    /// Pairs of neighbours across its edge where it ends.
    ends: usize,
    /// It lies nearer or farther than anything that the observer got a return from.
    is_beyond_returns: bool,
}

impl LostSet {
    /// Whether it is a part of a surface that the observer lost, and no thing that is gone.
    fn is_cut(&self) -> bool {
        self.goes_on > self.ends || self.is_beyond_returns
    }
}

/// Takes back what `evidence` says about the points of `own` that no beam of the view `observer` went through and that are only a
/// part of a surface: they are out of its view.
pub(super) fn hide_cut_surfaces(
    own: &PreparedView,
    evidence: &mut [Evidence],
    observer: &ObserverView<'_>,
    settings: &NoveltySettings,
) {
    let sets = LostPoints::new(own, evidence, observer, settings).sets();
    for i in sets.iter().filter(|s| s.is_cut()).flat_map(|s| &s.points) {
        evidence[*i] = Evidence::none(Visibility::OutOfView);
    }
}

struct LostPoints<'a> {
    own: &'a PreparedView,
    evidence: &'a [Evidence],
    observer: &'a ObserverView<'a>,
    settings: &'a NoveltySettings,
    is_lost: Vec<bool>,
}

impl<'a> LostPoints<'a> {
    fn new(
        own: &'a PreparedView,
        evidence: &'a [Evidence],
        observer: &'a ObserverView<'a>,
        settings: &'a NoveltySettings,
    ) -> Self {
        let mut lost = Self {
            own,
            evidence,
            observer,
            settings,
            is_lost: Vec::new(),
        };
        lost.is_lost = evidence
            .iter()
            .enumerate()
            .map(|(i, e)| lost.deviates(e) && !is_looked_at(own, i, observer))
            .collect();
        lost
    }

    fn deviates(&self, e: &Evidence) -> bool {
        e.z.max(e.z_loose) >= self.settings.segment.grow_sigmas
    }

    fn sets(&self) -> Vec<LostSet> {
        let seen_m = returned_ranges_m(self.observer.view);
        let mut is_taken = vec![false; self.is_lost.len()];
        let mut sets = Vec::new();
        for first in 0..self.is_lost.len() {
            if self.is_lost[first] && !is_taken[first] {
                sets.push(self.set_of(first, &mut is_taken, &seen_m));
            }
        }
        sets
    }

    /// The set of point `first`; its points are marked as taken.
    fn set_of(&self, first: usize, is_taken: &mut [bool], seen_m: &RangeInclusive<f64>) -> LostSet {
        let mut set = LostSet {
            points: vec![first],
            goes_on: 0,
            ends: 0,
            is_beyond_returns: false,
        };
        is_taken[first] = true;
        let mut sum_m = 0.0;
        let mut visited = 0;
        while let Some(i) = set.points.get(visited).copied() {
            visited += 1;
            let p = self
                .observer
                .observer_from_own
                .apply(&self.own.view.points[i]);
            sum_m += (p - self.observer.view.rays.origin()).norm();
            for neighbour in neighbours(self.own, i) {
                if self.is_lost.get(neighbour) == Some(&true) {
                    if !is_taken[neighbour] {
                        is_taken[neighbour] = true;
                        set.points.push(neighbour);
                    }
                } else {
                    match self.ends_between(i, neighbour) {
                        Some(true) => set.ends += 1,
                        Some(false) => set.goes_on += 1,
                        None => {}
                    }
                }
            }
        }
        set.is_beyond_returns = !seen_m.contains(&(sum_m / set.points.len() as f64));
        set
    }

    /// Whether the thing ends between the lost point `i` and its neighbour outside the set, or goes on; `None`: not known.
    fn ends_between(&self, i: usize, neighbour: usize) -> Option<bool> {
        let Some(beside) = self.evidence.get(neighbour) else {
            // Nothing came back beside it.
            return Some(true);
        };
        let goes_on = goes_on(self.own, i, neighbour, self.settings.evidence.grazing_cos);
        if self.deviates(beside) {
            // Looked through: this part of the surface is gone, and so is the rest of it.
            return (goes_on == Some(true)).then_some(true);
        }
        match goes_on {
            Some(true) => Some(false),
            Some(false) if is_looked_at(self.own, neighbour, self.observer) => Some(true),
            _ => None,
        }
    }
}

/// The ranges between which a view has all returns but strays, metres.
pub(super) fn returned_ranges_m(view: &PreparedView) -> RangeInclusive<f64> {
    let mut ranges_m: Vec<f64> = view
        .view
        .points
        .iter()
        .map(|p| (p - view.view.origin).norm())
        .collect();
    let strays = (STRAY_SHARE * ranges_m.len() as f64) as usize;
    let last = ranges_m.len().saturating_sub(1);
    let mut at = |k: usize| match ranges_m.is_empty() {
        true => 0.0,
        false => {
            *ranges_m
                .select_nth_unstable_by(k.min(last), f64::total_cmp)
                .1
        }
    };
    at(strays)..=at(last - strays.min(last))
}

/// The rays around point `i`.
fn neighbours(own: &PreparedView, i: usize) -> impl Iterator<Item = usize> {
    let direction = (own.view.points[i] - own.view.origin).try_normalize(1e-9);
    let around = direction.map(|d| own.rays.neighbours(&d).sectors);
    around.into_iter().flatten().flatten().map(|(ray, _)| ray)
}

/// Whether the observer's beam nearest to the direction of point `i` came back and is as near as the pattern is dense: beyond the
/// edge of a gap, what it saw on this side says nothing.
fn is_looked_at(own: &PreparedView, i: usize, observer: &ObserverView<'_>) -> bool {
    let p = &own.view.points[i];
    let rays = &observer.view.rays;
    let towards = observer.observer_from_own.apply(p) - rays.origin();
    let (Some(own_d), Some(d)) = (
        (p - own.view.origin).try_normalize(1e-9),
        towards.try_normalize(1e-9),
    ) else {
        return false;
    };
    let angles = own.rays.neighbours(&own_d).sectors;
    let apart_rad = angles
        .iter()
        .flatten()
        .filter(|(ray, _)| *ray != i)
        .fold(f64::INFINITY, |least, (_, angle)| least.min(*angle));
    let coarser = (own.rays.mean_density_per_sr / rays.mean_density_per_sr)
        .max(1.0)
        .sqrt();
    let within_rad = (LOOKED_AT_SPACINGS * coarser * apart_rad).min(rays.spacing_rad);
    let nearest = rays.neighbours(&d).nearest;
    nearest.is_some_and(|(ray, off_rad)| {
        off_rad <= within_rad && !observer.view.is_without_return(ray)
    })
}

/// Whether two neighbouring points lie on one surface: each on the plane around the other, within its thickness and the noise.
/// Where one of them has no plane, the ranges decide; `None` where they might jump.
fn goes_on(own: &PreparedView, a: usize, b: usize, grazing_cos: f64) -> Option<bool> {
    let [p, q] = [a, b].map(|i| own.view.points[i]);
    let range_m = |p: &Point3<f64>| (p - own.view.origin).norm();
    let plane = |i: usize| {
        let cell = own.surfaces.patch_of_point.get(i)?;
        let patch = own.surfaces.patches.get(*cell as usize)?;
        patch.flat.then_some(patch)
    };
    let is_on = |patch: &SurfacePatch, other: &Point3<f64>| {
        let noise_m = own.noise.sigma_m(range_m(other));
        patch.height_m(other).abs() < ON_PLANE_SIGMAS * noise_m.hypot(patch.roughness_m)
    };
    if let (Some(of_a), Some(of_b)) = (plane(a), plane(b)) {
        return Some(is_on(of_a, &q) && is_on(of_b, &p));
    }
    let jump_m = (range_m(&p) - range_m(&q)).abs();
    if jump_m
        < ON_PLANE_SIGMAS
            * own
                .noise
                .sigma_m(range_m(&p))
                .hypot(own.noise.sigma_m(range_m(&q)))
    {
        return Some(true);
    }
    // No surface is met so flatly that it may give no return.
    (jump_m * grazing_cos > own.rays.spacing_rad * range_m(&p)).then_some(false)
}
