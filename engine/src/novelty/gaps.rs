//! Missing returns that prove nothing: where a surface goes on across the edge of what did not come back, the other view lost
//! sight of it, and nothing was taken away (`docs/novelty.md section 5`).
//!
//! A thing that is gone ends at its own outline, where the ranges jump. A gap of the sensor, a field of view that is smaller
//! than before, and something that swallows light all cut through surfaces that go on beside them.

use super::constants::{LOOKED_AT_SPACINGS, ON_PLANE_SIGMAS, STRAY_SHARE};
use super::{Evidence, NoveltySettings, ObserverView, PreparedView, Visibility};
use crate::geometry::SurfacePatch;
use nalgebra::Point3;

/// Takes back what `evidence` says about the points of `own` that no beam of the view `observer` went through and that are only a
/// part of a surface: they are out of its view.
pub(super) fn hide_cut_surfaces(
    own: &PreparedView,
    evidence: &mut [Evidence],
    observer: &ObserverView<'_>,
    settings: &NoveltySettings,
) {
    let deviates = |e: &Evidence| e.z.max(e.z_loose) >= settings.segment.grow_sigmas;
    let goes_on = |a: usize, b: usize| goes_on(own, a, b, settings.evidence.grazing_cos);
    let seen_m = returned_ranges_m(observer.view);
    let is_lost: Vec<bool> = evidence
        .iter()
        .enumerate()
        .map(|(i, e)| deviates(e) && !is_looked_at(own, i, observer))
        .collect();
    // Number of the set of lost points that belong together, by their directions.
    let mut set_of = vec![NO_SET; evidence.len()];
    let mut edges: Vec<Edge> = Vec::new();
    for first in 0..evidence.len() {
        if !is_lost[first] || set_of[first] != NO_SET {
            continue;
        }
        let mut edge = Edge::default();
        let (mut sum_m, mut count) = (0.0, 0.0);
        let mut reached = vec![first];
        set_of[first] = edges.len();
        while let Some(i) = reached.pop() {
            let p = observer.observer_from_own.apply(&own.view.points[i]);
            sum_m += (p - observer.view.rays.origin()).norm();
            count += 1.0;
            for neighbour in neighbours(own, i) {
                match evidence.get(neighbour) {
                    // Nothing beside it: the thing ended here.
                    None => edge.ends += 1,
                    Some(e) if !deviates(e) => match goes_on(i, neighbour) {
                        Some(true) => edge.goes_on += 1,
                        Some(false) if is_looked_at(own, neighbour, observer) => edge.ends += 1,
                        _ => {}
                    },
                    Some(_) if is_lost[neighbour] => {
                        if set_of[neighbour] == NO_SET {
                            set_of[neighbour] = edges.len();
                            reached.push(neighbour);
                        }
                    }
                    // Looked through: this part of the surface is gone, and so is the rest of it.
                    Some(_) if goes_on(i, neighbour) == Some(true) => edge.ends += 1,
                    Some(_) => {}
                }
            }
        }
        edge.is_beyond_returns = !seen_m.contains(&(sum_m / count));
        edges.push(edge);
    }
    for (set, evidence) in set_of.into_iter().zip(evidence) {
        if edges.get(set).is_some_and(Edge::is_cut) {
            *evidence = Evidence::none(Visibility::OutOfView);
        }
    }
}

const NO_SET: usize = usize::MAX;

/// The pairs of neighbours across the edge of a set, by whether the surface goes on.
#[derive(Default)]
struct Edge {
    goes_on: usize,
    ends: usize,
    /// The set lies nearer or farther than anything that the observer got a return from.
    is_beyond_returns: bool,
}

impl Edge {
    /// Whether the set is a part that the observer lost, and no thing that is gone.
    fn is_cut(&self) -> bool {
        self.goes_on > self.ends || self.is_beyond_returns
    }
}

/// The ranges between which a view has all returns but strays, metres.
fn returned_ranges_m(view: &PreparedView) -> std::ops::RangeInclusive<f64> {
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
