//! The motion of the tilt axis: range, speed, lines.

use super::request::SweepRequest;
use crate::devices::constants::{LIMIT_MARGIN_STEPS, MARGIN_LINES, MIN_RANGE_RAD};
use crate::devices::error::DeviceError;
use ptu::{AxisIdentity, AxisScale};
use std::time::Duration;

/// Motion of the tilt axis.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum TiltPlan {
    /// At constant speed.
    Continuous {
        /// Start, counts.
        start_steps: i32,
        /// End, counts.
        end_steps: i32,
        /// Counts per second, positive.
        speed_steps_s: i32,
        /// Counts of the speed ramp at each end; positions there are not at constant speed.
        ramp_steps: i32,
    },
    /// Stops at each of these counts.
    Steps(Vec<i32>),
}

impl TiltPlan {
    /// Tilt before the first scan, counts.
    pub(in crate::devices) fn start_steps(&self) -> Option<i32> {
        match self {
            Self::Continuous { start_steps, .. } => Some(*start_steps),
            Self::Steps(targets) => targets.first().copied(),
        }
    }
}

pub(super) struct PlannedTilt {
    pub motion: TiltPlan,
    pub range_rad: (f64, f64),
    pub pitch_rad: f64,
}

pub(super) struct TiltAxis<'a> {
    pub axis: &'a AxisIdentity,
    pub scale: AxisScale,
    pub port: &'a str,
}

impl TiltAxis<'_> {
    pub(super) fn continuous(
        &self,
        request: &SweepRequest,
        scan_period: Duration,
        line_period: Duration,
        notes: &mut Vec<String>,
    ) -> Result<PlannedTilt, DeviceError> {
        // Lines as far apart as with all scans of the laser.
        let slowdown = line_period.as_secs_f64() / scan_period.as_secs_f64();
        let wanted_rad_s = request.speed_rad_s / slowdown;
        let speed = bounded_speed(self.axis, wanted_rad_s);
        let step_rad = self.scale.step.radians();
        let got_rad_s = f64::from(speed) * step_rad;
        let pitch_rad = got_rad_s * line_period.as_secs_f64();
        if slowdown > 1.0 {
            notes.push(format!(
                "tilt speed {:.2} deg/s instead of {:.2}, lines {:.2} deg apart: the laser's line carries {:.1} scans/s",
                got_rad_s.to_degrees(),
                request.speed_rad_s.to_degrees(),
                pitch_rad.to_degrees(),
                1.0 / line_period.as_secs_f64()
            ));
        }
        if (got_rad_s - wanted_rad_s).abs() > step_rad {
            notes.push(format!(
                "tilt speed {:.2} deg/s instead of {:.2}: the head supports {} to {} counts/s",
                got_rad_s.to_degrees(),
                wanted_rad_s.to_degrees(),
                self.axis.speed_min,
                self.axis.speed_max
            ));
        }
        let ramp_steps = self.axis.profile(speed).ramp_steps().ceil() as i32;
        let lines = MARGIN_LINES * f64::from(speed) * line_period.as_secs_f64();
        let margin = lines.ceil() as i32 + ramp_steps + 1;
        let (from, to) = self.clipped_range(request, margin, notes)?;
        let direction = (to - from).signum();
        Ok(PlannedTilt {
            motion: TiltPlan::Continuous {
                start_steps: from - direction * margin,
                end_steps: to + direction * margin,
                speed_steps_s: speed,
                ramp_steps,
            },
            range_rad: self.widened_range_rad(from, to, 0.0),
            pitch_rad,
        })
    }

    pub(super) fn steps(
        &self,
        request: &SweepRequest,
        notes: &mut Vec<String>,
    ) -> Result<PlannedTilt, DeviceError> {
        let (from, to) = self.clipped_range(request, 0, notes)?;
        let pitch = (request.step_rad / self.scale.step.radians()).max(1.0);
        let direction = f64::from((to - from).signum());
        let span = f64::from((to - from).abs());
        let targets = (0..=(span / pitch).floor() as i32)
            .map(|i| from + (direction * f64::from(i) * pitch).round() as i32)
            .collect();
        Ok(PlannedTilt {
            motion: TiltPlan::Steps(targets),
            // Half a count wider: lines at the ends belong to the sweep.
            range_rad: self.widened_range_rad(from, to, 0.5),
            pitch_rad: pitch * self.scale.step.radians(),
        })
    }

    /// First and last count of the requested range, clipped to the limits less `margin`.
    fn clipped_range(
        &self,
        request: &SweepRequest,
        margin: i32,
        notes: &mut Vec<String>,
    ) -> Result<(i32, i32), DeviceError> {
        let limits = self.axis.limits;
        let low = limits.min_steps + LIMIT_MARGIN_STEPS + margin;
        let high = limits.max_steps - LIMIT_MARGIN_STEPS - margin;
        let unreachable = || {
            let (a, b) = (self.scale.radians(low), self.scale.radians(high));
            DeviceError::OutOfReach {
                port: self.port.to_owned(),
                axis: "tilt",
                low_deg: a.min(b).to_degrees(),
                high_deg: a.max(b).to_degrees(),
                wanted: format!(
                    "{:.1} to {:.1} deg",
                    request.tilt_from_rad.to_degrees(),
                    request.tilt_to_rad.to_degrees()
                ),
                setting: request.angle_settings.tilt.clone(),
            }
        };
        let wanted = (
            self.scale.steps(request.tilt_from_rad),
            self.scale.steps(request.tilt_to_rad),
        );
        let (Some(from), Some(to)) = wanted else {
            return Err(unreachable());
        };
        if low >= high {
            return Err(unreachable());
        }
        let (first, last) = (from.clamp(low, high), to.clamp(low, high));
        if f64::from((last - first).abs()) * self.scale.step.radians() < MIN_RANGE_RAD {
            return Err(unreachable());
        }
        if (first, last) != (from, to) {
            notes.push(format!(
                "tilt {:.1} to {:.1} deg instead of {:.1} to {:.1}: limited by the head's range less the margin for starting and stopping",
                self.scale.radians(first).to_degrees(),
                self.scale.radians(last).to_degrees(),
                request.tilt_from_rad.to_degrees(),
                request.tilt_to_rad.to_degrees()
            ));
        }
        Ok((first, last))
    }

    fn widened_range_rad(&self, from: i32, to: i32, beyond_steps: f64) -> (f64, f64) {
        let (a, b) = (self.scale.radians(from), self.scale.radians(to));
        let beyond = beyond_steps * self.scale.step.radians();
        (a.min(b) - beyond, a.max(b) + beyond)
    }
}

pub(super) fn bounded_speed(axis: &AxisIdentity, rad_s: f64) -> i32 {
    let wanted = (rad_s.abs() / axis.step.radians()).round();
    (wanted as i32)
        .max(axis.speed_min)
        .min(axis.speed_max)
        .max(1)
}
