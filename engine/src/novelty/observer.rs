//! The view that observes the segments of the other one, and whether it undersampled them.
//!
//! A sensor's beam pattern is the same at every visit. Where many more own beams end on a segment than the pattern has, and
//! the observer has no such crowd within its outline, the beams are there for the object's sake (a closer look, a merged
//! cloud), and the observer would have had them too if the object had been there (`docs/novelty.md section 6`).

use super::outline::Outline;
use super::{PreparedView, Segment, SegmentSettings};
use crate::geometry::DriftTransform;
use nalgebra::Vector3;

/// The view whose rays tell whether the points of the other view deviate.
#[derive(Debug, Clone, Copy)]
pub(super) struct ObserverView<'a> {
    /// The observing view.
    pub view: &'a PreparedView,
    /// From the frame of the segment's own view to that of the observer.
    pub observer_from_own: DriftTransform,
}

impl ObserverView<'_> {
    /// Whether several rows of own beams end on `segment`, denser than the own pattern around it and than the beams of the
    /// observer within its outline.
    pub(super) fn is_undersampled(
        &self,
        own: &PreparedView,
        segment: &Segment,
        settings: &SegmentSettings,
    ) -> bool {
        segment.own_rows() >= settings.min_width_spacings
            && segment.own_density_per_sr()
                >= settings.oversampled_fill * segment.crowding * own.rays.mean_density_per_sr
            && self.surplus(own, segment) >= settings.oversampled_surplus
    }

    /// Number of own beams on `segment` over that of the observer's beams within its outline, each relative to the mean density
    /// of its view.
    fn surplus(&self, own: &PreparedView, segment: &Segment) -> f64 {
        let rays = &self.view.rays;
        let seen: Vec<Vector3<f64>> = segment
            .point_indices
            .iter()
            .map(|i| self.observer_from_own.apply(&own.view.points[*i]) - rays.origin())
            .filter_map(|v| v.try_normalize(1e-9))
            .collect();
        let outline = Outline::new(&seen);
        let mut inside: Vec<usize> = seen
            .iter()
            .filter_map(|d| rays.neighbours(d).nearest)
            .map(|(ray, _)| ray)
            .filter(|ray| self.direction(*ray).is_some_and(|d| outline.contains(&d)))
            .collect();
        inside.sort_unstable();
        inside.dedup();
        let density_ratio = own.rays.mean_density_per_sr / rays.mean_density_per_sr;
        // One more than there are: a beam may just have missed it.
        seen.len() as f64 / (density_ratio * (inside.len() + 1) as f64)
    }

    fn direction(&self, ray: usize) -> Option<Vector3<f64>> {
        let view = &self.view.view;
        match view.points.get(ray) {
            Some(p) => (p - view.origin).try_normalize(1e-9),
            None => Some(view.no_return.get(ray - view.points.len())?.into_inner()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::ObserverView;
    use crate::geometry::{DriftTransform, View};
    use crate::novelty::{Evidence, NoveltySettings, PreparedView, Visibility, measure};
    use nalgebra::{Point3, Vector3};

    fn direction(azimuth_deg: f64, elevation_deg: f64) -> Vector3<f64> {
        let (az, el) = (azimuth_deg.to_radians(), elevation_deg.to_radians());
        Vector3::new(el.cos() * az.cos(), el.cos() * az.sin(), el.sin())
    }

    /// A sphere of 4 m about the sensor, in rows ten degrees apart.
    fn sphere() -> Vec<Point3<f64>> {
        let lines = (-6..6).flat_map(|az| (-4..4).map(move |el| (az, el)));
        lines
            .map(|(az, el)| direction(10.0 * f64::from(az) + 5.0, 10.0 * f64::from(el) + 5.0))
            .map(|d| Point3::from(d * 4.0))
            .collect()
    }

    /// `columns` by `rows` beams over `size_deg` straight ahead, which end at `range_m`.
    fn beams(columns: usize, rows: usize, size_deg: [f64; 2], range_m: f64) -> Vec<Point3<f64>> {
        let angle = |k: usize, count: usize, size_deg: f64| {
            ((k as f64 + 0.5) / count as f64 - 0.5) * size_deg
        };
        let all = (0..columns).flat_map(|c| (0..rows).map(move |r| (c, r)));
        all.map(|(c, r)| direction(angle(c, columns, size_deg[0]), angle(r, rows, size_deg[1])))
            .map(|d| Point3::from(d * range_m))
            .collect()
    }

    /// Whether an observer that saw `other` undersampled a segment of the points `object`.
    fn undersampled(object: &[Point3<f64>], other: Vec<Point3<f64>>) -> bool {
        let settings = NoveltySettings::default();
        let prepare = |points: Vec<Point3<f64>>| {
            let view = View::from_points(points, Point3::origin());
            PreparedView::new(&view, "view", &settings.evidence).expect("a view")
        };
        let mut own = sphere();
        let indices: Vec<usize> = (own.len()..own.len() + object.len()).collect();
        own.extend(object);
        let evidence = vec![
            Evidence {
                z: 20.0,
                ..Evidence::none(Visibility::FreeSpace)
            };
            own.len()
        ];
        let (own, other) = (prepare(own), prepare(other));
        let segment = measure(&own, &evidence, indices, &settings.segment);
        let observer = ObserverView {
            view: &other,
            observer_from_own: DriftTransform::identity(),
        };
        observer.is_undersampled(&own, &segment, &settings.segment)
    }

    #[test]
    fn a_dense_segment_is_undersampled_by_a_view_without_that_density() {
        assert!(undersampled(&beams(4, 5, [6.0, 7.0], 2.0), sphere()));
        assert!(undersampled(&beams(3, 8, [5.0, 20.0], 2.0), sphere()));
        // An observer with the same density that saw the background.
        let mut dense = sphere();
        dense.extend(beams(4, 5, [6.0, 7.0], 4.0));
        assert!(!undersampled(&beams(4, 5, [6.0, 7.0], 2.0), dense));
    }

    #[test]
    fn segments_at_the_density_of_the_pattern_and_single_rows_are_not_undersampled() {
        assert!(!undersampled(&beams(4, 4, [40.0, 40.0], 2.0), sphere()));
        assert!(!undersampled(&beams(2, 4, [20.0, 40.0], 2.0), sphere()));
        assert!(!undersampled(&beams(1, 20, [0.1, 20.0], 2.0), sphere()));
    }
}
