//! One place for all rays of a sweep, and how far the laser was from it.

use super::raw::RawSweep;
use crate::geometry::Mount;
use nalgebra::{Point3, Vector3};

/// The mean of the laser's places (at both ends and in the middle of every leg's tilt) and the largest distance of one of
/// them from it, metres. A view has one origin; with the laser over the pan axis they lie within centimetres, ahead of
/// it each pan has a place of its own.
pub fn common(raw: &RawSweep, mount: &Mount) -> (Point3<f64>, f64) {
    let tilts_rad = [
        raw.tilt_low_rad,
        (raw.tilt_low_rad + raw.tilt_high_rad) / 2.0,
        raw.tilt_high_rad,
    ];
    let places: Vec<Vector3<f64>> = raw
        .legs
        .iter()
        .flat_map(|leg| tilts_rad.map(|tilt| (leg.pan_rad, tilt)))
        .map(|(pan, tilt)| mount.base_from_laser(pan, tilt).translation.vector)
        .collect();
    let mean = places.iter().sum::<Vector3<f64>>() / places.len().max(1) as f64;
    let furthest_m = places
        .iter()
        .map(|place| (place - mean).norm())
        .fold(0.0, f64::max);
    (Point3::from(mean), furthest_m)
}
