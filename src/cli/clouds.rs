//! Recorded clouds from files, for the commands that take them.

use super::failure::Failure;
use super::files;
use nalgebra::{Point3, Vector3};
use patrold_engine::formats::{CloudFile, read_cloud, split_finite};
use std::path::Path;

/// A recorded cloud with its non-finite points set aside.
#[derive(Debug, Clone)]
pub struct LoadedCloud {
    /// Finite points, metres.
    pub points: Vec<Point3<f64>>,
    /// Normals of those points, where the file has them.
    pub normals: Option<Vec<Vector3<f64>>>,
    /// Index in the file of each point.
    pub file_index: Vec<usize>,
    /// Points in the file, non-finite ones included.
    pub in_file: usize,
}

impl LoadedCloud {
    /// Non-finite points that were dropped.
    pub fn dropped(&self) -> usize {
        self.in_file - self.points.len()
    }
}

/// Reads the cloud in `path`.
///
/// # Errors
/// The file is missing, is no cloud, or has no finite point.
pub fn load(path: &Path) -> Result<LoadedCloud, Failure> {
    let bytes = files::read(path)?;
    let extension = path.extension().and_then(|e| e.to_str());
    let CloudFile { points, normals } =
        read_cloud(&bytes, extension).map_err(|error| files::named(path, error))?;
    let (finite, file_index) = split_finite(&points);
    if finite.is_empty() {
        let n = points.len();
        let told = format!("no finite point among {n}; record the cloud again");
        return Err(files::named(path, told));
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

/// Reads `X,Y,Z` in metres.
///
/// # Errors
/// What was expected.
pub fn parse_point(text: &str) -> Result<Point3<f64>, String> {
    let numbers: Vec<f64> = text
        .split(',')
        .map(|part| part.trim().parse::<f64>().ok().filter(|x| x.is_finite()))
        .collect::<Option<_>>()
        .ok_or_else(|| format!("expected three numbers X,Y,Z, got {text:?}"))?;
    match numbers[..] {
        [x, y, z] => Ok(Point3::new(x, y, z)),
        _ => Err(format!(
            "expected three numbers X,Y,Z, got {}",
            numbers.len()
        )),
    }
}
