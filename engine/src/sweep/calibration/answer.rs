//! From raw sweeps to estimates with their standard deviations, and to what cannot be told from them.

use super::beams::{self, CalibrationBeam};
use super::constants::{FLOOR_COS, LEAST_PLANES, LEAST_SIGMA_M, ROUNDS};
use super::normal::Normal;
use super::planes::{self, LegPoints, Plane};
use super::solve::{OnPlane, Problem, Scatter, State};
use super::spread::{scatter, up_against_down_m};
use super::unknowns::{Chain, Parameter, Present, SHARED};
use crate::sweep::assemble::SweepError;
use crate::sweep::constants::URG_NOISE;
use crate::sweep::raw::RawSweep;
use nalgebra::{Point3, Vector3};

/// One parameter, as the sweeps tell it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Which.
    pub parameter: Parameter,
    /// The value in force, in the parameter's unit.
    pub present: f64,
    /// The value that the sweeps ask for.
    pub value: f64,
    /// Standard deviation of that.
    pub sigma: f64,
    /// Whether the sweeps tell it at all: otherwise `value` says nothing.
    pub observable: bool,
}

/// What sweeps say of the robot that took them.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// In the order of [`Parameter::ALL`].
    pub estimates: Vec<Estimate>,
    /// Legs of all sweeps.
    pub legs: usize,
    /// Flat surfaces that were found.
    pub planes: usize,
    /// Beams on them.
    pub beams: usize,
    /// Root mean square distance of those beams from their surfaces, metres: what is left is noise.
    pub residual_m: f64,
    /// How far surfaces seen on travels up lie from the same seen on travels down, with the values in force and with the
    /// new ones, metres; `None` where no surface was seen both ways.
    pub up_against_down_m: Option<(f64, f64)>,
}

/// Why sweeps say nothing.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    /// A sweep that cannot be used.
    #[error(transparent)]
    Sweep(#[from] SweepError),
    /// Sweeps of different heads or lasers.
    #[error(
        "sweep {index} was taken with another mount, clock or backlash than the first: give sweeps of one configuration"
    )]
    Mixed {
        /// Which, counted from 1.
        index: usize,
    },
    /// Too little that is flat.
    #[error(
        "{got} flat surfaces found, expected at least {LEAST_PLANES}: sweep a room with walls and a floor within 4 m"
    )]
    TooFewPlanes {
        /// How many there were.
        got: usize,
    },
    /// The numbers do not come to rest.
    #[error("no values fit the sweeps: did something move while they were taken?")]
    NoFit,
}

/// Finds what the sweeps, all taken from one place, tell of mount, clock and head. `floor_level_rad`: the floor is known to
/// be level under the robot's base, to that standard deviation.
///
/// # Errors
/// Sweeps that cannot be used, or show too little that is flat.
pub fn calibrate(
    sweeps: &[RawSweep],
    floor_level_rad: Option<f64>,
) -> Result<Calibration, CalibrationError> {
    let first = sweeps.first().ok_or(SweepError::Empty)?;
    let present = Present {
        mount: first.mount.clone(),
        time_offset_s: first.time_offset_s,
        tilt_backlash_rad: first.tilt_backlash_rad,
    };
    let settled = |s: &RawSweep| {
        (
            s.mount.numbers(),
            s.time_offset_s,
            s.tilt_backlash_rad,
            s.tilt_zero_rad,
        )
    };
    if let Some(at) = sweeps.iter().position(|s| settled(s) != settled(first)) {
        return Err(CalibrationError::Mixed { index: at + 1 });
    }
    let believed = present.values();
    let given = Given {
        believed,
        beams: beams::of_sweeps(sweeps)?,
        pitches_rad: sweeps
            .iter()
            .flat_map(|s| s.legs.iter().map(|_| s.line_pitch_rad))
            .collect(),
        floor_level_rad,
        present,
    };
    let mut shared = believed;
    let mut leg_time_s = vec![0.0; given.pitches_rad.len()];
    let mut fitted = None;
    for round in ROUNDS {
        let fit = given.fit(shared, leg_time_s, round)?;
        shared = fit.state.shared;
        leg_time_s = fit.state.leg_time_s.clone();
        fitted = Some(fit);
    }
    given.tell(&fitted.ok_or(CalibrationError::NoFit)?)
}

/// What a calibration is made from.
struct Given {
    present: Present,
    believed: [f64; SHARED],
    beams: Vec<CalibrationBeam>,
    /// Between two lines, for every leg.
    pitches_rad: Vec<f64>,
    floor_level_rad: Option<f64>,
}

/// What one round came to.
struct Fit {
    met: Vec<OnPlane>,
    scatter: Scatter,
    state: State,
    normal: Normal,
}

impl Given {
    /// Looks for surfaces under these values and makes them flat.
    fn fit(
        &self,
        shared: [f64; SHARED],
        leg_time_s: Vec<f64>,
        round: (f64, f64),
    ) -> Result<Fit, CalibrationError> {
        let mut state = State {
            shared,
            leg_time_s,
            planes: Vec::new(),
        };
        let met = self.meet(&mut state, round);
        let planes = state.planes.len();
        if planes < LEAST_PLANES {
            return Err(CalibrationError::TooFewPlanes { got: planes });
        }
        let as_the_law_says = Scatter {
            scales: vec![1.0; planes],
            sharing: 1.0,
        };
        let (state, _) = self
            .problem(&met, &as_the_law_says, &state)
            .solve(state.clone());
        // The weights need the scatter and the scatter the fit.
        let residuals_m = self
            .problem(&met, &as_the_law_says, &state)
            .residuals_m(&state);
        let scatter = scatter(&self.beams, &met, &residuals_m, planes);
        let (state, normal) = self.problem(&met, &scatter, &state).solve(state.clone());
        Ok(Fit {
            met,
            scatter,
            state,
            normal,
        })
    }

    fn problem<'a>(
        &'a self,
        met: &'a [OnPlane],
        scatter: &'a Scatter,
        state: &State,
    ) -> Problem<'a> {
        let level = self
            .floor_level_rad
            .and_then(|sigma| Some((floor(&state.planes)?, sigma)));
        Problem {
            mount: &self.present.mount,
            believed: self.believed,
            beams: &self.beams,
            met,
            scatter,
            level,
        }
    }

    /// Puts the surfaces that the beams show under `state` into it; the beams that met one.
    fn meet(&self, state: &mut State, round: (f64, f64)) -> Vec<OnPlane> {
        let beams = &self.beams;
        let chain = Chain::new(&self.present.mount, &state.shared);
        let places: Vec<_> = beams
            .iter()
            .map(|beam| chain.place(beam, state.leg_time_s[beam.leg]))
            .collect();
        let points: Vec<Point3<f64>> = places.iter().map(|p| p.point).collect();
        let mut legs = Vec::new();
        let mut begin = 0;
        for run in beams.chunk_by(|a, b| a.leg == b.leg) {
            let own = begin..begin + run.len();
            let sum: Vector3<f64> = own
                .clone()
                .map(|i| points[i].coords - places[i].direction * beams[i].range_m)
                .sum();
            begin = own.end;
            legs.push(LegPoints {
                origin: Point3::from(sum / run.len() as f64),
                pitch_rad: self.pitches_rad[run[0].leg],
                points: &points[own],
            });
        }
        let (planes, plane_of_point) = planes::find(&legs, round);
        state.planes = planes;
        plane_of_point
            .into_iter()
            .enumerate()
            .filter_map(|(beam, plane)| {
                let plane = plane?;
                let cos = places[beam]
                    .direction
                    .dot(&state.planes[plane].normal)
                    .abs();
                let across_m = URG_NOISE.sigma_m(beams[beam].range_m) * cos;
                Some(OnPlane {
                    beam,
                    plane,
                    sigma_m: across_m.hypot(LEAST_SIGMA_M),
                })
            })
            .collect()
    }

    fn tell(&self, fit: &Fit) -> Result<Calibration, CalibrationError> {
        let Fit { met, state, .. } = fit;
        let problem = self.problem(met, &fit.scatter, state);
        let as_believed = State {
            shared: self.believed,
            leg_time_s: vec![0.0; state.leg_time_s.len()],
            planes: state.planes.clone(),
        };
        let before_m = problem.residuals_m(&as_believed);
        let after_m = problem.residuals_m(state);
        let apart = |r: &[f64]| up_against_down_m(&self.beams, met, r, state.planes.len());
        let squares: f64 = after_m.iter().map(|r| r * r).sum();
        let covariance = problem.covariance(state, &fit.normal);
        let covariance = covariance.ok_or(CalibrationError::NoFit)?;
        Ok(Calibration {
            estimates: estimates(&self.believed, &state.shared, |i| {
                let spread = covariance[(i, i)].sqrt();
                spread.hypot(Parameter::ALL[i].common())
            }),
            legs: state.leg_time_s.len(),
            planes: state.planes.len(),
            beams: met.len(),
            residual_m: (squares / met.len().max(1) as f64).sqrt(),
            up_against_down_m: apart(&before_m).zip(apart(&after_m)),
        })
    }
}

fn estimates(
    believed: &[f64; SHARED],
    found: &[f64; SHARED],
    sigma: impl Fn(usize) -> f64,
) -> Vec<Estimate> {
    Parameter::ALL
        .into_iter()
        .enumerate()
        .map(|(i, parameter)| Estimate {
            parameter,
            present: believed[i],
            value: found[i],
            sigma: sigma(i),
            observable: sigma(i) <= parameter.most(),
        })
        .collect()
}

/// The lowest surface that looks up.
fn floor(planes: &[Plane]) -> Option<usize> {
    let level = planes
        .iter()
        .enumerate()
        .filter(|(_, p)| p.normal.z > FLOOR_COS);
    level
        .min_by(|a, b| a.1.offset_m.total_cmp(&b.1.offset_m))
        .map(|(i, _)| i)
}
