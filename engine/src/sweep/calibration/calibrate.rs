//! From raw sweeps to estimates of the parameters, their standard deviations, and whether they are observable.

use super::beams::{CalibrationBeam, calibration_beams};
use super::constants::{MIN_FLOOR_COS, MIN_PLANES, MIN_SIGMA_M, ROUNDS, SAME_PAN_RAD};
use super::normal_equations::DenseNormalEquations;
use super::parameters::{CalibrationParameter, CalibrationValues, KinematicChain, SHARED_UNKNOWNS};
use super::planes::{CalibrationPlane, PanSegmentPoints, find_planes};
use super::residual_scatter::{residual_scatter, up_down_mismatch_m};
use super::solve::{CalibrationProblem, CalibrationState, PlaneHit, ResidualScatter};
use crate::sweep::constants::URG_NOISE;
use crate::sweep::error::SweepError;
use crate::sweep::raw::RawSweep;
use nalgebra::{Point3, Vector3};
use std::f64::consts::PI;

/// The estimate of one parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterEstimate {
    /// The parameter.
    pub parameter: CalibrationParameter,
    /// The value that the sweeps were taken with, in the parameter's unit.
    pub present: f64,
    /// The estimated value.
    pub value: f64,
    /// Standard deviation of the estimate.
    pub sigma: f64,
    /// Whether the sweeps determine the parameter; if not, `value` means nothing.
    pub observable: bool,
}

/// The result of a calibration.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// In the order of [`CalibrationParameter::ALL`].
    pub estimates: Vec<ParameterEstimate>,
    /// Number of pan segments of all sweeps.
    pub pan_segments: usize,
    /// Number of planes found.
    pub planes: usize,
    /// Number of beams on them.
    pub beams: usize,
    /// Root mean square distance of those beams from their planes, metres.
    pub residual_m: f64,
    /// Distance between planes seen on travels up and the same planes seen on travels down, with the present values and with
    /// the estimated ones, metres; `None` if no plane was seen both ways.
    pub up_down_mismatch_m: Option<(f64, f64)>,
}

/// Why sweeps give no calibration.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    /// A sweep that cannot be used.
    #[error(transparent)]
    Sweep(#[from] SweepError),
    /// Sweeps taken with different configurations.
    #[error(
        "sweep {index} was taken with another mount, clock or backlash than the first: give sweeps of one configuration"
    )]
    Mixed {
        /// Number of the sweep, from 1.
        index: usize,
    },
    /// Too few planes.
    #[error(
        "{got} flat surfaces found, expected at least {MIN_PLANES}: sweep a room with walls and a floor within 4 m"
    )]
    TooFewPlanes {
        /// Number of planes found.
        got: usize,
    },
    /// The solver found no solution.
    #[error("no values fit the sweeps: did something move while they were taken?")]
    NoFit,
}

/// Estimates mount, clock and head from sweeps that were all taken from one position. Sweeps at several pans also show whether
/// the laser is mounted the other way up than configured. `floor_level_rad`: the floor is known to
/// be level in the base frame, to that standard deviation.
///
/// # Errors
/// Sweeps that cannot be used, or too few planes.
pub fn calibrate(
    sweeps: &[RawSweep],
    floor_level_rad: Option<f64>,
) -> Result<Calibration, CalibrationError> {
    let first = sweeps.first().ok_or(SweepError::Empty)?;
    let present = CalibrationValues {
        mount: first.mount.clone(),
        time_offset_s: first.time_offset_s,
        tilt_backlash_rad: first.tilt_backlash_rad,
    };
    let configuration = |s: &RawSweep| {
        (
            s.mount.parameters(),
            s.time_offset_s,
            s.tilt_backlash_rad,
            s.tilt_zero_rad,
        )
    };
    if let Some(at) = sweeps
        .iter()
        .position(|s| configuration(s) != configuration(first))
    {
        return Err(CalibrationError::Mixed { index: at + 1 });
    }
    let mut input = CalibrationInput {
        prior: present.values(),
        beams: calibration_beams(sweeps)?,
        pitches_rad: sweeps
            .iter()
            .flat_map(|s| s.pan_segments.iter().map(|_| s.line_pitch_rad))
            .collect(),
        floor_level_rad,
        present,
    };
    let turned_over = input.turned_over();
    if input.beams_on_common_planes(turned_over) > input.beams_on_common_planes(input.prior) {
        input.prior = turned_over;
    }
    let mut shared = input.prior;
    let mut segment_time_s = vec![0.0; input.pitches_rad.len()];
    let mut fitted = None;
    for tolerance in ROUNDS {
        let fit = input.fit(shared, segment_time_s, tolerance)?;
        shared = fit.state.shared;
        segment_time_s = fit.state.segment_time_s.clone();
        fitted = Some(fit);
    }
    input.report(&fitted.ok_or(CalibrationError::NoFit)?)
}

/// The data of a calibration.
struct CalibrationInput {
    present: CalibrationValues,
    /// Where the search starts and what it is drawn to: the present values, or those of a laser turned over.
    prior: [f64; SHARED_UNKNOWNS],
    beams: Vec<CalibrationBeam>,
    /// Angle between lines, for every pan segment.
    pitches_rad: Vec<f64>,
    floor_level_rad: Option<f64>,
}

/// The result of one round.
struct RoundFit {
    hits: Vec<PlaneHit>,
    scatter: ResidualScatter,
    state: CalibrationState,
    normal: DenseNormalEquations,
}

impl CalibrationInput {
    /// The present values of a laser that is mounted the other way up.
    fn turned_over(&self) -> [f64; SHARED_UNKNOWNS] {
        let mut values = self.present.values();
        values[0] = if values[0] > 0.0 {
            values[0] - PI
        } else {
            values[0] + PI
        };
        values
    }

    /// Beams on planes that at least two pans saw. A cloud taken for the other way up is mirrored, so that a wall stands
    /// somewhere else for each pan; with one pan nothing shows it.
    fn beams_on_common_planes(&self, shared: [f64; SHARED_UNKNOWNS]) -> usize {
        let mut state = CalibrationState {
            shared,
            segment_time_s: vec![0.0; self.pitches_rad.len()],
            planes: Vec::new(),
        };
        let hits = self.find_hits(&mut state, ROUNDS[0]);
        let mut pans_rad = vec![None; state.planes.len()];
        let mut is_common = vec![false; state.planes.len()];
        for hit in &hits {
            let pan_rad = self.beams[hit.beam].pan_rad;
            let first_rad = *pans_rad[hit.plane].get_or_insert(pan_rad);
            is_common[hit.plane] |= (pan_rad - first_rad).abs() > SAME_PAN_RAD;
        }
        hits.iter().filter(|hit| is_common[hit.plane]).count()
    }

    /// Finds planes at these values and makes them flat.
    fn fit(
        &self,
        shared: [f64; SHARED_UNKNOWNS],
        segment_time_s: Vec<f64>,
        tolerance: (f64, f64),
    ) -> Result<RoundFit, CalibrationError> {
        let mut state = CalibrationState {
            shared,
            segment_time_s,
            planes: Vec::new(),
        };
        let hits = self.find_hits(&mut state, tolerance);
        let planes = state.planes.len();
        if planes < MIN_PLANES {
            return Err(CalibrationError::TooFewPlanes { got: planes });
        }
        let nominal = ResidualScatter {
            scales: vec![1.0; planes],
            correlated_beams: 1.0,
        };
        let (state, _) = self.problem(&hits, &nominal, &state).solve(state.clone());
        // The weights need the scatter, and the scatter needs a fit.
        let residuals_m = self.problem(&hits, &nominal, &state).residuals_m(&state);
        let scatter = residual_scatter(&self.beams, &hits, &residuals_m, planes);
        let (state, normal) = self.problem(&hits, &scatter, &state).solve(state.clone());
        Ok(RoundFit {
            hits,
            scatter,
            state,
            normal,
        })
    }

    fn problem<'a>(
        &'a self,
        hits: &'a [PlaneHit],
        scatter: &'a ResidualScatter,
        state: &CalibrationState,
    ) -> CalibrationProblem<'a> {
        let level = self
            .floor_level_rad
            .and_then(|sigma| Some((floor(&state.planes)?, sigma)));
        CalibrationProblem {
            mount: &self.present.mount,
            prior: self.prior,
            beams: &self.beams,
            hits,
            scatter,
            level,
        }
    }

    /// Finds the planes that the beams show at `state` and stores them there; returns the beams that hit one.
    fn find_hits(&self, state: &mut CalibrationState, tolerance: (f64, f64)) -> Vec<PlaneHit> {
        let beams = &self.beams;
        let chain = KinematicChain::new(&self.present.mount, &state.shared);
        let ends: Vec<_> = beams
            .iter()
            .map(|beam| chain.endpoint(beam, state.segment_time_s[beam.pan_segment]))
            .collect();
        let points: Vec<Point3<f64>> = ends.iter().map(|end| end.point).collect();
        let mut segments = Vec::new();
        let mut begin = 0;
        for run in beams.chunk_by(|a, b| a.pan_segment == b.pan_segment) {
            let own = begin..begin + run.len();
            let sum: Vector3<f64> = own
                .clone()
                .map(|i| points[i].coords - ends[i].direction * beams[i].range_m)
                .sum();
            begin = own.end;
            segments.push(PanSegmentPoints {
                origin: Point3::from(sum / run.len() as f64),
                pitch_rad: self.pitches_rad[run[0].pan_segment],
                points: &points[own],
            });
        }
        let (planes, plane_of_point) = find_planes(&segments, tolerance);
        state.planes = planes;
        plane_of_point
            .into_iter()
            .enumerate()
            .filter_map(|(beam, plane)| {
                let plane = plane?;
                let cos = ends[beam].direction.dot(&state.planes[plane].normal).abs();
                let sigma_m = URG_NOISE.sigma_m(beams[beam].range_m) * cos;
                Some(PlaneHit {
                    beam,
                    plane,
                    sigma_m: sigma_m.hypot(MIN_SIGMA_M),
                })
            })
            .collect()
    }

    fn report(&self, fit: &RoundFit) -> Result<Calibration, CalibrationError> {
        let RoundFit { hits, state, .. } = fit;
        let problem = self.problem(hits, &fit.scatter, state);
        let present = CalibrationState {
            shared: self.prior,
            segment_time_s: vec![0.0; state.segment_time_s.len()],
            planes: state.planes.clone(),
        };
        let before_m = problem.residuals_m(&present);
        let after_m = problem.residuals_m(state);
        let mismatch_m = |r: &[f64]| up_down_mismatch_m(&self.beams, hits, r, state.planes.len());
        let squares: f64 = after_m.iter().map(|r| r * r).sum();
        let covariance = problem.covariance(state, &fit.normal);
        let covariance = covariance.ok_or(CalibrationError::NoFit)?;
        Ok(Calibration {
            estimates: estimates(&self.present.values(), &state.shared, |i| {
                let sigma = covariance[(i, i)].sqrt();
                sigma.hypot(CalibrationParameter::ALL[i].common_sigma())
            }),
            pan_segments: state.segment_time_s.len(),
            planes: state.planes.len(),
            beams: hits.len(),
            residual_m: (squares / hits.len().max(1) as f64).sqrt(),
            up_down_mismatch_m: mismatch_m(&before_m).zip(mismatch_m(&after_m)),
        })
    }
}

fn estimates(
    present: &[f64; SHARED_UNKNOWNS],
    found: &[f64; SHARED_UNKNOWNS],
    sigma: impl Fn(usize) -> f64,
) -> Vec<ParameterEstimate> {
    CalibrationParameter::ALL
        .into_iter()
        .enumerate()
        .map(|(i, parameter)| ParameterEstimate {
            parameter,
            present: present[i],
            value: found[i],
            sigma: sigma(i),
            observable: sigma(i) <= parameter.max_sigma(),
        })
        .collect()
}

/// The lowest plane that faces up.
fn floor(planes: &[CalibrationPlane]) -> Option<usize> {
    let level = planes
        .iter()
        .enumerate()
        .filter(|(_, p)| p.normal.z > MIN_FLOOR_COS);
    level
        .min_by(|a, b| a.1.offset_m.total_cmp(&b.1.offset_m))
        .map(|(i, _)| i)
}
