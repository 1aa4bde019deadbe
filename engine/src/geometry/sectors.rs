//! Sectors around a direction, into which the rays around it are sorted.

use super::constants::SECTORS;
use nalgebra::Vector3;

/// Two unit vectors that span the plane across `d`; the second points up unless `d` does.
pub(super) fn tangents(d: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let pole = if d.z.abs() < 0.95 {
        Vector3::z()
    } else {
        Vector3::x()
    };
    let across = pole.cross(d).normalize();
    (across, d.cross(&across))
}

/// Sector of the offset (x, y), counted counterclockwise from x; sectors are centred on the axes and diagonals.
pub(super) fn sector_of(x: f64, y: f64) -> usize {
    const _: () = assert!(SECTORS == 8);
    // Slopes instead of an arc tangent: tan(22.5 deg) splits axes from diagonals.
    const SLOPE: f64 = 0.414_213_562_373_095_03;
    let (ax, ay) = (x.abs(), y.abs());
    if ay <= SLOPE * ax {
        if x >= 0.0 { 0 } else { 4 }
    } else if ax <= SLOPE * ay {
        if y >= 0.0 { 2 } else { 6 }
    } else {
        match (x >= 0.0, y >= 0.0) {
            (true, true) => 1,
            (false, true) => 3,
            (false, false) => 5,
            (true, false) => 7,
        }
    }
}
