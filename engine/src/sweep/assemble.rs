//! From raw data to one view: every beam projected with its own instant (sweep-geometry sections 1-3).
//!
//! A view has one origin, though the laser moves: all rays are taken to start at the mean of its places. Points are
//! exact all the same; what lies before them is known to within the distance of the laser from that mean, which is
//! bounded. A laser mounted far ahead of the pan axis must do with fewer pans.

use super::attitude::AttitudeError;
use super::blind::is_blind;
use super::clock::{ClockError, SensorClock};
use super::constants::{
    FREE_RANGE_M, FROZEN_SCANS, GAP_PERIODS, MOST_LINES, MOST_OFF_ORIGIN_M, URG_NOISE,
};
use super::leg_tilt::LegTilt;
use super::lines::{self, Gap, LegLines};
use super::origin;
use super::quality::Quality;
use super::raw::{Leg, Motion, RawScan, RawSweep};
use crate::geometry::{Mount, View};
use crate::scan::Beam;
use nalgebra::{Point3, Unit, Vector3};
use std::ops::Range;

/// One look around: what was seen, and how well.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    /// Points in the base's frame.
    pub view: View,
    /// Quality figures.
    pub quality: Quality,
    /// Which points came from which pan, in order.
    pub parts: Vec<LegPart>,
}

/// The part of a view that was taken at one pan.
#[derive(Debug, Clone, PartialEq)]
pub struct LegPart {
    /// The axis about which the laser was tilted, in the frame of the points; a turn about it the other way is a tilt up.
    pub tilt_axis: Unit<Vector3<f64>>,
    /// Its points in the view.
    pub points: Range<usize>,
}

/// Why raw data gives no view.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SweepError {
    /// There is nothing in it.
    #[error("sweep has no scans")]
    Empty,
    /// A figure that no sweep can have.
    #[error("sweep has {what} {got}, expected {expected}")]
    Figure {
        /// Which.
        what: &'static str,
        /// Its value.
        got: f64,
        /// What it should be.
        expected: &'static str,
    },
    /// The laser was in places too far apart for one view.
    #[error(
        "laser stood up to {by_m:.2} m from the middle of its places, expected at most {MOST_OFF_ORIGIN_M} m: use fewer pans, or mount the laser over the pan axis"
    )]
    Apart {
        /// How far.
        by_m: f64,
    },
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

/// Projects every beam of every leg into the base's frame, with the mount that the sweep was taken with.
///
/// # Errors
/// No scans, figures that no sweep has, clocks that do not fit, a head that did not follow its command to both ends, a
/// laser whose places lie too far apart.
pub fn assemble(raw: &RawSweep) -> Result<Sweep, SweepError> {
    assemble_with(raw, &raw.mount)
}

/// The same with another mount than the sweep was taken with, after a new calibration.
///
/// # Errors
/// As [`assemble`].
pub fn assemble_with(raw: &RawSweep, mount: &Mount) -> Result<Sweep, SweepError> {
    check(raw, mount)?;
    let (origin, by_m) = origin::common(raw, mount);
    if by_m > MOST_OFF_ORIGIN_M {
        return Err(SweepError::Apart { by_m });
    }
    let mut gathered = Gathered::default();
    for leg in &raw.legs {
        gathered.add(raw, leg, mount)?;
    }
    if gathered.legs.iter().all(|leg| leg.got == 0) {
        return Err(SweepError::Empty);
    }
    Ok(gathered.finish(raw, mount, origin))
}

/// Refuses figures with which nothing can be computed: records come from outside.
fn check(raw: &RawSweep, mount: &Mount) -> Result<(), SweepError> {
    let figure = |what, got, expected| {
        Err(SweepError::Figure {
            what,
            got,
            expected,
        })
    };
    let positive = |x: f64| x.is_finite() && x > 0.0;
    if !positive(raw.line_pitch_rad) {
        return figure("line pitch", raw.line_pitch_rad, "a positive angle");
    }
    let span_rad = raw.tilt_high_rad - raw.tilt_low_rad;
    if !(span_rad.is_finite() && span_rad >= 0.0) {
        return figure("tilt range", span_rad, "an angle of at least 0");
    }
    if span_rad / raw.line_pitch_rad > MOST_LINES {
        return figure(
            "line pitch",
            raw.line_pitch_rad,
            "a pitch of fewer than a million lines",
        );
    }
    if !positive(raw.tilt_rad_per_step.abs()) {
        return figure("tilt per count", raw.tilt_rad_per_step, "an angle, not 0");
    }
    if !positive(raw.optics.period_s) {
        return figure("scan period", raw.optics.period_s, "a positive time");
    }
    if raw.optics.steps_per_turn == 0 {
        return figure("steps per turn", 0.0, "at least 1");
    }
    let pans = raw.legs.iter().map(|leg| leg.pan_rad);
    let mut places = mount
        .numbers()
        .into_iter()
        .chain([raw.tilt_zero_rad, raw.time_offset_s, raw.tilt_backlash_rad])
        .chain(pans);
    if let Some(got) = places.find(|x| !x.is_finite()) {
        return figure("an offset, a turn, a pan or a backlash", got, "a number");
    }
    Ok(())
}

/// Lines that a leg is to have.
fn lines_per_leg(raw: &RawSweep) -> usize {
    let span_rad = raw.tilt_high_rad - raw.tilt_low_rad;
    (span_rad / raw.line_pitch_rad).floor() as usize + 1
}

#[derive(Default)]
struct Gathered {
    points: Vec<Point3<f64>>,
    no_return: Vec<Unit<Vector3<f64>>>,
    beams: usize,
    legs: Vec<LegLines>,
    widest: Gap,
    gaps: usize,
    residual_steps: f64,
    clock_uncertainty_s: f64,
    clock_uncertainty_rad: f64,
    clock_rate: f64,
    frozen: bool,
    blind_lines: usize,
    parts: Vec<LegPart>,
}

impl Gathered {
    fn add(&mut self, raw: &RawSweep, leg: &Leg, mount: &Mount) -> Result<(), SweepError> {
        let pan_deg = leg.pan_rad.to_degrees();
        let clock = SensorClock::fit(&leg.time_samples, &leg.scans)
            .map_err(|source| SweepError::Clock { pan_deg, source })?;
        let tilt =
            LegTilt::fit(raw, leg).map_err(|source| SweepError::Attitude { pan_deg, source })?;
        let mut tilts_rad = Vec::with_capacity(leg.scans.len());
        let first_point = self.points.len();
        let period_s = leg.scan_period_s(raw.optics.period_s) * clock.rate;
        for (index, scan) in leg.scans.iter().enumerate() {
            let start_s = clock.host_s(scan.stamp_ms);
            let tilt_rad = |share: f64| tilt.tilt_rad(index, start_s + share * period_s);
            let middle_rad = tilt_rad(0.5);
            let seen_moving = tilt.covers(start_s) && tilt.covers(start_s + period_s);
            if !(raw.tilt_low_rad..=raw.tilt_high_rad).contains(&middle_rad) || !seen_moving {
                continue;
            }
            tilts_rad.push(middle_rad);
            self.blind_lines += usize::from(is_blind(&scan.values, &raw.optics));
            self.project(raw, scan, |share| {
                mount.base_from_laser(leg.pan_rad, tilt_rad(share))
            });
        }
        self.parts.push(LegPart {
            tilt_axis: mount.tilt_axis(leg.pan_rad),
            points: first_point..self.points.len(),
        });
        let (got, widest) = lines::count(
            &mut tilts_rad,
            raw.tilt_low_rad,
            raw.tilt_high_rad,
            raw.line_pitch_rad,
        );
        let expected = lines_per_leg(raw);
        self.legs.push(LegLines {
            pan_rad: leg.pan_rad,
            expected,
            got: got.min(expected),
        });
        self.widest.lines = self.widest.lines.max(widest.lines);
        self.widest.angle_rad = self.widest.angle_rad.max(widest.angle_rad);
        self.clock_uncertainty_rad = self
            .clock_uncertainty_rad
            .max(clock.uncertainty_s * tilt.speed_rad_s().abs());
        self.gaps += gaps(&leg.scans, raw.optics.period_s, &leg.motion);
        self.frozen |= is_frozen(&leg.scans, raw.optics.dmin_mm);
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

    fn finish(self, raw: &RawSweep, mount: &Mount, origin: Point3<f64>) -> Sweep {
        let beams = self.beams.max(1) as f64;
        let quality = Quality {
            lines_expected: self.legs.iter().map(|leg| leg.expected).sum(),
            lines_got: self.legs.iter().map(|leg| leg.got).sum(),
            gaps: self.gaps,
            widest_gap_lines: self.widest.lines,
            widest_gap_rad: self.widest.angle_rad,
            line_pitch_rad: raw.line_pitch_rad,
            legs: self.legs,
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
        let tilt_axis = match &raw.legs[..] {
            [leg] => Some(mount.tilt_axis(leg.pan_rad)),
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
            parts: self.parts,
        }
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

/// Scans without any range repeat each other where the laser is blind, which is another fault.
fn is_frozen(scans: &[RawScan], dmin_mm: u32) -> bool {
    scans.windows(FROZEN_SCANS).any(|run| {
        let first = &run[0].values;
        let lively = first.iter().any(|v| *v >= dmin_mm);
        lively && run.iter().all(|scan| scan.values == *first)
    })
}

#[cfg(test)]
mod tests;
