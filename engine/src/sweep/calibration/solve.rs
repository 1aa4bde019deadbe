//! The values of the parameters that make the planes flat: Levenberg-Marquardt with robust weights; every plane is refitted in
//! every step.

use super::beams::CalibrationBeam;
use super::constants::{CONVERGED_COST_SHARE, HUBER_SIGMAS, MAX_STEPS, SEGMENT_TIME_SIGMA_S};
use super::normal_equations::DenseNormalEquations;
use super::parameters::{CalibrationParameter, KinematicChain, SHARED_UNKNOWNS};
use super::planes::CalibrationPlane;
use crate::geometry::Mount;
use nalgebra::{DMatrix, Vector3};
use std::collections::BTreeMap;

/// A beam that hit a plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PlaneHit {
    /// Index of the beam.
    pub(super) beam: usize,
    /// Index of the plane.
    pub(super) plane: usize,
    /// Standard deviation across the plane by the sensor's noise law, metres.
    pub(super) sigma_m: f64,
}

/// The statistics of the residuals.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ResidualScatter {
    /// Factor of the noise law's standard deviations, for every plane.
    pub(super) scales: Vec<f64>,
    /// Number of beams, at least 1, that count as one independent beam.
    pub(super) correlated_beams: f64,
}

/// What is fixed while solving.
pub(super) struct CalibrationProblem<'a> {
    /// The chain; the pose of the laser on the plate is replaced by the parameters.
    pub(super) mount: &'a Mount,
    /// Prior values, in the order of [`CalibrationParameter::ALL`].
    pub(super) prior: [f64; SHARED_UNKNOWNS],
    /// All beams.
    pub(super) beams: &'a [CalibrationBeam],
    /// Those that hit a plane.
    pub(super) hits: &'a [PlaneHit],
    pub(super) scatter: &'a ResidualScatter,
    /// The index of a plane known to be level, and the standard deviation of that, radians.
    pub(super) level: Option<(usize, f64)>,
}

/// A beam's residual, its derivatives by the unknowns `at`, its weight and its cost.
struct ResidualRow {
    at: [usize; SHARED_UNKNOWNS + 4],
    slopes: [f64; SHARED_UNKNOWNS + 4],
    residual_m: f64,
    weight: f64,
    cost: f64,
}

/// Values of all unknowns.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct CalibrationState {
    /// In the order of [`CalibrationParameter::ALL`].
    pub(super) shared: [f64; SHARED_UNKNOWNS],
    /// Time error of every pan segment, seconds.
    pub(super) segment_time_s: Vec<f64>,
    pub(super) planes: Vec<CalibrationPlane>,
}

impl CalibrationState {
    fn unknowns(&self) -> usize {
        SHARED_UNKNOWNS + self.segment_time_s.len() + 3 * self.planes.len()
    }

    fn stepped(&self, step: &[f64]) -> Self {
        let mut next = self.clone();
        let (shared, rest) = step.split_at(SHARED_UNKNOWNS);
        let (segments, planes) = rest.split_at(self.segment_time_s.len());
        next.shared
            .iter_mut()
            .zip(shared)
            .for_each(|(x, d)| *x += d);
        next.segment_time_s
            .iter_mut()
            .zip(segments)
            .for_each(|(x, d)| *x += d);
        for (plane, by) in next.planes.iter_mut().zip(planes.chunks_exact(3)) {
            let (a, b) = tangents(&plane.normal);
            plane.normal = (plane.normal + a * by[0] + b * by[1]).normalize();
            plane.offset_m += by[2];
        }
        next
    }
}

/// Two unit vectors that span a plane with this normal.
fn tangents(normal: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let mut axis = Vector3::zeros();
    axis[normal.iamin()] = 1.0;
    let a = normal.cross(&axis).normalize();
    (a, normal.cross(&a))
}

impl CalibrationProblem<'_> {
    /// Signed distances of the hits from their planes, metres.
    pub(super) fn residuals_m(&self, state: &CalibrationState) -> Vec<f64> {
        let chain = KinematicChain::new(self.mount, &state.shared);
        self.hits
            .iter()
            .map(|hit| {
                let beam = &self.beams[hit.beam];
                let end = chain.endpoint(beam, state.segment_time_s[beam.pan_segment]);
                state.planes[hit.plane].height_m(&end.point)
            })
            .collect()
    }

    /// The values of smallest cost, from `state` on, and the normal equations there.
    pub(super) fn solve(
        &self,
        mut state: CalibrationState,
    ) -> (CalibrationState, DenseNormalEquations) {
        let mut normal = self.normal_equations(&state);
        let mut damping = 1e-4;
        for _ in 0..MAX_STEPS {
            let Some(step) = normal.step(damping) else {
                break;
            };
            let next = state.stepped(step.as_slice());
            let next_normal = self.normal_equations(&next);
            if next_normal.cost <= normal.cost {
                let converged =
                    normal.cost - next_normal.cost <= CONVERGED_COST_SHARE * normal.cost;
                (state, normal) = (next, next_normal);
                damping = (damping * 0.1_f64).max(1e-12);
                if converged {
                    break;
                }
            } else {
                damping = (damping * 10.0).max(1e-6);
            }
        }
        (state, normal)
    }

    fn normal_equations(&self, state: &CalibrationState) -> DenseNormalEquations {
        let mut normal = DenseNormalEquations::new(state.unknowns());
        self.add_beams(&mut normal, state);
        self.add_priors(&mut normal, state);
        normal
    }

    fn add_beams(&self, normal: &mut DenseNormalEquations, state: &CalibrationState) {
        let chain = KinematicChain::new(self.mount, &state.shared);
        for hit in self.hits {
            let row = self.row(&chain, state, hit);
            normal.add(&row.at, &row.slopes, row.residual_m, row.weight, row.cost);
        }
    }

    fn row(&self, chain: &KinematicChain, state: &CalibrationState, hit: &PlaneHit) -> ResidualRow {
        let beam = &self.beams[hit.beam];
        let plane = &state.planes[hit.plane];
        let end = chain.endpoint(beam, state.segment_time_s[beam.pan_segment]);
        let (shared, by_segment) = chain.derivatives(beam, &end, &plane.normal);
        let (a, b) = tangents(&plane.normal);
        let point = &end.point.coords;
        let first = SHARED_UNKNOWNS + state.segment_time_s.len() + 3 * hit.plane;
        let mut at = [0; SHARED_UNKNOWNS + 4];
        let mut slopes = [0.0; SHARED_UNKNOWNS + 4];
        for i in 0..SHARED_UNKNOWNS {
            (at[i], slopes[i]) = (i, shared[i]);
        }
        at[SHARED_UNKNOWNS..].copy_from_slice(&[
            SHARED_UNKNOWNS + beam.pan_segment,
            first,
            first + 1,
            first + 2,
        ]);
        slopes[SHARED_UNKNOWNS..].copy_from_slice(&[by_segment, a.dot(point), b.dot(point), -1.0]);
        let residual_m = plane.height_m(&end.point);
        let sigma = hit.sigma_m * self.scatter.scales[hit.plane];
        let z = (residual_m / sigma).abs();
        let (robust, cost) = if z <= HUBER_SIGMAS {
            (1.0, z * z / 2.0)
        } else {
            (HUBER_SIGMAS / z, HUBER_SIGMAS * (z - HUBER_SIGMAS / 2.0))
        };
        let share = 1.0 / self.scatter.correlated_beams;
        ResidualRow {
            at,
            slopes,
            residual_m,
            weight: robust * share / sigma.powi(2),
            cost: cost * share,
        }
    }

    /// Covariance of the unknowns at a solution: the larger of that of independent beams and of a jackknife. The beams of one
    /// plane at one pan err covariance (objects on walls, edges, noise beyond the law), so the jackknife leaves out one plane
    /// at one pan at a time, with a linearised step (CR3 of Bell and McCaffrey); the plain sandwich estimate is too small for
    /// the few planes of a room. A plane known to be level is left out one pan segment at a time, since without it some
    /// unknowns are not determined. `None` if an unknown is not determined.
    pub(super) fn covariance(
        &self,
        state: &CalibrationState,
        normal: &DenseNormalEquations,
    ) -> Option<DMatrix<f64>> {
        let independent = normal.covariance()?;
        let chain = KinematicChain::new(self.mount, &state.shared);
        let mut clusters: BTreeMap<(usize, u64, Option<usize>), DenseNormalEquations> =
            BTreeMap::new();
        let level = self.level.map(|(plane, _)| plane);
        for hit in self.hits {
            let row = self.row(&chain, state, hit);
            let beam = &self.beams[hit.beam];
            let segment = (level == Some(hit.plane)).then_some(beam.pan_segment);
            let cluster = (hit.plane, beam.pan_rad.to_bits(), segment);
            clusters
                .entry(cluster)
                .or_insert_with(|| DenseNormalEquations::new(state.unknowns()))
                .add(&row.at, &row.slopes, row.residual_m, row.weight, row.cost);
        }
        let mut priors = DenseNormalEquations::new(state.unknowns());
        self.add_priors(&mut priors, state);
        let count = clusters.len() as f64;
        let share = (count - 1.0).max(1.0) / count;
        let mut covariance = &independent * priors.information() * &independent;
        for cluster in clusters.values() {
            let change = normal.change_without(cluster)?;
            covariance += &change * change.transpose() * share;
        }
        for i in 0..independent.nrows() {
            covariance[(i, i)] = covariance[(i, i)].max(independent[(i, i)]);
        }
        Some(covariance)
    }

    /// What is known without the beams.
    fn add_priors(&self, normal: &mut DenseNormalEquations, state: &CalibrationState) {
        let mut add = |at: &[usize], slopes: &[f64], residual: f64, sigma: f64| {
            let weight = sigma.powi(-2);
            normal.add(
                at,
                slopes,
                residual,
                weight,
                weight * residual * residual / 2.0,
            );
        };
        for (i, parameter) in CalibrationParameter::ALL.into_iter().enumerate() {
            let off = state.shared[i] - self.prior[i];
            add(&[i], &[1.0], off, parameter.prior_sigma());
        }
        for (segment, off) in state.segment_time_s.iter().enumerate() {
            add(
                &[SHARED_UNKNOWNS + segment],
                &[1.0],
                *off,
                SEGMENT_TIME_SIGMA_S,
            );
        }
        if let Some((plane, sigma)) = self.level {
            let first = SHARED_UNKNOWNS + state.segment_time_s.len() + 3 * plane;
            let n = &state.planes[plane].normal;
            let (a, b) = tangents(n);
            add(&[first, first + 1], &[a.x, b.x], n.x, sigma);
            add(&[first, first + 1], &[a.y, b.y], n.y, sigma);
        }
    }
}
