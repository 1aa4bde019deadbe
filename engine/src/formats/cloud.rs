//! The content of a cloud file.

use nalgebra::{Point3, Vector3};

/// Largest coordinate of a cloud: no place on Earth has a larger one, even in millimetres, and damaged numbers have.
pub(super) const MAX_COORDINATE: f64 = 1e11;

/// The content of a cloud file.
#[derive(Debug, Clone, PartialEq)]
pub struct CloudFile {
    /// Every point in file order, metres, including non-finite ones (see [`MeasuredPoints`]).
    pub points: Vec<Point3<f64>>,
    /// One normal per point, as stored (not normalised), if the file has all three components.
    pub normals: Option<Vec<Vector3<f64>>>,
    /// Where the sensor stood, metres, if the file says so (`VIEWPOINT` of a PCD).
    pub viewpoint: Option<Point3<f64>>,
}
