//! Small simulated clouds: a room with crates, seen from the origin along a grid of rays with range noise.

use nalgebra::{Point3, Vector3};
use patrold_engine::formats::write_ply;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, Normal};
use std::fs;
use std::path::Path;

/// From the origin to the walls.
const ROOM_HALF_SIZE_M: [f64; 3] = [4.0, 3.0, 1.3];
/// Standard deviation of the ranges.
const NOISE_M: f64 = 0.004;
/// In azimuth and elevation.
const RAY_STEP_DEG: f64 = 1.0;

/// Centre and full sizes, metres.
pub(crate) type Crate = ([f64; 3], [f64; 3]);

/// Large enough to be found in any case.
pub(crate) const CRATE: Crate = ([2.0, 0.6, -0.9], [0.5, 0.6, 0.8]);

pub(crate) fn room_points(crates: &[Crate], seed: u64) -> Vec<Point3<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let noise = Normal::new(0.0, NOISE_M).expect("a noise law");
    let mut points = Vec::new();
    let rows = (60.0 / RAY_STEP_DEG) as i32;
    let columns = (240.0 / RAY_STEP_DEG) as i32;
    for row in 0..=rows {
        for column in 0..=columns {
            let elevation = (f64::from(row) * RAY_STEP_DEG - 35.0).to_radians();
            let azimuth = (f64::from(column) * RAY_STEP_DEG - 120.0).to_radians();
            let (up, level) = elevation.sin_cos();
            let ray = Vector3::new(level * azimuth.cos(), level * azimuth.sin(), up);
            let range = crates
                .iter()
                .filter_map(|c| crate_distance(&ray, c))
                .fold(wall_distance(&ray), f64::min);
            points.push(Point3::from(ray * (range + noise.sample(&mut rng))));
        }
    }
    points
}

fn wall_distance(ray: &Vector3<f64>) -> f64 {
    (0..3)
        .map(|a| ROOM_HALF_SIZE_M[a] / ray[a].abs())
        .fold(f64::INFINITY, f64::min)
}

fn crate_distance(ray: &Vector3<f64>, (centre, size): &Crate) -> Option<f64> {
    let (mut near, mut far) = (0.0f64, f64::INFINITY);
    for a in 0..3 {
        let ends = [-0.5, 0.5].map(|half| (centre[a] + half * size[a]) / ray[a]);
        near = near.max(ends[0].min(ends[1]));
        far = far.min(ends[0].max(ends[1]));
    }
    (near < far && near > 0.0).then_some(near)
}

/// On or in the crate, within the noise.
pub(crate) fn is_on((centre, size): &Crate, point: &Point3<f64>) -> bool {
    (0..3).all(|a| (point[a] - centre[a]).abs() < 0.5 * size[a] + 4.0 * NOISE_M)
}

pub(crate) fn write(path: &Path, points: &[Point3<f64>]) {
    fs::write(path, write_ply(points)).expect("written");
}

/// A folder with `then.ply`, `again.ply` (only the noise differs) and `now.ply` (with [`CRATE`]).
pub(crate) fn folder() -> tempfile::TempDir {
    let dir = tempfile::tempdir().expect("temp dir");
    write(&dir.path().join("then.ply"), &room_points(&[], 1));
    write(&dir.path().join("again.ply"), &room_points(&[], 2));
    write(&dir.path().join("now.ply"), &room_points(&[CRATE], 3));
    dir
}
