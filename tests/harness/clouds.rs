//! Small clouds of an analytic room, seen from the origin through a grid of rays with range noise.

use nalgebra::{Point3, Vector3};
use patrold_engine::formats::write_ply;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, Normal};
use std::fs;
use std::path::Path;

/// Half sizes of the room, metres.
const ROOM: [f64; 3] = [4.0, 3.0, 1.3];
/// Standard deviation of the range, metres.
const NOISE_M: f64 = 0.004;
/// Rays per degree, both ways.
const STEP_DEG: f64 = 1.0;

/// A box that stands in the room: its middle and its full sizes.
pub type Crate = ([f64; 3], [f64; 3]);

/// A crate large enough that nobody misses it.
pub const CRATE: Crate = ([2.0, 0.6, -0.9], [0.5, 0.6, 0.8]);

/// What the sensor sees of the room with these crates in it.
pub fn room(crates: &[Crate], seed: u64) -> Vec<Point3<f64>> {
    let mut chance = ChaCha8Rng::seed_from_u64(seed);
    let noise = Normal::new(0.0, NOISE_M).expect("a noise law");
    let mut points = Vec::new();
    let rows = (60.0 / STEP_DEG) as i32;
    let columns = (240.0 / STEP_DEG) as i32;
    for row in 0..=rows {
        for column in 0..=columns {
            let elevation = (f64::from(row) * STEP_DEG - 35.0).to_radians();
            let azimuth = (f64::from(column) * STEP_DEG - 120.0).to_radians();
            let (up, level) = elevation.sin_cos();
            let ray = Vector3::new(level * azimuth.cos(), level * azimuth.sin(), up);
            let range = crates
                .iter()
                .filter_map(|c| entry(&ray, c))
                .fold(exit(&ray), f64::min);
            points.push(Point3::from(ray * (range + noise.sample(&mut chance))));
        }
    }
    points
}

/// Distance to the room's wall.
fn exit(ray: &Vector3<f64>) -> f64 {
    (0..3)
        .map(|a| ROOM[a] / ray[a].abs())
        .fold(f64::INFINITY, f64::min)
}

/// Distance to where the ray enters the crate.
fn entry(ray: &Vector3<f64>, (middle, size): &Crate) -> Option<f64> {
    let (mut near, mut far) = (0.0f64, f64::INFINITY);
    for a in 0..3 {
        let ends = [-0.5, 0.5].map(|half| (middle[a] + half * size[a]) / ray[a]);
        near = near.max(ends[0].min(ends[1]));
        far = far.min(ends[0].max(ends[1]));
    }
    (near < far && near > 0.0).then_some(near)
}

/// Whether a point lies on or in the crate.
pub fn on((middle, size): &Crate, point: &Point3<f64>) -> bool {
    (0..3).all(|a| (point[a] - middle[a]).abs() < 0.5 * size[a] + 4.0 * NOISE_M)
}

/// Writes a cloud as PLY.
pub fn write(path: &Path, points: &[Point3<f64>]) {
    fs::write(path, write_ply(points)).expect("written");
}

/// A folder with `then.ply`, `again.ply` (only the noise differs) and `now.ply` (with [`CRATE`]).
pub fn folder() -> tempfile::TempDir {
    let dir = tempfile::tempdir().expect("temp dir");
    write(&dir.path().join("then.ply"), &room(&[], 1));
    write(&dir.path().join("again.ply"), &room(&[], 2));
    write(&dir.path().join("now.ply"), &room(&[CRATE], 3));
    dir
}
