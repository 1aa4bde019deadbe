//! From raw data to a view: every beam is projected with the pose at its own time (sweep-geometry sections 1-3).
//!
//! A view has one origin, though the laser moves: all rays are taken to start at the mean of its positions. The points are
//! exact all the same; the free space before them is known to within the distance of the laser from that mean, which is
//! bounded. A laser mounted far ahead of the pan axis allows fewer pans.

use super::blind::is_blind;
use super::clock::SensorClock;
use super::constants::{
    FREE_RANGE_M, FROZEN_SCANS, GAP_PERIODS, MAX_LINES, MAX_ORIGIN_DISTANCE_M, URG_NOISE,
};
use super::error::SweepError;
use super::lines::{self, LineGap, PanSegmentLines};
use super::origin;
use super::pan_segment_tilt::PanSegmentTilt;
use super::quality::SweepQuality;
use super::raw::{HeadMotion, PanSegment, RawSweep, StampedScan};
use crate::geometry::{Mount, Pose, View};
use crate::scan::Beam;
use nalgebra::{Point3, Unit, Vector3};
use std::ops::Range;

/// An assembled sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    /// In the base frame.
    pub view: View,
    /// How good the raw data are.
    pub quality: SweepQuality,
    /// The parts of the view, one per pan, in order.
    pub pan_segments: Vec<PanSegmentPart>,
}

/// The part of a view that was taken at one pan.
#[derive(Debug, Clone, PartialEq)]
pub struct PanSegmentPart {
    /// The axis about which the laser was tilted, in the frame of the points. A negative rotation about it tilts up.
    pub tilt_axis: Unit<Vector3<f64>>,
    /// Indices of its points in the view.
    pub points: Range<usize>,
}

/// Projects every beam into the base frame, with the mount that the sweep was taken with.
///
/// # Errors
/// No scans, invalid values, a clock or a motion of the head that cannot be fitted, positions of the laser too far apart.
pub fn assemble(raw: &RawSweep) -> Result<Sweep, SweepError> {
    assemble_with_mount(raw, &raw.mount)
}

/// [`assemble`] with another mount than the sweep was taken with, after a new calibration.
fn assemble_with_mount(raw: &RawSweep, mount: &Mount) -> Result<Sweep, SweepError> {
    check(raw, mount)?;
    let (origin, distance_m) = origin::common_origin(raw, mount);
    if distance_m > MAX_ORIGIN_DISTANCE_M {
        return Err(SweepError::OriginSpread { distance_m });
    }
    let mut builder = SweepBuilder::default();
    for segment in &raw.pan_segments {
        builder.add(raw, segment, mount)?;
    }
    if builder.lines.iter().all(|lines| lines.got == 0) {
        return Err(SweepError::Empty);
    }
    Ok(builder.finish(raw, mount, origin))
}

/// Refuses values with which nothing can be computed: stored sweeps come from outside.
fn check(raw: &RawSweep, mount: &Mount) -> Result<(), SweepError> {
    let invalid = |what, got, expected| {
        Err(SweepError::InvalidValue {
            what,
            got,
            expected,
        })
    };
    let positive = |x: f64| x.is_finite() && x > 0.0;
    if !positive(raw.line_pitch_rad) {
        return invalid("line pitch", raw.line_pitch_rad, "a positive angle");
    }
    let span_rad = raw.tilt_high_rad - raw.tilt_low_rad;
    if !(span_rad.is_finite() && span_rad >= 0.0) {
        return invalid("tilt range", span_rad, "an angle of at least 0");
    }
    if span_rad / raw.line_pitch_rad > MAX_LINES {
        return invalid(
            "line pitch",
            raw.line_pitch_rad,
            "a pitch of fewer than a million lines",
        );
    }
    if !positive(raw.tilt_rad_per_step.abs()) {
        return invalid("tilt per count", raw.tilt_rad_per_step, "an angle, not 0");
    }
    if !positive(raw.scan_geometry.period_s) {
        return invalid("scan period", raw.scan_geometry.period_s, "a positive time");
    }
    if raw.scan_geometry.steps_per_turn == 0 {
        return invalid("steps per turn", 0.0, "at least 1");
    }
    let pans = raw.pan_segments.iter().map(|segment| segment.pan_rad);
    let mut values = mount
        .parameters()
        .into_iter()
        .chain([raw.tilt_zero_rad, raw.time_offset_s, raw.tilt_backlash_rad])
        .chain(pans);
    if let Some(got) = values.find(|x| !x.is_finite()) {
        return invalid(
            "mount, pan, time offset or backlash value",
            got,
            "a finite number",
        );
    }
    Ok(())
}

/// Lines that each pan segment should have.
fn lines_per_segment(raw: &RawSweep) -> usize {
    let span_rad = raw.tilt_high_rad - raw.tilt_low_rad;
    (span_rad / raw.line_pitch_rad).floor() as usize + 1
}

/// Collects the points and the quality of all pan segments.
#[derive(Default)]
struct SweepBuilder {
    points: Vec<Point3<f64>>,
    no_return: Vec<Unit<Vector3<f64>>>,
    beams: usize,
    lines: Vec<PanSegmentLines>,
    widest_gap: LineGap,
    gaps: usize,
    residual_steps: f64,
    clock_uncertainty_s: f64,
    clock_uncertainty_rad: f64,
    clock_rate: f64,
    frozen: bool,
    blind_lines: usize,
    segments: Vec<PanSegmentPart>,
}

impl SweepBuilder {
    fn add(
        &mut self,
        raw: &RawSweep,
        segment: &PanSegment,
        mount: &Mount,
    ) -> Result<(), SweepError> {
        let pan_deg = segment.pan_rad.to_degrees();
        let clock = SensorClock::fit(&segment.time_samples, &segment.scans)
            .map_err(|source| SweepError::Clock { pan_deg, source })?;
        let tilt = PanSegmentTilt::fit(raw, segment)
            .map_err(|source| SweepError::Motion { pan_deg, source })?;
        let mut tilts_rad = Vec::with_capacity(segment.scans.len());
        let first_point = self.points.len();
        let period_s = segment.scan_period_s(raw.scan_geometry.period_s) * clock.rate;
        for (index, scan) in segment.scans.iter().enumerate() {
            let start_s = clock.host_s(scan.stamp_ms);
            let tilt_rad = |share: f64| tilt.tilt_rad(index, start_s + share * period_s);
            let middle_rad = tilt_rad(0.5);
            let motion_known = tilt.covers(start_s) && tilt.covers(start_s + period_s);
            if !(raw.tilt_low_rad..=raw.tilt_high_rad).contains(&middle_rad) || !motion_known {
                continue;
            }
            tilts_rad.push(middle_rad);
            self.blind_lines += usize::from(is_blind(&scan.values, &raw.scan_geometry));
            self.project(raw, scan, |share| {
                mount.base_from_laser(segment.pan_rad, tilt_rad(share))
            });
        }
        self.segments.push(PanSegmentPart {
            tilt_axis: mount.tilt_axis(segment.pan_rad),
            points: first_point..self.points.len(),
        });
        let (got, widest) = lines::count_lines(
            &mut tilts_rad,
            raw.tilt_low_rad,
            raw.tilt_high_rad,
            raw.line_pitch_rad,
        );
        let expected = lines_per_segment(raw);
        self.lines.push(PanSegmentLines {
            pan_rad: segment.pan_rad,
            expected,
            got: got.min(expected),
        });
        self.widest_gap.lines = self.widest_gap.lines.max(widest.lines);
        self.widest_gap.angle_rad = self.widest_gap.angle_rad.max(widest.angle_rad);
        self.clock_uncertainty_rad = self
            .clock_uncertainty_rad
            .max(clock.uncertainty_s * tilt.speed_rad_s().abs());
        self.gaps += count_gaps(&segment.scans, raw.scan_geometry.period_s, &segment.motion);
        self.frozen |= is_frozen(&segment.scans, raw.scan_geometry.dmin_mm);
        self.residual_steps = self.residual_steps.max(tilt.residual_steps());
        self.clock_uncertainty_s = self.clock_uncertainty_s.max(clock.uncertainty_s);
        self.clock_rate = clock.rate;
        Ok(())
    }

    fn project(
        &mut self,
        raw: &RawSweep,
        scan: &StampedScan,
        base_from_laser: impl Fn(f64) -> Pose,
    ) {
        let scan_geometry = &raw.scan_geometry;
        self.beams += scan.values.len();
        for (index, value) in scan.values.iter().enumerate() {
            let beam = Beam::from_raw(*value, scan_geometry.dmin_mm, scan_geometry.dmax_mm);
            if beam == Beam::Unknown {
                continue;
            }
            let (sin, cos) = scan_geometry.azimuth_rad(index).sin_cos();
            let direction = Vector3::new(cos, sin, 0.0);
            let pose = base_from_laser(scan_geometry.turn_share(index));
            match beam {
                Beam::Hit(range_m) => self.points.push(pose * Point3::from(direction * range_m)),
                _ => self
                    .no_return
                    .push(Unit::new_unchecked(pose.rotation * direction)),
            }
        }
    }

    fn finish(self, raw: &RawSweep, mount: &Mount, origin: Point3<f64>) -> Sweep {
        let beams = self.beams.max(1) as f64;
        let quality = SweepQuality {
            lines_expected: self.lines.iter().map(|lines| lines.expected).sum(),
            lines_got: self.lines.iter().map(|lines| lines.got).sum(),
            gaps: self.gaps,
            widest_gap_lines: self.widest_gap.lines,
            widest_gap_rad: self.widest_gap.angle_rad,
            line_pitch_rad: raw.line_pitch_rad,
            pan_segments: self.lines,
            hit_share: self.points.len() as f64 / beams,
            no_return_share: self.no_return.len() as f64 / beams,
            position_residual_steps: self.residual_steps,
            position_residual_rad: self.residual_steps * raw.tilt_rad_per_step.abs(),
            clock_uncertainty_s: self.clock_uncertainty_s,
            clock_uncertainty_rad: self.clock_uncertainty_rad,
            clock_rate: self.clock_rate,
            frozen: self.frozen,
            blind_lines: self.blind_lines,
        };
        let tilt_axis = match &raw.pan_segments[..] {
            [segment] => Some(mount.tilt_axis(segment.pan_rad)),
            _ => None,
        };
        let view = View {
            origin,
            points: self.points,
            no_return: self.no_return,
            free_range_m: FREE_RANGE_M,
            noise: Some(URG_NOISE),
            tilt_axis,
        };
        Sweep {
            view,
            quality,
            pan_segments: self.segments,
        }
    }
}

/// Number of gaps between scans; step-and-stare leaves scans out on purpose.
fn count_gaps(scans: &[StampedScan], period_s: f64, motion: &HeadMotion) -> usize {
    if matches!(motion, HeadMotion::StepAndStare { .. }) {
        return 0;
    }
    let far = |pair: &&[StampedScan]| {
        let apart_ms = pair[1].stamp_ms.saturating_sub(pair[0].stamp_ms);
        apart_ms as f64 * 1e-3 > GAP_PERIODS * period_s
    };
    scans.windows(2).filter(far).count()
}

/// Whether scans repeat each other. Scans without any range do so where the laser is blind, which is another fault.
fn is_frozen(scans: &[StampedScan], dmin_mm: u32) -> bool {
    scans.windows(FROZEN_SCANS).any(|run| {
        let first = &run[0].values;
        let has_ranges = first.iter().any(|v| *v >= dmin_mm);
        has_ranges && run.iter().all(|scan| scan.values == *first)
    })
}

#[cfg(test)]
mod tests;
