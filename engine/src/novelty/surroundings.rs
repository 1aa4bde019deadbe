//! Finds the surroundings of a segment. Where an object touches what was there before, its points prove no change: the foot
//! of a box, the strip of a door expected its hinge. They belong to its shape all the same.

use super::bounding_box::BoundingBox;
use super::segment::reaches_m;
use super::{ObserverView, PreparedView, Segment, SegmentSettings, Surroundings};
use crate::geometry::PointGrid;
use nalgebra::Point3;

/// Surroundings of `segment` in the frame of `own`; `in_segments` marks the own points of all segments.
pub(super) fn surroundings(
    segment: &Segment,
    own: &PreparedView,
    in_segments: &[bool],
    observer: &ObserverView<'_>,
    settings: &SegmentSettings,
) -> Surroundings {
    let points = &own.view.points;
    let segment_points: Vec<Point3<f64>> =
        segment.point_indices.iter().map(|i| points[*i]).collect();
    let grid = PointGrid::new(&segment_points, settings.link_distance_m);
    let mut reaches_m = reaches_m(own, &segment_points, &grid, settings);
    let middle = reaches_m.len() / 2;
    let (_, reach_m, _) = reaches_m.select_nth_unstable_by(middle, f64::total_cmp);
    let reach_m = *reach_m;
    let bounds = BoundingBox::new(segment_points.iter().copied());
    let near = |p: &Point3<f64>, within_m: f64| {
        bounds.contains(p, within_m) && grid.nearest(p, within_m).is_some()
    };
    let free = points.iter().zip(in_segments).filter(|(_, taken)| !**taken);
    let own_points: Vec<Point3<f64>> = free.map(|(p, _)| *p).filter(|p| near(p, reach_m)).collect();
    let own_from_observer = observer.observer_from_own.inverse();
    let other_points = match own_points.len() {
        0 => Vec::new(),
        _ => observer
            .view
            .view
            .points
            .iter()
            .map(|p| own_from_observer.apply(p))
            .filter(|p| near(p, 2.0 * reach_m))
            .collect(),
    };
    Surroundings {
        reach_m,
        own: own_points,
        other: other_points,
    }
}

#[cfg(test)]
mod tests {
    use super::surroundings;
    use crate::geometry::{DriftTransform, Pose, RangeDrift, View};
    use crate::novelty::{
        Evidence, NoveltySettings, ObserverView, PreparedView, Visibility, measure,
    };
    use nalgebra::{Point3, Translation3, UnitQuaternion, Vector3};

    #[test]
    fn surroundings_are_the_near_points_of_no_segment() {
        let settings = NoveltySettings::default();
        let wall: Vec<Point3<f64>> = (-25..=25)
            .flat_map(|y| (-25..=25).map(move |z| (y, z)))
            .map(|(y, z)| Point3::new(2.0, f64::from(y) * 0.04, f64::from(z) * 0.04))
            .collect();
        let other_from_wall = Pose::from_parts(
            Translation3::new(0.1, -0.2, 0.05),
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.1),
        );
        let prepare = |points: &[Point3<f64>]| {
            let view = View::from_points(points.to_vec(), Point3::origin());
            PreparedView::new(&view, "view", &settings.evidence).expect("a view")
        };
        let own = prepare(&wall);
        let other: Vec<Point3<f64>> = wall.iter().map(|p| other_from_wall * p).collect();
        let other = prepare(&other);
        let inside = |p: &Point3<f64>| p.y.abs() < 0.3 && p.z.abs() < 0.3;
        let in_another = |p: &Point3<f64>| p.y > 0.35;
        let indices = |of: &dyn Fn(&Point3<f64>) -> bool| -> Vec<usize> {
            (0..wall.len()).filter(|i| of(&wall[*i])).collect()
        };
        let evidence = vec![Evidence::none(Visibility::FreeSpace); wall.len()];
        let segment = measure(&own, &evidence, indices(&inside), &settings.segment);
        let taken: Vec<bool> = wall.iter().map(|p| inside(p) || in_another(p)).collect();
        let observer = ObserverView {
            view: &other,
            observer_from_own: DriftTransform::to_reference(
                other_from_wall,
                RangeDrift::default(),
                Point3::origin(),
            ),
        };
        let found = surroundings(&segment, &own, &taken, &observer, &settings.segment);
        let distance_m = |p: &Point3<f64>| {
            let distances = segment.point_indices.iter().map(|i| (wall[*i] - p).norm());
            distances.fold(f64::INFINITY, f64::min)
        };
        let reach_m = found.reach_m;
        assert!(reach_m >= settings.segment.link_distance_m);
        let free = wall.iter().filter(|p| !inside(p) && !in_another(p));
        let expected: Vec<_> = free.filter(|p| distance_m(p) <= reach_m).copied().collect();
        assert!(!expected.is_empty());
        assert_eq!(found.own, expected);
        // The observer sees the same wall, which maps back to the same points.
        let about = wall.iter().filter(|p| distance_m(p) < 2.0 * reach_m - 1e-9);
        assert!(found.other.len() >= about.count());
        let on_wall = |p: &Point3<f64>| wall.iter().any(|q| (q - p).norm() < 1e-9);
        assert!(found.other.iter().all(on_wall));
        let back = found.transformed(&observer.observer_from_own);
        assert!((back.own[0] - other_from_wall * expected[0]).norm() < 1e-12);
    }
}
