//! Direction and time of each beam within a revolution: the beam model of sweep-geometry section 1.

use std::f64::consts::TAU;

/// The parameters of the sensor (PP, scip2 section 6) and of the requested scan.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanGeometry {
    /// Steps per turn (ARES).
    pub steps_per_turn: u32,
    /// Step that points forward (AFRT).
    pub front_step: u32,
    /// Step of the first value of a scan.
    pub first_step: u32,
    /// Steps merged into one value; at least 1.
    pub cluster: u32,
    /// Smallest distance (DMIN), millimetres; values below are codes.
    pub dmin_mm: u32,
    /// Largest distance (DMAX), millimetres.
    pub dmax_mm: u32,
    /// Nominal time of one turn, seconds.
    pub period_s: f64,
}

impl ScanGeometry {
    /// Step at the middle of value `index`.
    fn step(&self, index: usize) -> f64 {
        let cluster = f64::from(self.cluster.max(1));
        f64::from(self.first_step) + index as f64 * cluster + (cluster - 1.0) / 2.0
    }

    /// Azimuth of value `index`, radians, positive to the left.
    pub fn azimuth_rad(&self, index: usize) -> f64 {
        (self.step(index) - f64::from(self.front_step)) * TAU / f64::from(self.steps_per_turn)
    }

    /// Share of a turn between step 0, to which the time stamp refers, and value `index`.
    pub fn turn_share(&self, index: usize) -> f64 {
        self.step(index) / f64::from(self.steps_per_turn)
    }
}

#[cfg(test)]
mod tests {
    use super::ScanGeometry;

    #[test]
    fn a_urg_scans_from_right_to_left() {
        // scip2 section 1: step 44 = -119.531 deg, 384 = 0, 725 = +119.883 deg; scip2 section 8: step 44 +4.3 ms.
        let urg = ScanGeometry {
            steps_per_turn: 1024,
            front_step: 384,
            first_step: 44,
            cluster: 1,
            dmin_mm: 20,
            dmax_mm: 5600,
            period_s: 0.1,
        };
        assert!((urg.azimuth_rad(0).to_degrees() + 119.531).abs() < 1e-3);
        assert_eq!(urg.azimuth_rad(340), 0.0);
        assert!((urg.azimuth_rad(681).to_degrees() - 119.883).abs() < 1e-3);
        assert!((urg.turn_share(0) * 100.0 - 4.3).abs() < 0.01);
    }
}
