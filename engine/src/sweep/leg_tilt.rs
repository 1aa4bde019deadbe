//! The tilt of one leg at any beam: the fitted motion, the calibrated time offset and the backlash.

use super::attitude::{Attitude, AttitudeError, Wanted};
use super::raw::{Leg, Motion, RawSweep};

/// How a leg tilted.
pub struct LegTilt<'a> {
    moved: Moved<'a>,
    zero_rad: f64,
    rad_per_step: f64,
    time_offset_s: f64,
    lag_rad: f64,
}

enum Moved<'a> {
    /// The motion, and the seconds before and after its polls for which it holds.
    Tilting(Attitude, f64),
    Standing(&'a [i32]),
}

impl<'a> LegTilt<'a> {
    /// With the time offset and the backlash that the sweep was taken with.
    ///
    /// # Errors
    /// A head that did not follow its command to both ends.
    pub fn fit(raw: &RawSweep, leg: &'a Leg) -> Result<Self, AttitudeError> {
        let moved = match &leg.motion {
            Motion::Tilting { speed_steps_s } => {
                let wanted = Wanted {
                    zero_rad: raw.tilt_zero_rad,
                    rad_per_step: raw.tilt_rad_per_step,
                    low_rad: raw.tilt_low_rad,
                    high_rad: raw.tilt_high_rad,
                    pitch_rad: raw.line_pitch_rad,
                };
                let attitude = Attitude::fit(&leg.polls, *speed_steps_s)?;
                wanted.check(&leg.polls)?;
                Moved::Tilting(attitude, wanted.allowed_s(&attitude))
            }
            Motion::Standing { tilt_steps } => Moved::Standing(tilt_steps),
        };
        let mut tilt = Self {
            moved,
            zero_rad: raw.tilt_zero_rad,
            rad_per_step: raw.tilt_rad_per_step,
            time_offset_s: raw.time_offset_s,
            lag_rad: 0.0,
        };
        tilt.lag_rad = tilt.way(leg) * raw.tilt_backlash_rad / 2.0;
        Ok(tilt)
    }

    /// Tilt in radians in scan `scan` at a host time that the laser's clock tells.
    pub fn tilt_rad(&self, scan: usize, host_s: f64) -> f64 {
        let steps = match &self.moved {
            Moved::Tilting(attitude, _) => attitude.tilt_steps(host_s + self.time_offset_s),
            Moved::Standing(steps) => steps.get(scan).map_or(f64::NAN, |s| f64::from(*s)),
        };
        self.zero_rad + self.rad_per_step * steps - self.lag_rad
    }

    /// Signed speed of the tilt, radians per second.
    pub fn speed_rad_s(&self) -> f64 {
        match &self.moved {
            Moved::Tilting(attitude, _) => attitude.speed_steps_s() * self.rad_per_step,
            Moved::Standing(_) => 0.0,
        }
    }

    /// Direction of travel: 1 up, -1 down, 0 where there was none.
    pub fn way(&self, leg: &Leg) -> f64 {
        let way = match &leg.motion {
            Motion::Tilting { .. } => self.speed_rad_s(),
            Motion::Standing { tilt_steps } => match (tilt_steps.first(), tilt_steps.last()) {
                (Some(first), Some(last)) => {
                    (f64::from(*last) - f64::from(*first)) * self.rad_per_step
                }
                _ => 0.0,
            },
        };
        if way == 0.0 { 0.0 } else { way.signum() }
    }

    /// Whether the head was seen moving, or standing, at a host time.
    pub fn covers(&self, host_s: f64) -> bool {
        match &self.moved {
            Moved::Tilting(attitude, margin_s) => attitude.covers(host_s, *margin_s),
            Moved::Standing(_) => true,
        }
    }

    /// Largest distance of a poll from the motion, counts.
    pub fn residual_steps(&self) -> f64 {
        match &self.moved {
            Moved::Tilting(attitude, _) => attitude.residual_steps,
            Moved::Standing(_) => 0.0,
        }
    }
}

impl Leg {
    /// Time of one turn on the sensor's clock, seconds: the mean over the longest run, for single stamps are rounded to
    /// 1 ms.
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
