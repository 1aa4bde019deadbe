//! Which beams a sensor takes: line by line, each from where the sensor then is.

use crate::evaluate::constants::URG_STEPS;
use nalgebra::{Point3, Unit, Vector3};
use patrold_engine::geometry::Pose;
use patrold_sim::world::{MountGeometry, azimuth_rad};
use std::sync::Arc;

/// The beams of one line.
#[derive(Debug, Clone)]
pub struct Line {
    /// Where the sensor is, in the base frame.
    pub base_from_sensor: Pose,
    /// Directions in the sensor's frame, neighbours side by side.
    pub directions: Arc<Vec<Unit<Vector3<f64>>>>,
}

/// The beams of a sweep.
#[derive(Debug, Clone)]
pub struct Pattern {
    /// Its lines.
    pub lines: Vec<Line>,
    /// What a sweep tells of its tilt axis, base frame.
    pub tilt_axis: Option<Unit<Vector3<f64>>>,
}

/// A tilted line scanner's rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rows {
    /// Tilt of the first row, degrees, up positive.
    pub from_deg: f64,
    /// Tilt of the last row.
    pub to_deg: f64,
    /// How many.
    pub count: usize,
    /// Every so many steps a beam: 1 is the sensor's own way.
    pub stride: usize,
    /// All rows are moved by this share of their distance.
    pub row_offset: f64,
    /// All steps are moved by this share of a step.
    pub step_offset: f64,
}

impl Rows {
    /// The beams.
    pub fn pattern(&self) -> Pattern {
        let mount = MountGeometry::default();
        let step_rad = azimuth_rad(1) - azimuth_rad(0);
        let directions: Vec<Unit<Vector3<f64>>> = (URG_STEPS.0..=URG_STEPS.1)
            .step_by(self.stride.max(1))
            .map(|step| {
                let (sin, cos) = (azimuth_rad(step) + self.step_offset * step_rad).sin_cos();
                Unit::new_unchecked(Vector3::new(cos, sin, 0.0))
            })
            .collect();
        let directions = Arc::new(directions);
        let apart = (self.to_deg - self.from_deg) / self.count.saturating_sub(1).max(1) as f64;
        let line = |i: usize| {
            let tilt_deg = self.from_deg + apart * (i as f64 + self.row_offset);
            Line {
                base_from_sensor: mount.base_from_laser(0.0, tilt_deg.to_radians()),
                directions: Arc::clone(&directions),
            }
        };
        Pattern {
            lines: (0..self.count).map(line).collect(),
            tilt_axis: Some(mount.tilt_axis(0.0)),
        }
    }
}

impl Pattern {
    /// Mean of the sensor's places, base frame.
    pub fn origin(&self) -> Point3<f64> {
        let sum: Vector3<f64> = self
            .lines
            .iter()
            .map(|l| l.base_from_sensor.translation.vector)
            .sum();
        Point3::from(sum / self.lines.len().max(1) as f64)
    }
}

/// Whether a line scanner tilted between these angles (degrees) looks into a direction of the base frame.
pub fn looks_at(direction: &Vector3<f64>, tilts_deg: [f64; 2]) -> bool {
    let d = direction.normalize();
    let off_axis = d.y.clamp(-1.0, 1.0).asin().abs();
    // Beams behind the tilt axis go down when the head goes up.
    let ahead = d.z.atan2(d.x).to_degrees();
    let behind = (-d.z).atan2(-d.x).to_degrees();
    let widest = azimuth_rad(URG_STEPS.1).min(-azimuth_rad(URG_STEPS.0));
    let within = |tilt: f64| tilt > tilts_deg[0] && tilt < tilts_deg[1];
    if d.x.abs() < 1e-9 && d.z.abs() < 1e-9 {
        return true;
    }
    within(ahead) || (std::f64::consts::PI - off_axis < widest && within(behind))
}

#[cfg(test)]
mod tests {
    use super::{Rows, looks_at};
    use nalgebra::Vector3;

    const ROWS: Rows = Rows {
        from_deg: -40.0,
        to_deg: 30.0,
        count: 71,
        stride: 1,
        row_offset: 0.0,
        step_offset: 0.0,
    };

    #[test]
    fn every_beam_is_looked_along() {
        for (i, line) in ROWS.pattern().lines.iter().enumerate().skip(1) {
            if i == 70 {
                continue;
            }
            for d in line.directions.iter() {
                let d = line.base_from_sensor.rotation * d.into_inner();
                let inner = d.y.abs() < 0.999 && (d.x > 0.0 || d.y.abs() > 0.871);
                assert!(!inner || looks_at(&d, [-40.0, 30.0]), "{i} {d}");
            }
        }
    }

    #[test]
    fn straight_back_up_and_down_are_not_seen() {
        for d in [
            -Vector3::x(),
            Vector3::z(),
            -Vector3::z(),
            Vector3::new(1.0, 0.0, 0.7),
        ] {
            assert!(!looks_at(&d, [-40.0, 30.0]), "{d}");
        }
        assert!(looks_at(&Vector3::x(), [-40.0, 30.0]));
        assert!(looks_at(&Vector3::new(1.0, 0.0, 0.5), [-40.0, 30.0]));
        // Behind the axis, tilted down by 35 deg in front: up there.
        assert!(looks_at(&Vector3::new(-0.3, 1.0, 0.2), [-40.0, 30.0]));
        assert!(!looks_at(&Vector3::new(-0.3, 1.0, -0.2), [-40.0, 30.0]));
    }
}
