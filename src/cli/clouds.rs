//! Recorded clouds from files.

use super::failure::Failure;
use super::files;
use nalgebra::{Point3, Vector3};
use patrold_engine::formats::{MeasuredPoints, read_cloud};
use patrold_engine::geometry::View;
use std::path::Path;

/// The measured points of a recorded cloud.
#[derive(Debug, Clone)]
pub(super) struct LoadedCloud {
    /// Points and directions without a return.
    pub measured: MeasuredPoints,
    /// Normals of the points, where the file has them.
    pub normals: Option<Vec<Vector3<f64>>>,
    /// Position of the sensor, metres.
    pub origin: Point3<f64>,
    /// Points in the file, all of them.
    pub in_file: usize,
}

impl LoadedCloud {
    /// The cloud as a sensor saw it.
    pub(super) fn view(&self) -> View {
        let mut view = View::from_points(self.measured.points.clone(), self.origin);
        view.no_return
            .clone_from(&self.measured.no_return_directions);
        view
    }
}

/// Loads the cloud in `path`. The sensor stood at `origin`, else where the file says, else at zero.
///
/// # Errors
/// The file is missing, is no cloud, or has no measured point.
pub(super) fn load(path: &Path, origin: Option<Point3<f64>>) -> Result<LoadedCloud, Failure> {
    let bytes = files::read(path)?;
    let extension = path.extension().and_then(|e| e.to_str());
    let cloud = read_cloud(&bytes, extension).map_err(|error| files::file_error(path, error))?;
    let origin = origin.or(cloud.viewpoint).unwrap_or_default();
    let measured = MeasuredPoints::of(&cloud.points, &origin);
    if measured.points.is_empty() {
        let n = cloud.points.len();
        let text = format!("no finite point among {n}; record the cloud again");
        return Err(files::file_error(path, text));
    }
    let keep = |all: Vec<Vector3<f64>>| {
        let kept = measured.file_index.iter();
        kept.filter_map(|i| all.get(*i).copied()).collect()
    };
    Ok(LoadedCloud {
        normals: cloud.normals.map(keep),
        in_file: cloud.points.len(),
        measured,
        origin,
    })
}
