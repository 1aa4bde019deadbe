//! The one origin of all rays of a sweep.

use super::raw::RawSweep;
use crate::geometry::Mount;
use nalgebra::{Point3, Vector3};

/// The mean of the laser's positions (at both ends and in the middle of the tilt of every pan segment), and the largest
/// distance of one of them from it, metres: centimetres with the laser over the pan axis, more with the laser ahead of it.
pub(super) fn common_origin(raw: &RawSweep, mount: &Mount) -> (Point3<f64>, f64) {
    let tilts_rad = [
        raw.tilt_low_rad,
        (raw.tilt_low_rad + raw.tilt_high_rad) / 2.0,
        raw.tilt_high_rad,
    ];
    let positions: Vec<Vector3<f64>> = raw
        .pan_segments
        .iter()
        .flat_map(|segment| tilts_rad.map(|tilt| (segment.pan_rad, tilt)))
        .map(|(pan, tilt)| mount.base_from_laser(pan, tilt).translation.vector)
        .collect();
    let mean = positions.iter().sum::<Vector3<f64>>() / positions.len().max(1) as f64;
    let furthest_m = positions
        .iter()
        .map(|position| (position - mean).norm())
        .fold(0.0, f64::max);
    (Point3::from(mean), furthest_m)
}
