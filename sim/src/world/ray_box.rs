//! What a hit of a ray is, and where a ray passes a box.

use nalgebra::Vector3;

/// Hits nearer than this are the surface that the ray starts on, metres.
pub(crate) const MIN_HIT_RANGE_M: f64 = 1e-9;

/// Range (metres) and cosine of incidence (0 grazing, 1 square) of a hit.
pub(crate) type RangeAndCosine = (f64, f64);

/// Where a ray enters and leaves a box about the origin; `None` if it passes by.
pub(crate) fn slab(o: &Vector3<f64>, d: &Vector3<f64>, half: &Vector3<f64>) -> Option<[f64; 2]> {
    let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
    for axis in 0..3 {
        if d[axis] == 0.0 {
            if o[axis].abs() > half[axis] {
                return None;
            }
            continue;
        }
        let (a, b) = (
            (-half[axis] - o[axis]) / d[axis],
            (half[axis] - o[axis]) / d[axis],
        );
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    (enter <= leave).then_some([enter, leave])
}
