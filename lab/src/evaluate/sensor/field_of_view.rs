//! The directions that a sensor covers.

use super::beam_pattern::tilted_scanner_covers;
use nalgebra::Vector3;

/// The directions that a sensor covers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FieldOfView {
    /// A line scanner tilted between these angles, degrees.
    Tilted([f64; 2]),
    /// Rings between these elevations, up to this azimuth on either side, degrees.
    Rings([f64; 3]),
}

impl FieldOfView {
    /// Whether it covers this direction of the base frame.
    pub fn contains(&self, direction: &Vector3<f64>) -> bool {
        match self {
            Self::Tilted(tilts_deg) => tilted_scanner_covers(direction, *tilts_deg),
            Self::Rings([low, high, side]) => {
                let level = direction.x.hypot(direction.y);
                let elevation = direction.z.atan2(level).to_degrees();
                let azimuth = direction.y.atan2(direction.x).to_degrees();
                elevation > *low && elevation < *high && azimuth.abs() < *side
            }
        }
    }
}
