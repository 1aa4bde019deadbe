//! The content of a cloud file.

use nalgebra::{Point3, Vector3};

/// The content of a cloud file.
#[derive(Debug, Clone, PartialEq)]
pub struct CloudFile {
    /// Every point in file order, metres, including non-finite ones (see [`split_finite`]).
    pub points: Vec<Point3<f64>>,
    /// One normal per point, as stored (not normalised), if the file has all of `nx ny nz` (PCD: `normal_x` ...).
    pub normals: Option<Vec<Vector3<f64>>>,
}

/// The finite points, and for each its index in `points`.
pub fn split_finite(points: &[Point3<f64>]) -> (Vec<Point3<f64>>, Vec<usize>) {
    points
        .iter()
        .enumerate()
        .filter(|(_, p)| p.iter().all(|c| c.is_finite()))
        .map(|(i, p)| (*p, i))
        .unzip()
}

#[cfg(test)]
mod tests {
    use super::split_finite;
    use nalgebra::Point3;

    #[test]
    fn finite_points_keep_their_indices() {
        let points = [
            Point3::new(f64::NAN, 0.0, 0.0),
            Point3::new(1.0, 2.0, 3.0),
            Point3::new(0.0, f64::INFINITY, 0.0),
            Point3::new(4.0, 5.0, 6.0),
        ];
        let (finite, kept) = split_finite(&points);
        assert_eq!(finite, vec![points[1], points[3]]);
        assert_eq!(kept, vec![1, 3]);
    }
}
