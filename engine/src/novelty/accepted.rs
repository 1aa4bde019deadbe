//! A reference's view in which novelties of a visit are normal: what appeared is in it, what disappeared is not, and what was
//! hidden at the visit was not looked at.

use super::{Detection, NoveltyKind, Reference};
use crate::geometry::View;
use nalgebra::{Point3, Unit, Vector3};

/// A ray belongs to the silhouette of a thing up to this many row spacings from the thing's own rays.
const SILHOUETTE_SPACINGS: f64 = 1.5;

/// Where a thing is in the eyes of the reference.
struct Silhouette {
    origin: Point3<f64>,
    directions: Vec<(Vector3<f64>, f64)>,
    min_cos: f64,
}

impl Silhouette {
    fn new(points: &[Point3<f64>], origin: Point3<f64>, spacing_rad: f64) -> Self {
        let ray = |p: &Point3<f64>| {
            let offset = p - origin;
            let range_m = offset.norm();
            (range_m > 1e-6).then(|| (offset / range_m, range_m))
        };
        Self {
            origin,
            directions: points.iter().filter_map(ray).collect(),
            min_cos: (SILHOUETTE_SPACINGS * spacing_rad).cos(),
        }
    }

    /// Range of the thing in this direction; `None` beside it.
    fn range_m(&self, direction: &Vector3<f64>) -> Option<f64> {
        let nearest = self
            .directions
            .iter()
            .map(|(d, range_m)| (d.dot(direction), *range_m))
            .max_by(|a, b| a.0.total_cmp(&b.0));
        nearest
            .filter(|(cos, _)| *cos >= self.min_cos)
            .map(|(_, range_m)| range_m)
    }

    /// Whether `p` lies behind the thing.
    fn hides(&self, p: &Point3<f64>) -> bool {
        let offset = p - self.origin;
        let range_m = offset.norm();
        range_m > 1e-6
            && self
                .range_m(&(offset / range_m))
                .is_some_and(|thing_m| range_m > thing_m)
    }
}

/// The view of `reference` in which the novelties of `detection` at the positions `accepted` are normal. `current` is the
/// visit's view. The frame stays the reference's.
pub fn accept_novelties(
    reference: &Reference,
    current: &View,
    detection: &Detection,
    accepted: &[usize],
) -> View {
    let taught = &reference.prepared.view;
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
                let thing = Silhouette::new(&points, taught.origin, spacing_rad);
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
                let thing = Silhouette::new(&points, taught.origin, spacing_rad);
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
