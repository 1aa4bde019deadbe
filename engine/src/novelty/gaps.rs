//! Missing returns that prove nothing: where a surface goes on across the edge of what did not come back, the other view lost
//! sight of it, and nothing was taken away (`docs/novelty.md section 5`).
//!
//! A thing that is gone ends at its own outline, where the ranges jump. A gap of the sensor, a field of view that is smaller
//! than before, and something that swallows light all cut through surfaces that go on beside them.

use super::{Evidence, PreparedView, SegmentSettings, Visibility};
use crate::geometry::SurfacePatch;
use nalgebra::Point3;

/// Takes back what `evidence` says about the points of `own` that the other view got no return from and that are only a part of
/// a surface: they are out of its view.
pub(super) fn hide_cut_surfaces(
    own: &PreparedView,
    evidence: &mut [Evidence],
    settings: &SegmentSettings,
) {
    let deviates = |e: &Evidence| e.z.max(e.z_loose) >= settings.grow_sigmas;
    let lost: Vec<usize> = (0..evidence.len())
        .filter(|i| evidence[*i].no_return && deviates(&evidence[*i]))
        .collect();
    // Number of the set of lost points that belong together, by their directions.
    let mut set_of = vec![NO_SET; evidence.len()];
    let mut edges: Vec<Edge> = Vec::new();
    for first in lost {
        if set_of[first] != NO_SET {
            continue;
        }
        let mut edge = Edge::default();
        let mut reached = vec![first];
        set_of[first] = edges.len();
        while let Some(i) = reached.pop() {
            for neighbour in neighbours(own, i) {
                match evidence.get(neighbour) {
                    // Nothing beside it: the thing ended here.
                    None => edge.ends += 1,
                    Some(e) if !deviates(e) => {
                        if goes_on(own, i, neighbour) {
                            edge.goes_on += 1;
                        } else {
                            edge.ends += 1;
                        }
                    }
                    Some(e) if e.no_return && set_of[neighbour] == NO_SET => {
                        set_of[neighbour] = edges.len();
                        reached.push(neighbour);
                    }
                    // Looked through with a return, or in the set.
                    Some(_) => {}
                }
            }
        }
        edges.push(edge);
    }
    for (set, evidence) in set_of.into_iter().zip(evidence) {
        if edges.get(set).is_some_and(|edge| edge.goes_on > edge.ends) {
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
}

/// The rays around point `i`.
fn neighbours(own: &PreparedView, i: usize) -> impl Iterator<Item = usize> {
    let direction = (own.view.points[i] - own.view.origin).try_normalize(1e-9);
    let around = direction.map(|d| own.rays.neighbours(&d).sectors);
    around.into_iter().flatten().flatten().map(|(ray, _)| ray)
}

/// Whether two neighbouring points lie on one surface: each on the plane around the other, within its thickness and the noise.
fn goes_on(own: &PreparedView, a: usize, b: usize) -> bool {
    let [p, q] = [a, b].map(|i| own.view.points[i]);
    let patch = |i: usize| {
        let cell = own.surfaces.patch_of_point.get(i)?;
        own.surfaces.patches.get(*cell as usize)
    };
    let is_on = |patch: Option<&SurfacePatch>, other: &Point3<f64>| {
        patch.is_some_and(|patch| {
            let noise_m = own.noise.sigma_m((other - own.view.origin).norm());
            let within_m = 3.0 * noise_m.hypot(patch.roughness_m);
            patch.flat && patch.height_m(other).abs() < within_m
        })
    };
    is_on(patch(a), &q) && is_on(patch(b), &p)
}
