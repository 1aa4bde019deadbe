//! Turns segments and their shares of d_GMM into novelties.

use super::moved;
use super::quantified_change::{NoveltyShare, QuantifiedChange};
use super::surroundings::surroundings;
use super::{
    ComparedMixtures, Novelty, NoveltyKind, ObserverView, PreparedView, Segment, SegmentSettings,
};
use crate::geometry::DriftTransform;
use crate::mixture::{Gaussian, Mixture};
use nalgebra::Point3;

/// The novelties, disappeared first, then appeared, with positions in the current frame.
pub(super) fn list_novelties(
    segments: &[Vec<Segment>; 2],
    views: &[&PreparedView; 2],
    observers: &[ObserverView<'_>; 2],
    change: &QuantifiedChange,
    compared: &ComparedMixtures,
    settings: &SegmentSettings,
) -> Vec<Novelty> {
    let mut novelties = Vec::new();
    // Disappeared novelties are seen by the current view, from the reference's frame, in which the mixtures are.
    let current_from_reference = observers[0].observer_from_own;
    for (side, kind) in [(0, NoveltyKind::Disappeared), (1, NoveltyKind::Appeared)] {
        let shares = &change.shares[side];
        let own = views[side];
        let current_from_own = match kind {
            NoveltyKind::Disappeared => observers[side].observer_from_own,
            NoveltyKind::Appeared => DriftTransform::identity(),
        };
        let mut in_segments = vec![false; own.view.points.len()];
        for i in segments[side].iter().flat_map(|s| &s.point_indices) {
            in_segments[*i] = true;
        }
        for (segment, share) in segments[side].iter().zip(shares) {
            let points: Vec<Point3<f64>> = segment
                .point_indices
                .iter()
                .map(|i| current_from_own.apply(&own.view.points[*i]))
                .collect();
            let Some(moments) = Gaussian::from_points(&points) else {
                continue;
            };
            novelties.push(Novelty {
                kind,
                moved_from: None,
                point_indices: segment.point_indices.clone(),
                surroundings: surroundings(segment, own, &in_segments, &observers[side], settings)
                    .transformed(&current_from_own),
                moments,
                mixture: own_mixture(share, compared, side, &current_from_reference),
                components: positions_in_mixture(share, compared, side),
                needed_for_alarm: share.needed_for_alarm,
                extent_m: extent(&points),
                points,
                mass: share.mass,
                contribution: share.contribution,
                support: segment.support,
            });
        }
    }
    moved::link(&mut novelties);
    novelties
}

/// The components of a novelty in the current frame, weights summing to one.
fn own_mixture(
    share: &NoveltyShare,
    compared: &ComparedMixtures,
    side: usize,
    current_from_reference: &DriftTransform,
) -> Mixture {
    let own = share.components.iter().map(|k| &compared.components[*k]);
    let total: f64 = own.clone().map(|c| c.masses[side]).sum();
    let (weights, components) = own
        .map(|c| {
            let turned = c.gaussian.transformed(&current_from_reference.pose);
            let mean = current_from_reference.apply(&c.gaussian.mean);
            (c.masses[side] / total, Gaussian { mean, ..turned })
        })
        .unzip();
    Mixture {
        weights,
        components,
    }
}

/// Positions of a novelty's components among the components with mass of its side, as the mixtures are written.
fn positions_in_mixture(
    share: &NoveltyShare,
    compared: &ComparedMixtures,
    side: usize,
) -> Vec<usize> {
    let present: Vec<usize> = compared.present(side).collect();
    let position = |k: &usize| present.binary_search(k).ok();
    share.components.iter().filter_map(position).collect()
}

fn extent(points: &[Point3<f64>]) -> [f64; 3] {
    [0, 1, 2].map(|axis| {
        let (low, high) = points
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
                (low.min(p[axis]), high.max(p[axis]))
            });
        high - low
    })
}
