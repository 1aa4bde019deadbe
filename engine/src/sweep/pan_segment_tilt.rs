//! The tilt of a pan segment at any time: fitted motion, calibrated time offset and backlash.

use super::raw::{HeadMotion, PanSegment, RawSweep};
use super::tilt_motion::{TiltMotion, TiltMotionError, TiltRange};

/// The tilt of a pan segment.
pub(super) struct PanSegmentTilt<'a> {
    source: TiltSource<'a>,
    zero_rad: f64,
    rad_per_step: f64,
    time_offset_s: f64,
    lag_rad: f64,
}

enum TiltSource<'a> {
    /// The motion, and for how many seconds before and after its polls it is valid.
    Tilting(TiltMotion, f64),
    /// The position of each scan, counts.
    StepAndStare(&'a [i32]),
}

impl<'a> PanSegmentTilt<'a> {
    /// Fits the motion; time offset and backlash are those of `raw`.
    ///
    /// # Errors
    /// A head that did not follow its command from end to end.
    pub(super) fn fit(raw: &RawSweep, segment: &'a PanSegment) -> Result<Self, TiltMotionError> {
        let source = match &segment.motion {
            HeadMotion::Tilting { speed_steps_s } => {
                let range = TiltRange {
                    zero_rad: raw.tilt_zero_rad,
                    rad_per_step: raw.tilt_rad_per_step,
                    low_rad: raw.tilt_low_rad,
                    high_rad: raw.tilt_high_rad,
                    pitch_rad: raw.line_pitch_rad,
                };
                let motion = TiltMotion::fit(&segment.polls, *speed_steps_s)?;
                range.check(&segment.polls)?;
                TiltSource::Tilting(motion, range.tolerance_s(&motion))
            }
            HeadMotion::StepAndStare { tilt_steps } => TiltSource::StepAndStare(tilt_steps),
        };
        let mut tilt = Self {
            source,
            zero_rad: raw.tilt_zero_rad,
            rad_per_step: raw.tilt_rad_per_step,
            time_offset_s: raw.time_offset_s,
            lag_rad: 0.0,
        };
        tilt.lag_rad = tilt.travel_direction(segment) * raw.tilt_backlash_rad / 2.0;
        Ok(tilt)
    }

    /// Tilt in radians during scan `scan` at a host time.
    pub(super) fn tilt_rad(&self, scan: usize, host_s: f64) -> f64 {
        let steps = match &self.source {
            TiltSource::Tilting(motion, _) => motion.tilt_steps(host_s + self.time_offset_s),
            TiltSource::StepAndStare(steps) => steps.get(scan).map_or(f64::NAN, |s| f64::from(*s)),
        };
        self.zero_rad + self.rad_per_step * steps - self.lag_rad
    }

    /// Signed speed of the tilt, radians per second.
    pub(super) fn speed_rad_s(&self) -> f64 {
        match &self.source {
            TiltSource::Tilting(motion, _) => motion.speed_steps_s() * self.rad_per_step,
            TiltSource::StepAndStare(_) => 0.0,
        }
    }

    /// Direction of travel: 1 up, -1 down, 0 without travel.
    pub(super) fn travel_direction(&self, segment: &PanSegment) -> f64 {
        let travel = match &segment.motion {
            HeadMotion::Tilting { .. } => self.speed_rad_s(),
            HeadMotion::StepAndStare { tilt_steps } => {
                match (tilt_steps.first(), tilt_steps.last()) {
                    (Some(first), Some(last)) => {
                        (f64::from(*last) - f64::from(*first)) * self.rad_per_step
                    }
                    _ => 0.0,
                }
            }
        };
        if travel == 0.0 { 0.0 } else { travel.signum() }
    }

    /// Whether the motion is known at a host time.
    pub(super) fn covers(&self, host_s: f64) -> bool {
        match &self.source {
            TiltSource::Tilting(motion, margin_s) => motion.covers(host_s, *margin_s),
            TiltSource::StepAndStare(_) => true,
        }
    }

    /// Largest distance of a poll from the fitted motion, counts.
    pub(super) fn residual_steps(&self) -> f64 {
        match &self.source {
            TiltSource::Tilting(motion, _) => motion.residual_steps,
            TiltSource::StepAndStare(_) => 0.0,
        }
    }
}

impl PanSegment {
    /// Duration of a revolution on the sensor's clock, seconds: the mean over all scans, since stamps are rounded to 1 ms.
    pub(super) fn scan_period_s(&self, nominal_s: f64) -> f64 {
        let (Some(first), Some(last)) = (self.scans.first(), self.scans.last()) else {
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
}
