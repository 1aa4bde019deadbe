//! Recorded clouds from files.

use super::failure::Failure;
use super::files;
use nalgebra::{Point3, Vector3};
use patrold_engine::formats::{CloudFile, read_cloud, split_finite};
use std::path::Path;

/// The finite points of a recorded cloud.
#[derive(Debug, Clone)]
pub(super) struct LoadedCloud {
    /// Metres.
    pub points: Vec<Point3<f64>>,
    /// Normals of the points, where the file has them.
    pub normals: Option<Vec<Vector3<f64>>>,
    /// Index in the file of each point.
    pub file_index: Vec<usize>,
    /// Points in the file, non-finite ones included.
    pub in_file: usize,
}

impl LoadedCloud {
    /// Number of non-finite points.
    pub(super) fn dropped(&self) -> usize {
        self.in_file - self.points.len()
    }
}

/// # Errors
/// The file is missing, is no cloud, or has no finite point.
pub(super) fn load(path: &Path) -> Result<LoadedCloud, Failure> {
    let bytes = files::read(path)?;
    let extension = path.extension().and_then(|e| e.to_str());
    let CloudFile { points, normals } =
        read_cloud(&bytes, extension).map_err(|error| files::file_error(path, error))?;
    let (finite, file_index) = split_finite(&points);
    if finite.is_empty() {
        let n = points.len();
        let text = format!("no finite point among {n}; record the cloud again");
        return Err(files::file_error(path, text));
    }
    let keep = |all: Vec<Vector3<f64>>| {
        file_index
            .iter()
            .filter_map(|i| all.get(*i).copied())
            .collect()
    };
    Ok(LoadedCloud {
        points: finite,
        normals: normals.map(keep),
        in_file: points.len(),
        file_index,
    })
}
