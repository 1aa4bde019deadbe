//! From raw data to one view: every beam projected with its own instant (sweep-geometry sections 1-3).

use super::attitude::{Attitude, AttitudeError};
use super::clock::{ClockError, SensorClock};
use super::constants::{FREE_RANGE_M, FROZEN_SCANS, GAP_PERIODS, URG_NOISE};
use super::quality::Quality;
use super::raw::{Leg, Motion, RawScan, RawSweep};
use crate::geometry::{Mount, View};
use crate::scan::Beam;
use nalgebra::{Point3, Unit, Vector3};

/// One look around: what was seen, and how well.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    /// Points in the base's frame.
    pub view: View,
    /// Quality figures.
    pub quality: Quality,
}

/// Why raw data gives no view.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SweepError {
    /// There is nothing in it.
    #[error("sweep has no scans")]
    Empty,
    /// The clocks do not fit.
    #[error("sweep at pan {pan_deg:.1} deg: {source}")]
    Clock {
        /// Pan of the leg.
        pan_deg: f64,
        /// Why.
        source: ClockError,
    },
    /// The head's motion does not fit.
    #[error("sweep at pan {pan_deg:.1} deg: {source}")]
    Attitude {
        /// Pan of the leg.
        pan_deg: f64,
        /// Why.
        source: AttitudeError,
    },
}

/// Projects every beam of every leg into the base's frame.
///
/// # Errors
/// No scans, clocks that do not fit, a head that did not follow its command.
pub fn assemble(raw: &RawSweep, mount: &Mount) -> Result<Sweep, SweepError> {
    let mut gathered = Gathered::default();
    for leg in &raw.legs {
        gathered.add(raw, leg, mount)?;
    }
    if gathered.lines == 0 {
        return Err(SweepError::Empty);
    }
    Ok(gathered.finish(raw, mount))
}

#[derive(Default)]
struct Gathered {
    points: Vec<Point3<f64>>,
    no_return: Vec<Unit<Vector3<f64>>>,
    beams: usize,
    lines: usize,
    gaps: usize,
    residual_steps: f64,
    clock_uncertainty_s: f64,
    clock_rate: f64,
    frozen: bool,
}

impl Gathered {
    fn add(&mut self, raw: &RawSweep, leg: &Leg, mount: &Mount) -> Result<(), SweepError> {
        let pan_deg = leg.pan_rad.to_degrees();
        let clock = SensorClock::fit(&leg.time_samples, &leg.scans)
            .map_err(|source| SweepError::Clock { pan_deg, source })?;
        let tilt = LegTilt::fit(leg).map_err(|source| SweepError::Attitude { pan_deg, source })?;
        let period_s = scan_period_s(&leg.scans, raw.optics.period_s) * clock.rate;
        for (index, scan) in leg.scans.iter().enumerate() {
            let start_s = clock.host_s(scan.stamp_ms);
            let tilt_rad = |share: f64| {
                raw.tilt_zero_rad
                    + raw.tilt_rad_per_step * tilt.steps(index, start_s + share * period_s)
            };
            let middle_rad = tilt_rad(0.5);
            if !(raw.tilt_low_rad..=raw.tilt_high_rad).contains(&middle_rad) {
                continue;
            }
            self.lines += 1;
            self.project(raw, scan, |share| {
                mount.base_from_laser(leg.pan_rad, tilt_rad(share))
            });
        }
        self.gaps += gaps(&leg.scans, raw.optics.period_s, &leg.motion);
        self.frozen |= is_frozen(&leg.scans);
        self.residual_steps = self.residual_steps.max(tilt.residual_steps());
        self.clock_uncertainty_s = self.clock_uncertainty_s.max(clock.uncertainty_s);
        self.clock_rate = clock.rate;
        Ok(())
    }

    fn project(
        &mut self,
        raw: &RawSweep,
        scan: &RawScan,
        base_from_laser: impl Fn(f64) -> crate::geometry::Pose,
    ) {
        let optics = &raw.optics;
        self.beams += scan.values.len();
        for (index, value) in scan.values.iter().enumerate() {
            let beam = Beam::read(*value, optics.dmin_mm, optics.dmax_mm);
            if beam == Beam::Unknown {
                continue;
            }
            let (sin, cos) = optics.azimuth_rad(index).sin_cos();
            let direction = Vector3::new(cos, sin, 0.0);
            let pose = base_from_laser(optics.turn_share(index));
            match beam {
                Beam::Hit(range_m) => self.points.push(pose * Point3::from(direction * range_m)),
                _ => self
                    .no_return
                    .push(Unit::new_unchecked(pose.rotation * direction)),
            }
        }
    }

    fn finish(self, raw: &RawSweep, mount: &Mount) -> Sweep {
        let span_rad = raw.tilt_high_rad - raw.tilt_low_rad;
        let lines_per_leg = (span_rad / raw.line_pitch_rad).floor() as usize + 1;
        let beams = self.beams.max(1) as f64;
        let quality = Quality {
            lines_expected: lines_per_leg * raw.legs.len(),
            lines_got: self.lines,
            gaps: self.gaps,
            hit_share: self.points.len() as f64 / beams,
            no_return_share: self.no_return.len() as f64 / beams,
            position_residual_steps: self.residual_steps,
            clock_uncertainty_s: self.clock_uncertainty_s,
            clock_rate: self.clock_rate,
            frozen: self.frozen,
        };
        // One origin for all beams: the laser's place half-way through the tilt of the middle leg.
        let middle_pan = raw
            .legs
            .get(raw.legs.len() / 2)
            .map_or(0.0, |leg| leg.pan_rad);
        let middle_tilt = (raw.tilt_low_rad + raw.tilt_high_rad) / 2.0;
        let view = View {
            origin: mount.base_from_laser(middle_pan, middle_tilt) * Point3::origin(),
            points: self.points,
            no_return: self.no_return,
            free_range_m: FREE_RANGE_M,
            noise: Some(URG_NOISE),
        };
        Sweep { view, quality }
    }
}

enum LegTilt<'a> {
    Tilting(Attitude),
    Standing(&'a [i32]),
}

impl<'a> LegTilt<'a> {
    fn fit(leg: &'a Leg) -> Result<Self, AttitudeError> {
        match &leg.motion {
            Motion::Tilting { speed_steps_s } => {
                Ok(Self::Tilting(Attitude::fit(&leg.polls, *speed_steps_s)?))
            }
            Motion::Standing { tilt_steps } => Ok(Self::Standing(tilt_steps)),
        }
    }

    fn steps(&self, scan: usize, host_s: f64) -> f64 {
        match self {
            Self::Tilting(attitude) => attitude.tilt_steps(host_s),
            Self::Standing(steps) => steps.get(scan).map_or(f64::NAN, |s| f64::from(*s)),
        }
    }

    fn residual_steps(&self) -> f64 {
        match self {
            Self::Tilting(attitude) => attitude.residual_steps,
            Self::Standing(_) => 0.0,
        }
    }
}

/// Time of one turn on the sensor's clock: the mean over the longest run, for single stamps are rounded to 1 ms.
fn scan_period_s(scans: &[RawScan], nominal_s: f64) -> f64 {
    let (Some(first), Some(last)) = (scans.first(), scans.last()) else {
        return nominal_s;
    };
    let span_s = last.stamp_ms.saturating_sub(first.stamp_ms) as f64 * 1e-3;
    let turns = (span_s / nominal_s).round();
    if turns >= 1.0 {
        span_s / turns
    } else {
        nominal_s
    }
}

fn gaps(scans: &[RawScan], period_s: f64, motion: &Motion) -> usize {
    if matches!(motion, Motion::Standing { .. }) {
        return 0;
    }
    let far = |pair: &&[RawScan]| {
        let apart_ms = pair[1].stamp_ms.saturating_sub(pair[0].stamp_ms);
        apart_ms as f64 * 1e-3 > GAP_PERIODS * period_s
    };
    scans.windows(2).filter(far).count()
}

fn is_frozen(scans: &[RawScan]) -> bool {
    scans.windows(FROZEN_SCANS).any(|run| {
        let first = &run[0].values;
        let lively = first.iter().any(|v| *v != 0);
        lively && run.iter().all(|scan| scan.values == *first)
    })
}

#[cfg(test)]
mod tests;
