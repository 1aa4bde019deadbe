//! Beams on surfaces, and the values of the unknowns that make the surfaces flat: Levenberg-Marquardt with robust weights,
//! every surface refitted in every step.

use super::beams::CalibrationBeam;
use super::constants::{DONE_SHARE, LEG_TIME_S, MOST_STEPS, ROBUST_SIGMAS};
use super::normal::Normal;
use super::planes::Plane;
use super::unknowns::{Chain, Parameter, SHARED};
use crate::geometry::Mount;
use nalgebra::{DMatrix, Vector3};
use std::collections::BTreeMap;

/// A beam that met a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OnPlane {
    /// Which beam.
    pub beam: usize,
    /// Which surface.
    pub plane: usize,
    /// Standard deviation across the surface, metres, by the sensor's law.
    pub sigma_m: f64,
}

/// What the residuals have to do with noise.
#[derive(Debug, Clone, PartialEq)]
pub struct Scatter {
    /// By how much the law's standard deviations are to be multiplied, for every surface.
    pub scales: Vec<f64>,
    /// For how many beams one that shares its noise with its neighbours stands, at least 1.
    pub sharing: f64,
}

/// All that is held fixed while solving.
pub struct Problem<'a> {
    /// The chain; its laser's place and turn are replaced.
    pub mount: &'a Mount,
    /// Values believed beforehand.
    pub believed: [f64; SHARED],
    /// All beams.
    pub beams: &'a [CalibrationBeam],
    /// Those that count.
    pub met: &'a [OnPlane],
    /// How they scatter.
    pub scatter: &'a Scatter,
    /// A surface known to be level, and the standard deviation of that, radians.
    pub level: Option<(usize, f64)>,
}

/// One beam's residual, its derivatives by the unknowns `at`, its weight and what it costs.
struct Row {
    at: [usize; SHARED + 4],
    slopes: [f64; SHARED + 4],
    residual_m: f64,
    weight: f64,
    cost: f64,
}

/// Values of all unknowns.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// In the order of [`Parameter::ALL`].
    pub shared: [f64; SHARED],
    /// Time error of every leg by itself, seconds.
    pub leg_time_s: Vec<f64>,
    /// The surfaces.
    pub planes: Vec<Plane>,
}

impl State {
    fn unknowns(&self) -> usize {
        SHARED + self.leg_time_s.len() + 3 * self.planes.len()
    }

    fn stepped(&self, step: &[f64]) -> Self {
        let mut next = self.clone();
        let (shared, rest) = step.split_at(SHARED);
        let (legs, planes) = rest.split_at(self.leg_time_s.len());
        next.shared
            .iter_mut()
            .zip(shared)
            .for_each(|(x, d)| *x += d);
        next.leg_time_s
            .iter_mut()
            .zip(legs)
            .for_each(|(x, d)| *x += d);
        for (plane, by) in next.planes.iter_mut().zip(planes.chunks_exact(3)) {
            let (a, b) = across(&plane.normal);
            plane.normal = (plane.normal + a * by[0] + b * by[1]).normalize();
            plane.offset_m += by[2];
        }
        next
    }
}

/// Two unit vectors across a unit vector and each other.
fn across(normal: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let mut axis = Vector3::zeros();
    axis[normal.iamin()] = 1.0;
    let a = normal.cross(&axis).normalize();
    (a, normal.cross(&a))
}

impl Problem<'_> {
    /// Distances of the beams that count from their surfaces, metres.
    pub fn residuals_m(&self, state: &State) -> Vec<f64> {
        let chain = Chain::new(self.mount, &state.shared);
        self.met
            .iter()
            .map(|on| {
                let beam = &self.beams[on.beam];
                let place = chain.place(beam, state.leg_time_s[beam.leg]);
                state.planes[on.plane].height_m(&place.point)
            })
            .collect()
    }

    /// The values that cost least, from `state` on, and the normal equations there.
    pub fn solve(&self, mut state: State) -> (State, Normal) {
        let mut normal = self.normal(&state);
        let mut damping = 1e-4;
        for _ in 0..MOST_STEPS {
            let Some(step) = normal.step(damping) else {
                break;
            };
            let next = state.stepped(step.as_slice());
            let there = self.normal(&next);
            if there.cost <= normal.cost {
                let done = normal.cost - there.cost <= DONE_SHARE * normal.cost;
                (state, normal) = (next, there);
                damping = (damping * 0.1_f64).max(1e-12);
                if done {
                    break;
                }
            } else {
                damping = (damping * 10.0).max(1e-6);
            }
        }
        (state, normal)
    }

    fn normal(&self, state: &State) -> Normal {
        let mut normal = Normal::new(state.unknowns());
        self.add_beams(&mut normal, state);
        self.add_beliefs(&mut normal, state);
        normal
    }

    fn add_beams(&self, normal: &mut Normal, state: &State) {
        let chain = Chain::new(self.mount, &state.shared);
        for on in self.met {
            let row = self.row(&chain, state, on);
            normal.add(&row.at, &row.slopes, row.residual_m, row.weight, row.cost);
        }
    }

    fn row(&self, chain: &Chain, state: &State, on: &OnPlane) -> Row {
        let beam = &self.beams[on.beam];
        let plane = &state.planes[on.plane];
        let place = chain.place(beam, state.leg_time_s[beam.leg]);
        let (shared, by_leg) = chain.derivatives(beam, &place, &plane.normal);
        let (a, b) = across(&plane.normal);
        let point = &place.point.coords;
        let first = SHARED + state.leg_time_s.len() + 3 * on.plane;
        let mut at = [0; SHARED + 4];
        let mut slopes = [0.0; SHARED + 4];
        for i in 0..SHARED {
            (at[i], slopes[i]) = (i, shared[i]);
        }
        at[SHARED..].copy_from_slice(&[SHARED + beam.leg, first, first + 1, first + 2]);
        slopes[SHARED..].copy_from_slice(&[by_leg, a.dot(point), b.dot(point), -1.0]);
        let residual_m = plane.height_m(&place.point);
        let sigma = on.sigma_m * self.scatter.scales[on.plane];
        let z = (residual_m / sigma).abs();
        let (robust, cost) = if z <= ROBUST_SIGMAS {
            (1.0, z * z / 2.0)
        } else {
            (ROBUST_SIGMAS / z, ROBUST_SIGMAS * (z - ROBUST_SIGMAS / 2.0))
        };
        let share = 1.0 / self.scatter.sharing;
        Row {
            at,
            slopes,
            residual_m,
            weight: robust * share / sigma.powi(2),
            cost: cost * share,
        }
    }

    /// Covariance of the unknowns at a solution: no smaller than beams independent of each other would have it, nor than
    /// what the surfaces show, whose beams err together at one pan (things on walls, edges, noise that is not the law's):
    /// by how much the answer moves where one surface at one pan is left out (jackknife by clusters, its step linear: the
    /// CR3 of Bell and McCaffrey). The plain sandwich is too small for the few surfaces of a room. A surface known to be level
    /// is left out a leg at a time: how even it is is part of what is known of it, and without it nothing is. `None` where
    /// something is not determined.
    pub fn covariance(&self, state: &State, normal: &Normal) -> Option<DMatrix<f64>> {
        let alone = normal.covariance()?;
        let chain = Chain::new(self.mount, &state.shared);
        let mut clusters: BTreeMap<(usize, u64, Option<usize>), Normal> = BTreeMap::new();
        let level = self.level.map(|(plane, _)| plane);
        for on in self.met {
            let row = self.row(&chain, state, on);
            let beam = &self.beams[on.beam];
            let leg = (level == Some(on.plane)).then_some(beam.leg);
            let cluster = (on.plane, beam.pan_rad.to_bits(), leg);
            clusters
                .entry(cluster)
                .or_insert_with(|| Normal::new(state.unknowns()))
                .add(&row.at, &row.slopes, row.residual_m, row.weight, row.cost);
        }
        let mut beliefs = Normal::new(state.unknowns());
        self.add_beliefs(&mut beliefs, state);
        let most = clusters.len() as f64;
        let share = (most - 1.0).max(1.0) / most;
        let mut together = &alone * beliefs.information() * &alone;
        for cluster in clusters.values() {
            let moved = normal.moved_without(cluster)?;
            together += &moved * moved.transpose() * share;
        }
        for i in 0..alone.nrows() {
            together[(i, i)] = together[(i, i)].max(alone[(i, i)]);
        }
        Some(together)
    }

    /// What is known without any beam.
    fn add_beliefs(&self, normal: &mut Normal, state: &State) {
        let mut believe = |at: &[usize], slopes: &[f64], residual: f64, sigma: f64| {
            let weight = sigma.powi(-2);
            normal.add(
                at,
                slopes,
                residual,
                weight,
                weight * residual * residual / 2.0,
            );
        };
        for (i, parameter) in Parameter::ALL.into_iter().enumerate() {
            let off = state.shared[i] - self.believed[i];
            believe(&[i], &[1.0], off, parameter.prior());
        }
        for (leg, off) in state.leg_time_s.iter().enumerate() {
            believe(&[SHARED + leg], &[1.0], *off, LEG_TIME_S);
        }
        if let Some((plane, sigma)) = self.level {
            let first = SHARED + state.leg_time_s.len() + 3 * plane;
            let n = &state.planes[plane].normal;
            let (a, b) = across(n);
            believe(&[first, first + 1], &[a.x, b.x], n.x, sigma);
            believe(&[first, first + 1], &[a.y, b.y], n.y, sigma);
        }
    }
}
