//! Expectation maximisation with full covariances (the paper's reference [12]; Dempster, Laird and
//! Rubin 1977). Exact; the same answer whatever the number of threads.

use super::ascent::Ascent;
use super::constants::{ITERATIONS, REGULARISATION_M2, TOLERANCE};
use super::lattice::Lattice;
use super::pool::in_pool;
use super::{Instructions, Mixture, MixtureError};
use nalgebra::Point3;

/// How long and how carefully to run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EmSettings {
    /// M steps at most.
    pub iterations: usize,
    /// Stop when the mean log-likelihood rises by less than this, nats per point; 0 runs exactly `iterations`.
    pub tolerance: f64,
    /// Added to the covariances' diagonals after each M step, square metres.
    pub regularisation_m2: f64,
    /// Worker threads; 1 works on the caller's thread, 0 uses the pool the caller stands in.
    pub threads: usize,
    /// What the inner loops run on; the portable ones where the processor lacks these.
    pub instructions: Instructions,
}

impl Default for EmSettings {
    fn default() -> Self {
        Self {
            iterations: ITERATIONS,
            tolerance: TOLERANCE,
            regularisation_m2: REGULARISATION_M2,
            threads: 1,
            instructions: Instructions::best(),
        }
    }
}

impl EmSettings {
    fn check(&self) -> Result<(), MixtureError> {
        for (name, got) in [
            ("tolerance", self.tolerance),
            ("regularisation_m2", self.regularisation_m2),
        ] {
            if !got.is_finite() || got < 0.0 {
                return Err(MixtureError::BadSetting {
                    name,
                    got,
                    expected: "a finite number >= 0",
                });
            }
        }
        Ok(())
    }
}

/// Why EM ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Stopped {
    /// The likelihood rose by less than the tolerance.
    Converged,
    /// As many M steps as were allowed, or, with tolerance 0, asked for.
    IterationCap,
}

/// A component that is no full Gaussian of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Collapse {
    /// No point is left to it: weight 0, mean and covariance as last held.
    NoMass,
    /// Its points lie on a plane, line or spot: only the regularisation gives it a thickness.
    NoVolume,
}

/// Where a fit began.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Start {
    /// At a mixture that the caller gave.
    Given,
    /// At the cells of k-means++.
    KMeans {
        /// Which draw of the seed, from 0.
        restart: u64,
    },
    /// At the parts of a cloud that was halved until all were flat.
    Flat,
}

/// What a run of EM gives, and how it came about.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The mixture after the last M step; component k grew from component k of the start.
    pub mixture: Mixture,
    /// Mean over the points (by weight) of ln f under `mixture`, nats.
    pub mean_log_likelihood: f64,
    /// M steps made.
    pub iterations: usize,
    /// Why it ended.
    pub stopped: Stopped,
    /// Components that collapsed, by index.
    pub collapsed: Vec<(usize, Collapse)>,
    /// Where it began.
    pub start: Start,
    /// Runs of EM that it is the best of.
    pub runs: usize,
    /// What the inner loops ran on.
    pub instructions: Instructions,
    /// Worker threads there were.
    pub threads: usize,
}

/// Runs EM from `start` on `points` (metres), each counting as `weights` says (1 if absent).
///
/// Cost: n K per iteration at most, less where components are local. No memory of size n K.
///
/// # Errors
/// No points, no components, coordinates or weights that are not finite, weights without sum,
/// covariances that stay singular (regularisation 0), threads that cannot be had.
pub fn run(
    points: &[Point3<f64>],
    weights: Option<&[f64]>,
    start: Mixture,
    settings: &EmSettings,
) -> Result<Fit, MixtureError> {
    run_frozen(points, weights, start, 0, settings)
}

/// As [`run`], with means and covariances of the first `frozen` components held; their weights are free.
///
/// # Errors
/// As [`run`].
pub fn run_frozen(
    points: &[Point3<f64>],
    weights: Option<&[f64]>,
    start: Mixture,
    frozen: usize,
    settings: &EmSettings,
) -> Result<Fit, MixtureError> {
    ascend(points, weights, start, frozen, 0.0, settings)
}

/// As [`run_frozen`]; `toll` is what every component must hold to live, in mean point weights (see
/// [`super::mml`]).
pub(super) fn ascend(
    points: &[Point3<f64>],
    weights: Option<&[f64]>,
    start: Mixture,
    frozen: usize,
    toll: f64,
    settings: &EmSettings,
) -> Result<Fit, MixtureError> {
    settings.check()?;
    let start = Mixture::from_masses(start.weights, start.components)?;
    if start.is_empty() {
        return Err(MixtureError::NoComponents);
    }
    in_pool(settings.threads, || {
        let lattice = Lattice::new(points, weights, settings.threads != 1)?;
        let toll = toll * lattice.total_weight / points.len() as f64;
        Ascent::new(&lattice, start, frozen, toll, settings)?.climb()
    })?
}

#[cfg(test)]
mod tests {
    use super::{Collapse, EmSettings, Fit, Stopped, run, run_frozen};
    use crate::mixture::{Gaussian, Instructions, Mixture, MixtureError};
    use nalgebra::{Matrix3, Point3, Vector3};
    use proptest::prelude::*;

    fn exactly(iterations: usize) -> EmSettings {
        EmSettings {
            iterations,
            tolerance: 0.0,
            ..EmSettings::default()
        }
    }

    /// Components of 1 m around every stride-th point.
    fn start_at(points: &[Point3<f64>], k: usize) -> Mixture {
        let stride = (points.len() / k).max(1);
        let components = (0..k)
            .map(|i| Gaussian {
                mean: points[(i * stride).min(points.len() - 1)],
                covariance: Matrix3::identity(),
            })
            .collect();
        Mixture {
            weights: vec![1.0 / k as f64; k],
            components,
        }
    }

    fn cloud(
        n: impl Into<proptest::collection::SizeRange>,
    ) -> impl Strategy<Value = Vec<Point3<f64>>> {
        proptest::collection::vec(
            proptest::array::uniform3(-3.0..3.0f64).prop_map(Point3::from),
            n,
        )
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]
        #[test]
        fn likelihood_never_falls_and_is_that_of_the_mixture(points in cloud(40..400), k in 1usize..6) {
            let mut last = f64::NEG_INFINITY;
            for iterations in 0..8 {
                let settings = EmSettings { regularisation_m2: 1e-15, ..exactly(iterations) };
                let fit = run(&points, None, start_at(&points, k), &settings).expect("fits");
                prop_assert!(fit.mean_log_likelihood >= last - 1e-10);
                last = fit.mean_log_likelihood;
                let slow = points.iter().map(|p| fit.mixture.log_density(p).expect("density")).sum::<f64>()
                    / points.len() as f64;
                prop_assert!((slow - last).abs() < 1e-10, "{slow} {last}");
            }
        }

        #[test]
        fn moving_the_cloud_moves_the_mixture(points in cloud(100..300), k in 1usize..5) {
            let shift = Vector3::new(1e6, -1e6, 5e5);
            let far: Vec<_> = points.iter().map(|p| p + shift).collect();
            let here = run(&points, None, start_at(&points, k), &exactly(10)).expect("fits");
            let there = run(&far, None, start_at(&far, k), &exactly(10)).expect("fits");
            prop_assert!((here.mean_log_likelihood - there.mean_log_likelihood).abs() < 1e-6);
            for (a, b) in here.mixture.components.iter().zip(&there.mixture.components) {
                prop_assert!((a.mean + shift - b.mean).norm() < 1e-6);
            }
        }
    }

    proptest! {
        #[test]
        fn no_cloud_gives_a_nan(raw in proptest::collection::vec(proptest::array::uniform3(-2i8..3), 1..20), k in 1usize..6, scale in prop_oneof![Just(0.0), Just(1e-9), Just(1.0), Just(1e6)]) {
            let points: Vec<_> = raw.iter().map(|p| Point3::from(p.map(f64::from)) * scale + Vector3::repeat(1e6)).collect();
            let fit = run(&points, None, start_at(&points, k), &exactly(12)).expect("defined");
            prop_assert!(fit.mean_log_likelihood.is_finite());
            prop_assert!(Mixture::try_new(fit.mixture.weights, fit.mixture.components).is_ok());
        }
    }

    fn lattice_points(n: usize) -> Vec<Point3<f64>> {
        (0..n)
            .map(|i| {
                let t = i as f64;
                Point3::new(
                    (t * 0.37).sin() * 3.0,
                    (t * 0.11).cos() * 2.0,
                    (t * t * 0.013).sin(),
                )
            })
            .collect()
    }

    #[test]
    fn threads_do_not_change_a_bit_of_the_answer() {
        let points = lattice_points(20_000);
        let one = run(&points, None, start_at(&points, 12), &exactly(5)).expect("fits");
        for threads in [0, 2, 3] {
            let settings = EmSettings {
                threads,
                ..exactly(5)
            };
            let fit = run(&points, None, start_at(&points, 12), &settings).expect("fits");
            let told = Fit {
                threads: fit.threads,
                ..one.clone()
            };
            assert_eq!(fit, told);
        }
    }

    #[test]
    fn all_instructions_give_one_answer() {
        let (near, mut far) = (lattice_points(5_000), lattice_points(5_000));
        far.iter_mut()
            .for_each(|p| *p += Vector3::new(1e6, -1e6, 0.0));
        for points in [near, far] {
            let fit = |instructions| {
                let settings = EmSettings {
                    instructions,
                    ..exactly(12)
                };
                run(&points, None, start_at(&points, 9), &settings).expect("fits")
            };
            let portable = fit(Instructions::Portable);
            for set in Instructions::ALL.into_iter().filter(|set| set.available()) {
                let got = fit(set);
                assert_eq!(got.instructions, set);
                assert!((got.mean_log_likelihood - portable.mean_log_likelihood).abs() < 1e-9);
                for k in 0..9 {
                    let (a, b) = (got.mixture.components[k], portable.mixture.components[k]);
                    let apart = got.mixture.weights[k] - portable.mixture.weights[k];
                    assert!(apart.abs() < 1e-9 && (a.mean - b.mean).norm() < 1e-9);
                    assert!((a.covariance - b.covariance).amax() < 1e-9);
                }
            }
        }
    }

    #[test]
    fn a_million_points_and_more_components_than_points_have_answers() {
        let many = lattice_points(1_000_000);
        let fit = run(&many, None, start_at(&many, 3), &exactly(1)).expect("fits");
        assert!(fit.mean_log_likelihood.is_finite() && fit.collapsed.is_empty());
        let few = &many[..3];
        let fit = run(few, None, start_at(few, 10), &exactly(5)).expect("fits");
        assert!(fit.mean_log_likelihood.is_finite());
        assert!(fit.mixture.weights.iter().all(|w| w.is_finite()));
    }

    #[test]
    fn weights_count_as_repeated_points() {
        let points = lattice_points(300);
        let weights: Vec<f64> = (0..300).map(|i| f64::from(i % 3)).collect();
        let repeated: Vec<_> = (0..300).flat_map(|i| vec![points[i]; i % 3]).collect();
        let start = start_at(&points, 4);
        let a = run(&points, Some(&weights), start.clone(), &exactly(10)).expect("fits");
        let b = run(&repeated, None, start, &exactly(10)).expect("fits");
        assert!((a.mean_log_likelihood - b.mean_log_likelihood).abs() < 1e-11);
        for (x, y) in a.mixture.components.iter().zip(&b.mixture.components) {
            assert!((x.mean - y.mean).norm() < 1e-9 && (x.covariance - y.covariance).amax() < 1e-9);
        }
    }

    #[test]
    fn degenerate_clouds_have_defined_answers() {
        let p = Point3::new(1e6, -3.0, 2.0);
        assert_eq!(
            run(&[], None, start_at(&[p], 1), &exactly(1)).expect_err("refused"),
            MixtureError::NoPoints
        );
        assert_eq!(
            run(&[p], None, Mixture::default(), &exactly(1)).expect_err("refused"),
            MixtureError::NoComponents
        );
        let x = Vector3::x();
        let clouds = [
            vec![p],
            vec![p; 50],
            vec![p, p + x, p + Vector3::y()],
            (0..40).map(|i| p + x * f64::from(i)).collect(),
            (0..40)
                .map(|i| p + Vector3::new(f64::from(i % 7), f64::from(i / 7), 0.0))
                .collect(),
        ];
        for points in &clouds {
            for k in [1, 2, 7] {
                let fit = run(points, None, start_at(points, k), &exactly(20)).expect("defined");
                assert!(fit.mean_log_likelihood.is_finite());
                let mixture = fit.mixture;
                Mixture::try_new(mixture.weights, mixture.components).expect("a sound mixture");
                assert!(!fit.collapsed.is_empty());
            }
            let bare = EmSettings {
                regularisation_m2: 0.0,
                ..exactly(3)
            };
            assert!(matches!(
                run(points, None, start_at(points, 1), &bare),
                Err(MixtureError::Singular { component: 0 })
            ));
        }
        assert!(matches!(
            run(
                &[p, Point3::new(f64::NAN, 0.0, 0.0)],
                None,
                start_at(&[p], 1),
                &exactly(1)
            ),
            Err(MixtureError::PointNotFinite { index: 1 })
        ));
    }

    #[test]
    fn a_component_far_from_all_points_dies_and_is_named() {
        let points = lattice_points(500);
        let mut start = start_at(&points, 2);
        start.components[1].mean = Point3::new(500.0, 0.0, 0.0);
        let fit = run(&points, None, start, &exactly(5)).expect("fits");
        assert_eq!(fit.mixture.weights, vec![1.0, 0.0]);
        assert_eq!(fit.collapsed, vec![(1, Collapse::NoMass)]);
        assert!((fit.mixture.components[1].mean.x - 500.0).abs() < 1e-9);
    }

    #[test]
    fn frozen_components_keep_their_shape_and_change_their_weight() {
        let points = lattice_points(900);
        let start = start_at(&points, 3);
        let fit = run_frozen(&points, None, start.clone(), 2, &exactly(8)).expect("fits");
        for k in 0..2 {
            assert!((fit.mixture.components[k].mean - start.components[k].mean).norm() < 1e-12);
            assert_eq!(
                fit.mixture.components[k].covariance,
                start.components[k].covariance
            );
        }
        assert_ne!(
            fit.mixture.components[2].covariance,
            start.components[2].covariance
        );
        assert_ne!(fit.mixture.weights, start.weights);
    }

    #[test]
    fn it_stops_when_nothing_moves() {
        let points = lattice_points(400);
        let settings = EmSettings {
            iterations: 1000,
            tolerance: 1e-6,
            ..EmSettings::default()
        };
        let fit = run(&points, None, start_at(&points, 2), &settings).expect("fits");
        assert_eq!(fit.stopped, Stopped::Converged);
        assert!(fit.iterations < 1000);
        let capped = run(&points, None, start_at(&points, 2), &exactly(3)).expect("fits");
        assert_eq!(
            (capped.stopped, capped.iterations),
            (Stopped::IterationCap, 3)
        );
    }
}
