//! Parts of one thing that something in front cuts apart (`docs/novelty.md section 6`).

use super::super::bounding_box::BoundingBox;
use super::super::constants::ON_LINE_SIGMAS;
use super::super::{PreparedView, Segment};
use nalgebra::Point3;

/// Joins each of `parts`, segments that do not pass by themselves, to the one of `segments` that it belongs to: the nearest
/// one from which only things in front separate it, no further off than that one is wide. The rest is dropped. The points of
/// each segment afterwards.
pub(super) fn join_parts(
    own: &PreparedView,
    segments: &[Segment],
    parts: &[Segment],
) -> Vec<Vec<usize>> {
    let bounds = |segment: &Segment| BoundingBox::new(points(own, segment));
    let places: Vec<BoundingBox> = segments.iter().map(bounds).collect();
    let mut joined: Vec<Vec<usize>> = segments.iter().map(|s| s.point_indices.clone()).collect();
    for part in parts {
        let part_place = bounds(part);
        let near = segments.iter().zip(&places).enumerate();
        let owner = near
            .filter(|(_, (_, place))| place.gap_m(&part_place) <= place.diagonal_m())
            .filter_map(|(index, (segment, place))| {
                let apart_m = gap_behind_something_m(own, segment, part)?;
                (apart_m <= place.diagonal_m()).then_some((index, apart_m))
            })
            .min_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((index, _)) = owner {
            joined[index].extend_from_slice(&part.point_indices);
        }
    }
    for points in &mut joined {
        points.sort_unstable();
    }
    joined
}

fn points<'a>(
    own: &'a PreparedView,
    segment: &'a Segment,
) -> impl Iterator<Item = Point3<f64>> + Clone + 'a {
    segment.point_indices.iter().map(|i| own.view.points[*i])
}

/// Distance between nearby points of `a` and `b`, metres, if no beam between them passed the line from one to the other and
/// at least one met something in front of it. None otherwise. Beams without a return are ignored.
fn gap_behind_something_m(own: &PreparedView, a: &Segment, b: &Segment) -> Option<f64> {
    let [start, end] = nearby_points(own, a, b)?;
    let [from, to] = [start, end].map(|p| p - own.rays.origin());
    // Bounded: a turn in steps of half a row.
    let steps = (from.angle(&to) / (0.5 * own.rays.spacing_rad)).ceil() as usize;
    let mut is_stopped = false;
    for step in 1..steps {
        let v = from.lerp(&to, step as f64 / steps as f64);
        let (ray, _) = own.rays.neighbours(&v.try_normalize(1e-9)?).nearest?;
        let line_m = v.norm();
        let sigmas = (own.rays.range_m(ray) - line_m) / own.noise.sigma_m(line_m);
        if sigmas.is_finite() && sigmas > ON_LINE_SIGMAS {
            return None;
        }
        is_stopped |= sigmas < -ON_LINE_SIGMAS;
    }
    is_stopped.then(|| (end - start).norm())
}

/// A point of `a` and one of `b` that lie near one another: that of `b` nearest to the middle of `a`, that of `a` nearest to
/// it, and that of `b` nearest to that.
fn nearby_points(own: &PreparedView, a: &Segment, b: &Segment) -> Option<[Point3<f64>; 2]> {
    let nearest = |segment, to: &Point3<f64>| {
        points(own, segment)
            .min_by(|p, q| (p - to).norm_squared().total_cmp(&(q - to).norm_squared()))
    };
    let sum = points(own, a).fold(Point3::origin(), |sum, p| sum + p.coords);
    let on_b = nearest(b, &(sum / a.point_indices.len() as f64))?;
    let on_a = nearest(a, &on_b)?;
    Some([on_a, nearest(b, &on_a)?])
}

#[cfg(test)]
mod tests {
    use super::join_parts;
    use crate::geometry::View;
    use crate::novelty::{Evidence, NoveltySettings, PreparedView, Segment, Visibility, measure};
    use nalgebra::{Point3, Unit, Vector3};

    /// Elevations of a board, degrees; its foot has three rows.
    const BOARD_DEG: [i32; 2] = [2, 12];

    /// A view with one beam per degree: a board at 2 m, 10 deg wide, before a wall at 4 m, and its foot, whose highest row is at
    /// `foot_deg`. What a beam between them met says `between_m` of its azimuth and elevation. Then both as segments.
    fn board_and_foot(
        foot_deg: i32,
        between_m: impl Fn(i32, i32) -> Option<f64>,
    ) -> (PreparedView, [Segment; 2]) {
        let settings = NoveltySettings::default();
        let mut points = Vec::new();
        let mut no_return = Vec::new();
        let mut parts = [Vec::new(), Vec::new()];
        for azimuth_deg in -30..30 {
            for elevation_deg in -30..30 {
                let (sin, cos) = f64::from(azimuth_deg).to_radians().sin_cos();
                let (up, flat) = f64::from(elevation_deg).to_radians().sin_cos();
                let d = Vector3::new(flat * cos, flat * sin, up);
                let in_rows = |low: i32, high: i32| (low..=high).contains(&elevation_deg);
                let in_columns = (0..10).contains(&azimuth_deg);
                let is_foot = in_columns && in_rows(foot_deg - 2, foot_deg);
                let range_m = if is_foot || in_columns && in_rows(BOARD_DEG[0], BOARD_DEG[1]) {
                    parts[usize::from(is_foot)].push(points.len());
                    Some(2.0)
                } else if in_rows(foot_deg + 1, BOARD_DEG[0] - 1) {
                    between_m(azimuth_deg, elevation_deg)
                } else {
                    Some(4.0)
                };
                match range_m {
                    Some(range_m) => points.push(Point3::from(d * range_m)),
                    None => no_return.push(Unit::new_normalize(d)),
                }
            }
        }
        let mut view = View::from_points(points, Point3::origin());
        view.no_return = no_return;
        let view = PreparedView::new(&view, "view", &settings.evidence).expect("a view");
        let segments = parts.map(|indices| segment_of(&view, indices));
        (view, segments)
    }

    fn segment_of(view: &PreparedView, indices: Vec<usize>) -> Segment {
        let evidence = vec![Evidence::none(Visibility::FreeSpace); view.view.points.len()];
        let settings = NoveltySettings::default();
        measure(view, &evidence, indices, &settings.segment)
    }

    fn is_joined(foot_deg: i32, between_m: impl Fn(i32, i32) -> Option<f64>) -> bool {
        let (view, [board, foot]) = board_and_foot(foot_deg, between_m);
        let mut both = [&board, &foot].map(|s| s.point_indices.clone()).concat();
        both.sort_unstable();
        let alone = board.point_indices.clone();
        let joined = join_parts(&view, &[board], &[foot]);
        assert!(joined == [alone] || joined[0] == both);
        joined[0] == both
    }

    #[test]
    fn a_foot_below_a_bar_belongs_to_the_board_above() {
        assert!(is_joined(-2, |_, _| Some(1.0)));
        // A beam that did not come back does not say that it passed.
        let some_lost = |azimuth, elevation| ((azimuth + elevation) % 2 == 0).then_some(1.0);
        assert!(is_joined(-2, some_lost));
        // All passed, all met the same surface, none came back, one row passed below the bar.
        assert!(!is_joined(-2, |_, _| Some(4.0)));
        assert!(!is_joined(-2, |_, _| Some(2.0)));
        assert!(!is_joined(-2, |_, _| None));
        let one_row = |_, elevation| Some(if elevation == -1 { 4.0 } else { 1.0 });
        assert!(!is_joined(-2, one_row));
    }

    #[test]
    fn nothing_is_joined_over_more_than_the_width_of_the_segment() {
        // The diagonal of the board is 0.47 m: 13 deg at 2 m are 0.45 m, 15 deg are 0.52 m.
        assert!(is_joined(-11, |_, _| Some(1.0)));
        assert!(!is_joined(-13, |_, _| Some(1.0)));
    }

    #[test]
    fn a_part_belongs_to_the_nearest_segment() {
        let (view, [board, foot]) = board_and_foot(-2, |_, _| Some(1.0));
        let middle_m = 2.0 * 7.0_f64.to_radians().sin();
        let [upper, lower] = [true, false].map(|is_upper| {
            let indices = board.point_indices.iter().copied();
            let half = indices.filter(|i| (view.view.points[*i].z > middle_m) == is_upper);
            segment_of(&view, half.collect())
        });
        let points = lower.point_indices.len() + foot.point_indices.len();
        let joined = join_parts(&view, &[upper.clone(), lower], &[foot]);
        assert_eq!(joined[0], upper.point_indices);
        assert_eq!(joined[1].len(), points);
    }
}
