//! The points of a cloud file that were measured, and those that only say that nothing came back. Scanners write a beam
//! without a return as NaN, as the point (0, 0, 0), or as a point at one large range.

use nalgebra::{Point3, Unit, Vector3};

/// Points at (0, 0, 0) from which they are markers: two beams do not end on one point.
const MIN_ZEROS: usize = 2;
/// Least share of a cloud that lies at its largest range, and least number, for a marker. A room has 3 in 100 000 there
/// (within 1e-4, recordings of `../shared/data`), since noise and incidence spread ranges.
const MIN_FAR_SHARE: f64 = 0.005;
const MIN_FAR_POINTS: usize = 20;
/// Ranges this near to the largest one are the same, metres: text with three decimals rounds a range by less.
const SAME_RANGE_M: f64 = 1e-3;
/// The same, as a share of the range: single precision rounds a coordinate by 6e-8.
const SAME_RANGE_SHARE: f64 = 1e-6;
/// Markers are spread by more than this, radians: a wall across the end of a corridor is one range within 1 mm over 1.1
/// degrees at 5 m.
const MIN_FAR_SPREAD_RAD: f64 = 0.17;

/// The measured points of a cloud file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MeasuredPoints {
    /// Metres, in file order.
    pub points: Vec<Point3<f64>>,
    /// Index in the file of each.
    pub file_index: Vec<usize>,
    /// Number of points with a coordinate that is not finite.
    pub not_finite: usize,
    /// Number of points that stand for no return, those that are not finite aside.
    pub no_return: usize,
    /// Directions from the sensor in which such a point says that nothing came back.
    pub no_return_directions: Vec<Unit<Vector3<f64>>>,
}

impl MeasuredPoints {
    /// Parts `points`, seen from `origin`.
    pub fn of(points: &[Point3<f64>], origin: &Point3<f64>) -> Self {
        let is_finite = |p: &Point3<f64>| p.iter().all(|c| c.is_finite());
        let is_zero = |p: &Point3<f64>| p.iter().all(|c| *c == 0.0);
        let has_zeros = points.iter().filter(|p| is_zero(p)).count() >= MIN_ZEROS;
        let mut parted = Self::default();
        for (index, p) in points.iter().enumerate() {
            if !is_finite(p) {
                parted.not_finite += 1;
            } else if has_zeros && is_zero(p) {
                parted.no_return += 1;
            } else {
                parted.points.push(*p);
                parted.file_index.push(index);
            }
        }
        parted.part_far(origin);
        parted
    }

    /// Takes out the points at the largest range, if they are markers.
    fn part_far(&mut self, origin: &Point3<f64>) {
        let range_m = |p: &Point3<f64>| (p - origin).norm();
        let largest_m = self.points.iter().map(range_m).fold(0.0, f64::max);
        let least_m = largest_m - SAME_RANGE_M.max(SAME_RANGE_SHARE * largest_m);
        let directions: Vec<Unit<Vector3<f64>>> = self
            .points
            .iter()
            .filter(|p| range_m(p) >= least_m)
            .filter_map(|p| Unit::try_new(p - origin, 0.0))
            .collect();
        let share = directions.len() as f64 / self.points.len().max(1) as f64;
        let middle = directions.iter().fold(Vector3::zeros(), |sum, d| sum + **d);
        let spread_rad = directions
            .iter()
            .map(|d| d.angle(&middle))
            .fold(0.0, f64::max);
        if directions.len() < MIN_FAR_POINTS
            || directions.len() == self.points.len()
            || share < MIN_FAR_SHARE
            || spread_rad < MIN_FAR_SPREAD_RAD
        {
            return;
        }
        let is_near: Vec<bool> = self.points.iter().map(|p| range_m(p) < least_m).collect();
        let mut near = is_near.iter();
        self.points.retain(|_| near.next() == Some(&true));
        let mut near = is_near.iter();
        self.file_index.retain(|_| near.next() == Some(&true));
        self.no_return += directions.len();
        self.no_return_directions = directions;
    }

    /// Number of points of the file that were not measured.
    pub fn dropped(&self) -> usize {
        self.not_finite + self.no_return
    }
}

#[cfg(test)]
mod tests {
    use super::MeasuredPoints;
    use nalgebra::{Point3, Vector3};

    fn part(points: &[Point3<f64>]) -> MeasuredPoints {
        MeasuredPoints::of(points, &Point3::origin())
    }

    /// Walls of a room about the sensor: no range comes often.
    fn room() -> Vec<Point3<f64>> {
        (0..1000)
            .map(|k| {
                let turn = f64::from(k) * 0.01;
                Point3::new(4.0 * turn.cos(), 3.0 * turn.sin(), f64::from(k % 7) * 0.1)
            })
            .collect()
    }

    /// Points at `range_m` in a fan of `width_rad`.
    fn fan(count: usize, range_m: f64, width_rad: f64) -> Vec<Point3<f64>> {
        (0..count)
            .map(|k| width_rad * (k as f64 / count as f64 - 0.5))
            .map(|turn| Point3::new(range_m * turn.cos(), range_m * turn.sin(), 0.0))
            .collect()
    }

    #[test]
    fn measured_points_keep_their_indices() {
        let points = [
            Point3::new(f64::NAN, 0.0, 0.0),
            Point3::new(1.0, 2.0, 3.0),
            Point3::new(0.0, f64::INFINITY, 0.0),
            Point3::new(4.0, 5.0, 6.0),
        ];
        let parted = part(&points);
        assert_eq!(parted.points, vec![points[1], points[3]]);
        assert_eq!(parted.file_index, vec![1, 3]);
        assert_eq!((parted.not_finite, parted.no_return), (2, 0));
    }

    #[test]
    fn several_zero_points_are_markers_and_one_is_a_point() {
        let zero = Point3::origin();
        let mut points = room();
        points.insert(3, zero);
        assert_eq!(part(&points).dropped(), 0);
        points.insert(7, zero);
        let parted = part(&points);
        assert_eq!(
            (parted.not_finite, parted.no_return, parted.points.len()),
            (0, 2, 1000)
        );
        assert_eq!(parted.file_index[2..7], [2, 4, 5, 6, 8]);
        assert!(parted.no_return_directions.is_empty());
    }

    #[test]
    fn one_far_range_in_many_directions_is_a_marker() {
        let with = |far: Vec<Point3<f64>>| {
            let mut points = room();
            points.extend(far);
            part(&points)
        };
        let parted = with(fan(30, 65.535, 1.0));
        assert_eq!((parted.no_return, parted.points), (30, room()));
        assert_eq!(parted.no_return_directions.len(), 30);
        let d = parted.no_return_directions[0];
        assert!((d.into_inner() - Vector3::new(0.5_f64.cos(), -0.5_f64.sin(), 0.0)).norm() < 1e-12);
        // Too few, within a small angle, not at one range.
        assert_eq!(with(fan(19, 65.535, 1.0)).no_return, 0);
        assert_eq!(with(fan(30, 65.535, 0.3)).no_return, 0);
        let uneven = fan(30, 65.535, 1.0).into_iter().enumerate();
        let uneven = uneven.map(|(k, p)| p * (1.0 + k as f64 * 1e-4)).collect();
        assert_eq!(with(uneven).no_return, 0);
        // The origin is the sensor's.
        let moved = Vector3::new(30.0, -5.0, 1.0);
        let mut points = room();
        points.extend(fan(30, 65.535, 1.0));
        let points: Vec<_> = points.iter().map(|p| p + moved).collect();
        let from_there = MeasuredPoints::of(&points, &Point3::from(moved));
        assert_eq!((from_there.no_return, part(&points).no_return), (30, 0));
    }

    #[test]
    fn a_sphere_around_the_sensor_is_measured() {
        assert_eq!(part(&fan(100, 2.0, 6.0)).no_return, 0);
    }
}
