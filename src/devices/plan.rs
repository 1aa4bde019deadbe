//! From settings and what the devices said of themselves to whole counts: the plan of one sweep.

mod stream;

use self::stream::stream_plan;
use super::constants::{APPROACH_RAD_S, LEAST_RANGE_RAD, LIMIT_MARGIN_STEPS, MARGIN_LINES};
use super::error::DeviceError;
use crate::config::{MountSettings, PtuSettings, SweepMode, SweepSettings};
use patrold_engine::geometry::Mount;
use patrold_engine::scan::Optics;
use ptu::{AxisIdentity, AxisScale, HeadIdentity, Sign};
use scip::{Parameters, StreamPlan};
use std::time::Duration;

/// What a sweep shall look at.
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
    /// Pitch of the lines of step-and-stare, radians.
    pub step_rad: f64,
    /// Added to the laser's instants, seconds; stored with the sweep.
    pub time_offset_s: f64,
    /// Pans, radians, in this order.
    pub pans_rad: Vec<f64>,
    /// Where the laser sits; stored with the sweep.
    pub mount: Mount,
}

impl SweepRequest {
    /// The configured sweep at these pans (`Settings::pans_rad` knows a waypoint's).
    pub fn new(settings: &SweepSettings, mount: &MountSettings, pans_rad: &[f64]) -> Self {
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

/// The head as the plan sees it.
#[derive(Debug, Clone)]
pub struct HeadFacts<'a> {
    /// What it said at connecting.
    pub identity: &'a HeadIdentity,
    /// Signs and zeros.
    pub settings: &'a PtuSettings,
    /// Its port, for messages.
    pub port: &'a str,
}

/// The laser as the plan sees it.
#[derive(Debug, Clone, Copy)]
pub struct LaserFacts {
    /// What it said at connecting.
    pub parameters: Parameters,
    /// Bytes a second, where the line is slower than the scans.
    pub line_bytes_s: Option<u32>,
}

/// How the tilt goes.
#[derive(Debug, Clone, PartialEq)]
pub enum TiltPlan {
    /// From start to end at one speed.
    Continuous {
        /// Where it starts, counts.
        start_steps: i32,
        /// Where it ends, counts.
        end_steps: i32,
        /// Counts per second, positive.
        speed_steps_s: i32,
        /// Counts at either end that the speed ramps take; positions there say nothing about the constant speed.
        ramp_steps: i32,
    },
    /// Standing at each of these counts.
    Steps(Vec<i32>),
}

impl TiltPlan {
    /// Where the head must be before the first scan, counts.
    pub fn start_steps(&self) -> Option<i32> {
        match self {
            Self::Continuous { start_steps, .. } => Some(*start_steps),
            Self::Steps(targets) => targets.first().copied(),
        }
    }
}

/// A sweep in the devices' own units.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepPlan {
    /// The scans to ask for.
    pub stream: StreamPlan,
    /// The beams of a scan.
    pub optics: Optics,
    /// Where the laser sits.
    pub mount: Mount,
    /// Time between two scans that are sent.
    pub line_period: Duration,
    /// Pans of the legs: counts, and the angle those counts are, radians.
    pub pans: Vec<(i32, f64)>,
    /// The tilt, the same in every leg.
    pub tilt: TiltPlan,
    /// Pan axis, for times.
    pub pan_axis: AxisIdentity,
    /// Tilt axis, for times.
    pub tilt_axis: AxisIdentity,
    /// Speeds of the moves between, counts per second: pan, tilt.
    pub approach_steps_s: (i32, i32),
    /// Signed radians per tilt count.
    pub tilt_rad_per_step: f64,
    /// Tilt at count 0, radians.
    pub tilt_zero_rad: f64,
    /// Lowest and highest tilt that belong to the sweep, radians.
    pub tilt_range_rad: (f64, f64),
    /// Pitch of the lines, radians.
    pub line_pitch_rad: f64,
    /// Added to the laser's instants, seconds.
    pub time_offset_s: f64,
    /// Difference of the tilt between a travel up and one down, radians.
    pub tilt_backlash_rad: f64,
    /// What had to be changed for the devices' sake, one sentence each.
    pub notes: Vec<String>,
}

impl SweepPlan {
    /// Fits the request to the devices: whole counts, speeds within bounds, the tilt range clipped to the head's.
    ///
    /// # Errors
    /// [`DeviceError::OutOfReach`] if the head reaches nothing worth sweeping, or not a pan.
    pub fn new(
        request: &SweepRequest,
        head: &HeadFacts<'_>,
        laser: LaserFacts,
    ) -> Result<Self, DeviceError> {
        let mut notes = Vec::new();
        let (stream, line_period) = stream_plan(laser, &mut notes);
        let pan_scale = scale(
            &head.identity.pan,
            head.settings.pan_sign,
            head.settings.pan_zero_rad,
        );
        let mut pans = Vec::with_capacity(request.pans_rad.len());
        for pan_rad in &request.pans_rad {
            pans.push(pan_steps(*pan_rad, &pan_scale, head)?);
        }
        let tilt = Tilt {
            axis: &head.identity.tilt,
            scale: scale(
                &head.identity.tilt,
                head.settings.tilt_sign,
                head.settings.tilt_zero_rad,
            ),
            port: head.port,
        };
        let swing = match request.mode {
            SweepMode::Continuous => tilt.continuous(request, line_period, &mut notes)?,
            SweepMode::Step => tilt.steps(request, &mut notes)?,
        };
        let parameters = laser.parameters;
        Ok(Self {
            optics: Optics {
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
            tilt: swing.plan,
            pan_axis: head.identity.pan,
            tilt_axis: head.identity.tilt,
            approach_steps_s: (
                bounded_speed(&head.identity.pan, APPROACH_RAD_S),
                bounded_speed(&head.identity.tilt, APPROACH_RAD_S),
            ),
            tilt_rad_per_step: tilt.scale.sign.factor() * tilt.scale.step.radians(),
            tilt_zero_rad: head.settings.tilt_zero_rad,
            tilt_range_rad: swing.range_rad,
            line_pitch_rad: swing.pitch_rad,
            time_offset_s: request.time_offset_s,
            tilt_backlash_rad: head.settings.tilt_backlash_rad,
            notes,
        })
    }
}

/// The tilt part of a plan.
struct Swing {
    plan: TiltPlan,
    range_rad: (f64, f64),
    pitch_rad: f64,
}

struct Tilt<'a> {
    axis: &'a AxisIdentity,
    scale: AxisScale,
    port: &'a str,
}

impl Tilt<'_> {
    fn continuous(
        &self,
        request: &SweepRequest,
        line_period: Duration,
        notes: &mut Vec<String>,
    ) -> Result<Swing, DeviceError> {
        let speed = bounded_speed(self.axis, request.speed_rad_s);
        let step_rad = self.scale.step.radians();
        let got_rad_s = f64::from(speed) * step_rad;
        if (got_rad_s - request.speed_rad_s).abs() > step_rad {
            notes.push(format!(
                "tilt speed {:.2} deg/s instead of {:.2}: the head does {} to {} counts/s",
                got_rad_s.to_degrees(),
                request.speed_rad_s.to_degrees(),
                self.axis.speed_min,
                self.axis.speed_max
            ));
        }
        let ramp_steps = self.axis.profile(speed).ramp_steps().ceil() as i32;
        let lines = MARGIN_LINES * f64::from(speed) * line_period.as_secs_f64();
        let margin = lines.ceil() as i32 + ramp_steps + 1;
        let (from, to) = self.clipped(request, margin, notes)?;
        let way = (to - from).signum();
        Ok(Swing {
            plan: TiltPlan::Continuous {
                start_steps: from - way * margin,
                end_steps: to + way * margin,
                speed_steps_s: speed,
                ramp_steps,
            },
            range_rad: self.range(from, to, 0.0),
            pitch_rad: got_rad_s * line_period.as_secs_f64(),
        })
    }

    fn steps(&self, request: &SweepRequest, notes: &mut Vec<String>) -> Result<Swing, DeviceError> {
        let (from, to) = self.clipped(request, 0, notes)?;
        let pitch = (request.step_rad / self.scale.step.radians()).max(1.0);
        let way = f64::from((to - from).signum());
        let span = f64::from((to - from).abs());
        let targets = (0..=(span / pitch).floor() as i32)
            .map(|i| from + (way * f64::from(i) * pitch).round() as i32)
            .collect();
        Ok(Swing {
            plan: TiltPlan::Steps(targets),
            // Half a count: a line at the very end belongs to the sweep.
            range_rad: self.range(from, to, 0.5),
            pitch_rad: pitch * self.scale.step.radians(),
        })
    }

    /// First and last count of the wanted range, within the limits less `margin`.
    fn clipped(
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
        if f64::from((last - first).abs()) * self.scale.step.radians() < LEAST_RANGE_RAD {
            return Err(unreachable());
        }
        if (first, last) != (from, to) {
            notes.push(format!(
                "tilt {:.1} to {:.1} deg instead of {:.1} to {:.1}: the head's limits less the margin for starting and stopping",
                self.scale.radians(first).to_degrees(),
                self.scale.radians(last).to_degrees(),
                request.tilt_from_rad.to_degrees(),
                request.tilt_to_rad.to_degrees()
            ));
        }
        Ok((first, last))
    }

    fn range(&self, from: i32, to: i32, beyond_steps: f64) -> (f64, f64) {
        let (a, b) = (self.scale.radians(from), self.scale.radians(to));
        let beyond = beyond_steps * self.scale.step.radians();
        (a.min(b) - beyond, a.max(b) + beyond)
    }
}

fn scale(axis: &AxisIdentity, sign: f64, zero_rad: f64) -> AxisScale {
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
