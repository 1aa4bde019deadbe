//! The plan of one sweep in the devices' units, from request, settings and the devices' identities.

mod request;
mod stream;
#[cfg(test)]
mod tests;
mod tilt;

pub use self::request::{AngleSettings, SweepRequest};
pub(crate) use self::tilt::TiltPlan;

use self::stream::plan_stream;
use self::tilt::{TiltAxis, bounded_speed};
use super::constants::{APPROACH_RAD_S, LIMIT_MARGIN_STEPS};
use super::error::DeviceError;
use crate::config::{PtuConfig, SweepMode};
use patrold_engine::geometry::Mount;
use patrold_engine::scan::ScanGeometry;
use patrold_engine::sweep::{PanSegment, RawSweep};
use ptu::{AxisIdentity, AxisScale, HeadIdentity, Sign};
use scip::{LaserIdentity, LaserParameters, StreamPlan};
use std::time::Duration;

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
            let setting = &request.angle_settings.pans;
            pans.push(pan_steps(*pan_rad, &pan_scale, head, setting)?);
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

fn pan_steps(
    pan_rad: f64,
    scale: &AxisScale,
    head: &HeadFacts<'_>,
    setting: &str,
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
                setting: setting.to_owned(),
            })
        }
    }
}
