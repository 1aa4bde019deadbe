//! The plan of one sweep in the devices' units, from request, settings and the devices' identities.

mod stream;

use self::stream::plan_stream;
use super::constants::{APPROACH_RAD_S, LIMIT_MARGIN_STEPS, MARGIN_LINES, MIN_RANGE_RAD};
use super::error::DeviceError;
use crate::config::{MountConfig, PtuConfig, SweepConfig, SweepMode};
use patrold_engine::geometry::Mount;
use patrold_engine::scan::ScanGeometry;
use patrold_engine::sweep::{PanSegment, RawSweep};
use ptu::{AxisIdentity, AxisScale, HeadIdentity, Sign};
use scip::{LaserIdentity, LaserParameters, StreamPlan};
use std::time::Duration;

/// A sweep in radians and metres.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepRequest {
    /// Continuous or step-and-stare.
    pub mode: SweepMode,
    /// First tilt, radians.
    pub tilt_from_rad: f64,
    /// Last tilt, radians; the head moves from the first to the last, always.
    pub tilt_to_rad: f64,
    /// Speed of a continuous sweep, radians per second.
    pub speed_rad_s: f64,
    /// Distance between lines of step-and-stare, radians.
    pub step_rad: f64,
    /// Added to the laser's timestamps, seconds; stored with the sweep.
    pub time_offset_s: f64,
    /// Pans in this order, radians.
    pub pans_rad: Vec<f64>,
    /// Chain from base to laser; stored with the sweep.
    pub mount: Mount,
}

impl SweepRequest {
    /// The configured sweep at these pans, radians; `Settings::pans_rad` has those of a waypoint.
    pub fn new(settings: &SweepConfig, mount: &MountConfig, pans_rad: &[f64]) -> Self {
        Self {
            mode: settings.mode,
            tilt_from_rad: settings.tilt_from_rad,
            tilt_to_rad: settings.tilt_to_rad,
            speed_rad_s: settings.speed_rad_s,
            step_rad: settings.step_rad,
            time_offset_s: settings.time_offset_s,
            pans_rad: pans_rad.to_vec(),
            mount: mount.chain(),
        }
    }
}

/// What the plan needs of the head.
#[derive(Debug, Clone)]
pub(crate) struct HeadFacts<'a> {
    pub identity: &'a HeadIdentity,
    /// Signs and zeros.
    pub settings: &'a PtuConfig,
    /// Its port, for errors.
    pub port: &'a str,
}

/// What the plan needs of the laser.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LaserFacts {
    pub parameters: LaserParameters,
    /// Bytes per second of a line with a line rate.
    pub line_bytes_s: Option<u32>,
}

impl LaserFacts {
    pub(super) fn new(identity: &LaserIdentity) -> Self {
        Self {
            parameters: identity.parameters,
            line_bytes_s: identity.line_bytes_s,
        }
    }
}

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
    pub(super) fn start_steps(&self) -> Option<i32> {
        match self {
            Self::Continuous { start_steps, .. } => Some(*start_steps),
            Self::Steps(targets) => targets.first().copied(),
        }
    }
}

/// A sweep in the devices' units.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SweepPlan {
    pub stream: StreamPlan,
    pub scan_geometry: ScanGeometry,
    /// Chain from base to laser.
    pub mount: Mount,
    /// Time between two transmitted scans.
    pub line_period: Duration,
    /// Pan of each segment: counts, and the angle of those counts in radians.
    pub pans: Vec<(i32, f64)>,
    /// The same in all segments.
    pub tilt: TiltPlan,
    /// For travel times.
    pub pan_axis: AxisIdentity,
    /// For travel times.
    pub tilt_axis: AxisIdentity,
    /// Speeds of moves between segments, counts per second: pan, tilt.
    pub approach_steps_s: (i32, i32),
    /// Radians per tilt count, signed.
    pub tilt_rad_per_step: f64,
    /// Tilt at count 0, radians.
    pub tilt_zero_rad: f64,
    /// Lowest and highest tilt of the sweep, radians.
    pub tilt_range_rad: (f64, f64),
    /// Distance between lines, radians.
    pub line_pitch_rad: f64,
    /// Added to the laser's timestamps, seconds.
    pub time_offset_s: f64,
    /// Tilt difference between moving up and moving down to the same count, radians.
    pub tilt_backlash_rad: f64,
    /// Deviations from the request, one line each.
    pub notes: Vec<String>,
}

impl SweepPlan {
    /// Fits the request to the devices: whole counts, speeds within bounds, the tilt range clipped to the head's limits.
    ///
    /// # Errors
    /// [`DeviceError::OutOfReach`] if a pan or the whole tilt range is out of reach.
    pub(super) fn new(
        request: &SweepRequest,
        head: &HeadFacts<'_>,
        laser: LaserFacts,
    ) -> Result<Self, DeviceError> {
        let mut notes = Vec::new();
        let max_periods = max_periods(request, &head.identity.tilt);
        let (stream, line_period) = plan_stream(laser, max_periods, &mut notes);
        let scan_period = laser.parameters.scan_period();
        let pan_scale = axis_scale(
            &head.identity.pan,
            head.settings.pan_sign,
            head.settings.pan_zero_rad,
        );
        let mut pans = Vec::with_capacity(request.pans_rad.len());
        for pan_rad in &request.pans_rad {
            pans.push(pan_steps(*pan_rad, &pan_scale, head)?);
        }
        let tilt = TiltAxis {
            axis: &head.identity.tilt,
            scale: axis_scale(
                &head.identity.tilt,
                head.settings.tilt_sign,
                head.settings.tilt_zero_rad,
            ),
            port: head.port,
        };
        let segment = match request.mode {
            SweepMode::Continuous => {
                tilt.continuous(request, scan_period, line_period, &mut notes)?
            }
            SweepMode::Step => tilt.steps(request, &mut notes)?,
        };
        let parameters = laser.parameters;
        Ok(Self {
            scan_geometry: ScanGeometry {
                steps_per_turn: parameters.ares,
                front_step: parameters.afrt,
                first_step: parameters.amin,
                cluster: u32::from(stream.cluster.max(1)),
                dmin_mm: parameters.dmin_mm,
                dmax_mm: parameters.dmax_mm,
                period_s: parameters.scan_period().as_secs_f64(),
            },
            stream,
            mount: request.mount.clone(),
            line_period,
            pans,
            tilt: segment.motion,
            pan_axis: head.identity.pan,
            tilt_axis: head.identity.tilt,
            approach_steps_s: (
                bounded_speed(&head.identity.pan, APPROACH_RAD_S),
                bounded_speed(&head.identity.tilt, APPROACH_RAD_S),
            ),
            tilt_rad_per_step: tilt.scale.sign.factor() * tilt.scale.step.radians(),
            tilt_zero_rad: head.settings.tilt_zero_rad,
            tilt_range_rad: segment.range_rad,
            line_pitch_rad: segment.pitch_rad,
            time_offset_s: request.time_offset_s,
            tilt_backlash_rad: head.settings.tilt_backlash_rad,
            notes,
        })
    }
}

impl SweepPlan {
    /// The raw sweep with these segments.
    pub(super) fn raw_sweep(&self, pan_segments: Vec<PanSegment>) -> RawSweep {
        RawSweep {
            scan_geometry: self.scan_geometry.clone(),
            mount: self.mount.clone(),
            tilt_rad_per_step: self.tilt_rad_per_step,
            tilt_zero_rad: self.tilt_zero_rad,
            tilt_low_rad: self.tilt_range_rad.0,
            tilt_high_rad: self.tilt_range_rad.1,
            line_pitch_rad: self.line_pitch_rad,
            time_offset_s: self.time_offset_s,
            tilt_backlash_rad: self.tilt_backlash_rad,
            pan_segments,
        }
    }
}

struct PlannedTilt {
    motion: TiltPlan,
    range_rad: (f64, f64),
    pitch_rad: f64,
}

struct TiltAxis<'a> {
    axis: &'a AxisIdentity,
    scale: AxisScale,
    port: &'a str,
}

impl TiltAxis<'_> {
    fn continuous(
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

    fn steps(
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
                key: "sweep.tilt_from_deg and sweep.tilt_to_deg",
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

fn axis_scale(axis: &AxisIdentity, sign: f64, zero_rad: f64) -> AxisScale {
    AxisScale {
        step: axis.step,
        sign: if sign < 0.0 {
            Sign::Negative
        } else {
            Sign::Positive
        },
        offset_rad: -zero_rad,
    }
}

/// How many scan periods a line may take: as many as the tilt can be slower than requested. Step-and-stare waits.
fn max_periods(request: &SweepRequest, tilt: &AxisIdentity) -> u32 {
    match request.mode {
        SweepMode::Continuous => {
            let slowest_rad_s = f64::from(tilt.speed_min.max(1)) * tilt.step.radians();
            (request.speed_rad_s / slowest_rad_s).floor().max(1.0) as u32
        }
        SweepMode::Step => u32::MAX,
    }
}

fn bounded_speed(axis: &AxisIdentity, rad_s: f64) -> i32 {
    let wanted = (rad_s.abs() / axis.step.radians()).round();
    (wanted as i32)
        .max(axis.speed_min)
        .min(axis.speed_max)
        .max(1)
}

fn pan_steps(
    pan_rad: f64,
    scale: &AxisScale,
    head: &HeadFacts<'_>,
) -> Result<(i32, f64), DeviceError> {
    let limits = head.identity.pan.limits;
    let low = limits.min_steps + LIMIT_MARGIN_STEPS;
    let high = limits.max_steps - LIMIT_MARGIN_STEPS;
    match scale.steps(pan_rad) {
        Some(steps) if (low..=high).contains(&steps) => Ok((steps, scale.radians(steps))),
        _ => {
            let (a, b) = (scale.radians(low), scale.radians(high));
            Err(DeviceError::OutOfReach {
                port: head.port.to_owned(),
                axis: "pan",
                low_deg: a.min(b).to_degrees(),
                high_deg: a.max(b).to_degrees(),
                wanted: format!("{:.1} deg", pan_rad.to_degrees()),
                key: "sweep.pans_deg",
            })
        }
    }
}
