//! The literal recipe: both visits fitted alone, and Pi as groups of Gaussians that touch (`docs/novelty.md section 10`).

use super::algorithm1::ChangeSegmentation;
use super::common_surface::{WeightedCells, shared_areas};
use super::compared_mixtures::ComparedMixtures;
use super::constants::TOUCHING_SIGMAS;
use super::model::SegmentId;
use super::prediction::most_likely_components;
use super::view_pair::ViewPair;
use super::{Evidence, NoveltyError, Segment, SegmentSettings, Visibility};
use crate::geometry::Pose;
use crate::mixture::{Gaussian, Mixture};
use nalgebra::{Point3, Vector3};

/// Gamma and a Theta that was fitted in the current view's own frame, each weighted by what both views could see, or shadows
/// would move mass as well. They share no component.
///
/// # Errors
/// Mixtures that cannot be weighted.
pub(super) fn compare_alone(
    gamma: &Mixture,
    theta: Mixture,
    pair: &ViewPair<'_>,
    evidence: &[Vec<Evidence>; 2],
) -> Result<ComparedMixtures, NoveltyError> {
    let theta = transformed(theta, &pair.reference_from(1).pose);
    let mut compared = ComparedMixtures::default();
    for (side, mixture) in [gamma, &theta].into_iter().enumerate() {
        let visible = visible_cells(pair, side, &evidence[side]);
        let areas_m2 = shared_areas(mixture, &visible)?;
        let total_m2: f64 = areas_m2.iter().sum();
        for (g, area_m2) in mixture.components.iter().zip(&areas_m2) {
            let mut masses = [0.0; 2];
            masses[side] = if total_m2 > 0.0 {
                area_m2 / total_m2
            } else {
                0.0
            };
            compared.push(*g, masses);
        }
    }
    Ok(compared)
}

/// Cells of view `side` that the other view could see, in the reference's frame.
fn visible_cells(pair: &ViewPair<'_>, side: usize, evidence: &[Evidence]) -> WeightedCells {
    let surfaces = &pair.views[side].surfaces;
    let reference_from_own = pair.reference_from(side);
    let mut visible_points = vec![0.0; surfaces.patches.len()];
    for (cell, e) in surfaces.patch_of_point.iter().zip(evidence) {
        if is_visible(e) {
            visible_points[*cell as usize] += 1.0;
        }
    }
    let mut cells = WeightedCells::default();
    for (patch, n) in surfaces.patches.iter().zip(visible_points) {
        if n > 0.0 {
            let area_m2 = n * patch.area_m2 / patch.count as f64;
            cells.push(reference_from_own.apply(&patch.mean), area_m2);
        }
    }
    cells
}

fn is_visible(e: &Evidence) -> bool {
    matches!(e.visibility, Visibility::OnSurface | Visibility::FreeSpace)
}

/// Segments of Pi on each side, with the segment of each component: components that touch are one segment, with the points
/// that they explain best. One that the other view did not see for the greater part is none.
pub(super) fn segments_of_pi(
    compared: &ComparedMixtures,
    found: &ChangeSegmentation,
    pair: &ViewPair<'_>,
    evidence: &[Vec<Evidence>; 2],
    settings: &SegmentSettings,
) -> ([Vec<Segment>; 2], Vec<Option<SegmentId>>) {
    let mut owners = vec![None; compared.components.len()];
    let segments = [0, 1].map(|side| {
        let removed: Vec<usize> = found
            .removals
            .iter()
            .filter(|removal| removal.side == side)
            .map(|removal| removal.component)
            .collect();
        let groups = touching(compared, &removed, settings.link_distance_m);
        let points = points_of_groups(compared, &groups, side, pair);
        let mut segments = Vec::new();
        for (group, points) in groups.iter().zip(points) {
            let seen = points.iter().filter(|i| is_visible(&evidence[side][**i]));
            if points.len() < settings.min_points || 2 * seen.count() <= points.len() {
                continue;
            }
            for k in group {
                owners[*k] = Some((side, segments.len()));
            }
            let own = pair.views[side];
            segments.push(super::segment::measure(
                own,
                &evidence[side],
                points,
                settings,
            ));
        }
        segments
    });
    (segments, owners)
}

/// Indices of the points of view `side` whose cells belong to each group more likely than to any other component.
fn points_of_groups(
    compared: &ComparedMixtures,
    groups: &[Vec<usize>],
    side: usize,
    pair: &ViewPair<'_>,
) -> Vec<Vec<usize>> {
    let present: Vec<usize> = compared.present(side).collect();
    let mixture = Mixture {
        weights: present
            .iter()
            .map(|k| compared.components[*k].masses[side])
            .collect(),
        components: present
            .iter()
            .map(|k| compared.components[*k].gaussian)
            .collect(),
    };
    let mut group_of = vec![None; compared.components.len()];
    for (g, members) in groups.iter().enumerate() {
        for k in members {
            group_of[*k] = Some(g);
        }
    }
    let surfaces = &pair.views[side].surfaces;
    let reference_from_own = pair.reference_from(side);
    let means: Vec<Point3<f64>> = surfaces
        .patches
        .iter()
        .map(|patch| reference_from_own.apply(&patch.mean))
        .collect();
    let group_of_cell: Vec<Option<usize>> = most_likely_components(&mixture, &means)
        .into_iter()
        .map(|k| present.get(k as usize).and_then(|k| group_of[*k]))
        .collect();
    let mut points = vec![Vec::new(); groups.len()];
    for (i, cell) in surfaces.patch_of_point.iter().enumerate() {
        if let Some(group) = group_of_cell[*cell as usize] {
            points[group].push(i);
        }
    }
    points
}

/// Groups of `removed` whose ellipsoids come within `link_distance_m` of one another.
fn touching(
    compared: &ComparedMixtures,
    removed: &[usize],
    link_distance_m: f64,
) -> Vec<Vec<usize>> {
    let reach = |g: &Gaussian, towards: &Vector3<f64>| {
        TOUCHING_SIGMAS * towards.dot(&(g.covariance * towards)).max(0.0).sqrt()
    };
    let gaussian = |k: usize| &compared.components[k].gaussian;
    let mut groups: Vec<Vec<usize>> = Vec::new();
    let mut sorted = removed.to_vec();
    sorted.sort_unstable();
    for k in sorted {
        let a = gaussian(k);
        let near = |m: &usize| {
            let b = gaussian(*m);
            let off = b.mean - a.mean;
            off.try_normalize(1e-9)
                .is_none_or(|u| off.norm() - reach(a, &u) - reach(b, &u) <= link_distance_m)
        };
        let (joined, rest): (Vec<_>, Vec<_>) = groups.into_iter().partition(|g| g.iter().any(near));
        groups = rest;
        let mut group: Vec<usize> = joined.into_iter().flatten().collect();
        group.push(k);
        group.sort_unstable();
        groups.push(group);
    }
    groups.sort();
    groups
}

fn transformed(mut mixture: Mixture, pose: &Pose) -> Mixture {
    for g in &mut mixture.components {
        *g = g.transformed(pose);
    }
    mixture
}
