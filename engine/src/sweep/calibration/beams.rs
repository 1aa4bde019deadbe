//! Every hit of the sweeps with the tilt at its own time, from clock and polls alone.

use crate::scan::Beam;
use crate::sweep::clock::SensorClock;
use crate::sweep::error::SweepError;
use crate::sweep::pan_segment_tilt::PanSegmentTilt;
use crate::sweep::raw::RawSweep;
use nalgebra::Vector3;

/// A beam with a return.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibrationBeam {
    /// Number of its pan segment, counted through all sweeps.
    pub pan_segment: usize,
    /// Index of its scan in the pan segment.
    pub scan: usize,
    /// Index of its value in the scan.
    pub index: usize,
    /// Unit vector in the laser frame.
    pub direction: Vector3<f64>,
    /// Range, metres.
    pub range_m: f64,
    /// Pan, radians.
    pub pan_rad: f64,
    /// Tilt without time offset and backlash, radians.
    pub tilt_rad: f64,
    /// Signed speed of the tilt, radians per second.
    pub speed_rad_s: f64,
    /// 1 on a travel up, -1 on one down, 0 without travel.
    pub travel_direction: f64,
}

/// The hits of all sweeps, in the order of their pan segments.
///
/// # Errors
/// A clock or a motion of the head that cannot be fitted.
pub fn calibration_beams(sweeps: &[RawSweep]) -> Result<Vec<CalibrationBeam>, SweepError> {
    let mut beams = Vec::new();
    let mut segment_number = 0;
    for sweep in sweeps {
        // The tilt as measured: the corrections that were configured then must not be applied twice.
        let uncorrected = RawSweep {
            time_offset_s: 0.0,
            tilt_backlash_rad: 0.0,
            pan_segments: Vec::new(),
            ..sweep.clone()
        };
        for segment in &sweep.pan_segments {
            let pan_deg = segment.pan_rad.to_degrees();
            let clock = SensorClock::fit(&segment.time_samples, &segment.scans)
                .map_err(|source| SweepError::Clock { pan_deg, source })?;
            let tilt = PanSegmentTilt::fit(&uncorrected, segment)
                .map_err(|source| SweepError::Motion { pan_deg, source })?;
            let period_s = segment.scan_period_s(uncorrected.scan_geometry.period_s) * clock.rate;
            let (speed_rad_s, travel_direction) =
                (tilt.speed_rad_s(), tilt.travel_direction(segment));
            for (scan_number, scan) in segment.scans.iter().enumerate() {
                let start_s = clock.host_s(scan.stamp_ms);
                let middle_rad = tilt.tilt_rad(scan_number, start_s + period_s / 2.0);
                let inside =
                    (uncorrected.tilt_low_rad..=uncorrected.tilt_high_rad).contains(&middle_rad);
                if !inside || !tilt.covers(start_s) || !tilt.covers(start_s + period_s) {
                    continue;
                }
                for (index, value) in scan.values.iter().enumerate() {
                    let scan_geometry = &uncorrected.scan_geometry;
                    let Beam::Hit(range_m) =
                        Beam::from_raw(*value, scan_geometry.dmin_mm, scan_geometry.dmax_mm)
                    else {
                        continue;
                    };
                    let (sin, cos) = scan_geometry.azimuth_rad(index).sin_cos();
                    let at_s = start_s + scan_geometry.turn_share(index) * period_s;
                    beams.push(CalibrationBeam {
                        pan_segment: segment_number,
                        scan: scan_number,
                        index,
                        direction: Vector3::new(cos, sin, 0.0),
                        range_m,
                        pan_rad: segment.pan_rad,
                        tilt_rad: tilt.tilt_rad(scan_number, at_s),
                        speed_rad_s,
                        travel_direction,
                    });
                }
            }
            segment_number += 1;
        }
    }
    Ok(beams)
}
