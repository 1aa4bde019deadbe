//! A reference's view in which novelties of a visit are normal: what appeared is in it, what disappeared is not, and what was
//! hidden at the visit was not looked at.

use super::constants::SILHOUETTE_SPACINGS;
use super::{Detection, NoveltyKind, Reference};
use crate::geometry::{RayIndex, RaySet, View};
use nalgebra::{Point3, Unit, Vector3};

/// Where a thing is in the eyes of the reference.
struct Silhouette {
    /// The thing's own rays.
    rays: RayIndex,
    /// A ray up to this far from the thing's own belongs to its silhouette.
    margin_rad: f64,
}

impl Silhouette {
    fn new(points: Vec<Point3<f64>>, origin: Point3<f64>, spacing_rad: f64) -> Self {
        let view = View::from_points(points, origin);
        Self {
            rays: RayIndex::new(RaySet::from_view(&view)),
            margin_rad: SILHOUETTE_SPACINGS * spacing_rad,
        }
    }

    /// Range of the thing in this direction; `None` beside it.
    fn range_m(&self, direction: &Vector3<f64>) -> Option<f64> {
        let ray = self.rays.nearest_return(direction, self.margin_rad)?;
        Some(self.rays.range_m(ray))
    }

    /// Whether `p` lies behind the thing.
    fn hides(&self, p: &Point3<f64>) -> bool {
        let offset = p - self.rays.origin();
        let thing_m = offset.try_normalize(1e-9).and_then(|d| self.range_m(&d));
        thing_m.is_some_and(|thing_m| offset.norm() > thing_m)
    }
}

/// The view of `reference` in which the novelties of `detection` at the positions `accepted` are normal. The frame stays the
/// reference's.
pub fn accept_novelties(reference: &Reference, detection: &Detection, accepted: &[usize]) -> View {
    let taught = &reference.prepared.view;
    let current = &detection.current.view;
    let spacing_rad = reference.prepared.rays.spacing_rad;
    let reference_from_current = detection.registration.reference_from_current();
    let mut view = taught.clone();
    let mut is_other = vec![false; current.points.len()];
    for (i, novelty) in detection.novelties.iter().enumerate() {
        if novelty.kind == NoveltyKind::Appeared && !accepted.contains(&i) {
            novelty
                .point_indices
                .iter()
                .for_each(|k| is_other[*k] = true);
        }
    }
    let mut removed = vec![false; taught.points.len()];
    let mut added = Vec::new();
    for novelty in accepted.iter().filter_map(|i| detection.novelties.get(*i)) {
        match novelty.kind {
            NoveltyKind::Appeared => {
                let points: Vec<Point3<f64>> = novelty
                    .point_indices
                    .iter()
                    .map(|k| reference_from_current.apply(&current.points[*k]))
                    .collect();
                let thing = Silhouette::new(points.clone(), taught.origin, spacing_rad);
                for (p, removed) in taught.points.iter().zip(&mut removed) {
                    *removed |= thing.hides(p);
                }
                let is_free = |d: &Unit<Vector3<f64>>| thing.range_m(d).is_none();
                view.no_return.retain(is_free);
                added.extend(points);
            }
            NoveltyKind::Disappeared => {
                let points: Vec<Point3<f64>> = novelty
                    .point_indices
                    .iter()
                    .map(|k| taught.points[*k])
                    .collect();
                let thing = Silhouette::new(points, taught.origin, spacing_rad);
                novelty
                    .point_indices
                    .iter()
                    .for_each(|k| removed[*k] = true);
                let seen = current.points.iter().zip(&is_other);
                let seen = seen.filter(|(_, other)| !**other);
                let mapped = seen.map(|(p, _)| reference_from_current.apply(p));
                added.extend(mapped.filter(|p| thing.hides(p)));
            }
        }
    }
    let kept = taught.points.iter().zip(removed);
    view.points = kept
        .filter(|(_, removed)| !removed)
        .map(|(p, _)| *p)
        .collect();
    view.points.extend(added);
    view
}
