//! Every hit of the sweeps with the tilt of its own instant, as nothing but clock and polls tell it.

use crate::scan::Beam;
use crate::sweep::assemble::SweepError;
use crate::sweep::clock::SensorClock;
use crate::sweep::leg_tilt::LegTilt;
use crate::sweep::raw::RawSweep;
use nalgebra::Vector3;

/// One hit.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibrationBeam {
    /// Which leg of all sweeps.
    pub leg: usize,
    /// Which scan of the leg.
    pub scan: usize,
    /// Which value of the scan.
    pub index: usize,
    /// In the laser's frame.
    pub direction: Vector3<f64>,
    /// Metres.
    pub range_m: f64,
    /// Radians.
    pub pan_rad: f64,
    /// Without time offset and backlash, radians.
    pub tilt_rad: f64,
    /// Signed speed of the tilt, radians per second.
    pub speed_rad_s: f64,
    /// 1 on a travel up, -1 on one down, 0 where the head did not travel.
    pub way: f64,
}

/// The hits of all legs of all sweeps, leg by leg; legs are counted through.
///
/// # Errors
/// Clocks or a motion that do not fit, as in assembly.
pub fn of_sweeps(sweeps: &[RawSweep]) -> Result<Vec<CalibrationBeam>, SweepError> {
    let mut beams = Vec::new();
    let mut leg_number = 0;
    for sweep in sweeps {
        // The tilt as it was measured: what was in force then must not be counted twice.
        let bare = RawSweep {
            time_offset_s: 0.0,
            tilt_backlash_rad: 0.0,
            legs: Vec::new(),
            ..sweep.clone()
        };
        for leg in &sweep.legs {
            let pan_deg = leg.pan_rad.to_degrees();
            let clock = SensorClock::fit(&leg.time_samples, &leg.scans)
                .map_err(|source| SweepError::Clock { pan_deg, source })?;
            let tilt = LegTilt::fit(&bare, leg)
                .map_err(|source| SweepError::Attitude { pan_deg, source })?;
            let period_s = leg.scan_period_s(bare.optics.period_s) * clock.rate;
            let (speed_rad_s, way) = (tilt.speed_rad_s(), tilt.way(leg));
            for (scan_number, scan) in leg.scans.iter().enumerate() {
                let start_s = clock.host_s(scan.stamp_ms);
                let middle_rad = tilt.tilt_rad(scan_number, start_s + period_s / 2.0);
                let inside = (bare.tilt_low_rad..=bare.tilt_high_rad).contains(&middle_rad);
                if !inside || !tilt.covers(start_s) || !tilt.covers(start_s + period_s) {
                    continue;
                }
                for (index, value) in scan.values.iter().enumerate() {
                    let optics = &bare.optics;
                    let Beam::Hit(range_m) = Beam::read(*value, optics.dmin_mm, optics.dmax_mm)
                    else {
                        continue;
                    };
                    let (sin, cos) = optics.azimuth_rad(index).sin_cos();
                    let at_s = start_s + optics.turn_share(index) * period_s;
                    beams.push(CalibrationBeam {
                        leg: leg_number,
                        scan: scan_number,
                        index,
                        direction: Vector3::new(cos, sin, 0.0),
                        range_m,
                        pan_rad: leg.pan_rad,
                        tilt_rad: tilt.tilt_rad(scan_number, at_s),
                        speed_rad_s,
                        way,
                    });
                }
            }
            leg_number += 1;
        }
    }
    Ok(beams)
}
