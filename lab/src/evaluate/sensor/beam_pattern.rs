//! The beams of a sweep: line by line, each from the pose that the sensor then has.

use crate::evaluate::constants::URG_STEPS;
use nalgebra::{Point3, Unit, Vector3};
use patrold_engine::geometry::Pose;
use patrold_sim::world::{MountGeometry, azimuth_rad};
use std::sync::Arc;

/// The beams of one line.
#[derive(Debug, Clone)]
pub struct BeamLine {
    pub base_from_sensor: Pose,
    /// In the sensor's frame, in scan order.
    pub directions: Arc<Vec<Unit<Vector3<f64>>>>,
}

/// The beams of a sweep.
#[derive(Debug, Clone)]
pub struct BeamPattern {
    pub lines: Vec<BeamLine>,
    /// The tilt axis that a sweep states, base frame.
    pub tilt_axis: Option<Unit<Vector3<f64>>>,
}

/// The rows of a tilted line scanner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ScanRows {
    /// Tilt of the first row, degrees, up positive.
    pub from_deg: f64,
    /// Tilt of the last row.
    pub to_deg: f64,
    pub count: usize,
    /// Steps from beam to beam; 1 is the sensor's own.
    pub stride: usize,
    /// Shift of all rows as a share of their distance.
    pub row_offset: f64,
    /// Shift of all beams as a share of a step.
    pub step_offset: f64,
}

impl ScanRows {
    pub(crate) fn pattern(&self) -> BeamPattern {
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
        let step_deg = (self.to_deg - self.from_deg) / self.count.saturating_sub(1).max(1) as f64;
        let line = |i: usize| {
            let tilt_deg = self.from_deg + step_deg * (i as f64 + self.row_offset);
            BeamLine {
                base_from_sensor: mount.base_from_laser(0.0, tilt_deg.to_radians()),
                directions: Arc::clone(&directions),
            }
        };
        BeamPattern {
            lines: (0..self.count).map(line).collect(),
            tilt_axis: Some(mount.tilt_axis(0.0)),
        }
    }
}

impl BeamPattern {
    /// Mean position of the sensor, base frame.
    pub fn origin(&self) -> Point3<f64> {
        let sum: Vector3<f64> = self
            .lines
            .iter()
            .map(|l| l.base_from_sensor.translation.vector)
            .sum();
        Point3::from(sum / self.lines.len().max(1) as f64)
    }
}

/// Whether a line scanner tilted between these angles (degrees) covers a direction of the base frame.
pub(crate) fn tilted_scanner_covers(direction: &Vector3<f64>, tilts_deg: [f64; 2]) -> bool {
    let d = direction.normalize();
    let off_axis = d.y.clamp(-1.0, 1.0).asin().abs();
    // Beams behind the tilt axis go down when the head goes up.
    let ahead = d.z.atan2(d.x).to_degrees();
    let behind = (-d.z).atan2(-d.x).to_degrees();
    let max_azimuth = azimuth_rad(URG_STEPS.1).min(-azimuth_rad(URG_STEPS.0));
    let in_range = |tilt: f64| tilt > tilts_deg[0] && tilt < tilts_deg[1];
    if d.x.abs() < 1e-9 && d.z.abs() < 1e-9 {
        return true;
    }
    in_range(ahead) || (std::f64::consts::PI - off_axis < max_azimuth && in_range(behind))
}

#[cfg(test)]
mod tests {
    use super::{ScanRows, tilted_scanner_covers};
    use nalgebra::Vector3;

    const ROWS: ScanRows = ScanRows {
        from_deg: -40.0,
        to_deg: 30.0,
        count: 71,
        stride: 1,
        row_offset: 0.0,
        step_offset: 0.0,
    };

    #[test]
    fn every_beam_is_covered() {
        for (i, line) in ROWS.pattern().lines.iter().enumerate().skip(1) {
            if i == 70 {
                continue;
            }
            for d in line.directions.iter() {
                let d = line.base_from_sensor.rotation * d.into_inner();
                let inner = d.y.abs() < 0.999 && (d.x > 0.0 || d.y.abs() > 0.871);
                assert!(
                    !inner || tilted_scanner_covers(&d, [-40.0, 30.0]),
                    "{i} {d}"
                );
            }
        }
    }

    #[test]
    fn straight_back_up_and_down_are_not_covered() {
        for d in [
            -Vector3::x(),
            Vector3::z(),
            -Vector3::z(),
            Vector3::new(1.0, 0.0, 0.7),
        ] {
            assert!(!tilted_scanner_covers(&d, [-40.0, 30.0]), "{d}");
        }
        assert!(tilted_scanner_covers(&Vector3::x(), [-40.0, 30.0]));
        assert!(tilted_scanner_covers(
            &Vector3::new(1.0, 0.0, 0.5),
            [-40.0, 30.0]
        ));
        // Behind the axis, tilted down by 35 deg in front: up there.
        assert!(tilted_scanner_covers(
            &Vector3::new(-0.3, 1.0, 0.2),
            [-40.0, 30.0]
        ));
        assert!(!tilted_scanner_covers(
            &Vector3::new(-0.3, 1.0, -0.2),
            [-40.0, 30.0]
        ));
    }
}
