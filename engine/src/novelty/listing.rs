//! Turns segments and their shares of d_GMM into novelties.

use super::compared_view::ComparedView;
use super::moved;
use super::quantified_change::QuantifiedChange;
use super::surroundings::surroundings;
use super::{Novelty, NoveltyError, NoveltyKind, ObserverView, Segment, SegmentSettings};
use crate::geometry::DriftTransform;
use crate::mixture::{Gaussian, split_until_flat};
use nalgebra::Point3;

/// The novelties, disappeared first, then appeared, with positions in the current frame.
///
/// # Errors
/// A mixture that cannot be fitted.
pub(super) fn list_novelties(
    segments: &[Vec<Segment>; 2],
    views: &[ComparedView<'_>; 2],
    observers: &[ObserverView<'_>; 2],
    change: &QuantifiedChange,
    settings: &SegmentSettings,
) -> Result<Vec<Novelty>, NoveltyError> {
    let mut novelties = Vec::new();
    for (side, kind) in [(0, NoveltyKind::Disappeared), (1, NoveltyKind::Appeared)] {
        let shares = [&change.disappeared, &change.appeared][side];
        let own = views[side].prepared;
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
                mixture: split_until_flat(&points, None, &own.split_settings())?,
                extent_m: extent(&points),
                points,
                mass: share.mass,
                contribution: share.contribution,
                support: segment.support,
            });
        }
    }
    moved::link(&mut novelties);
    Ok(novelties)
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
