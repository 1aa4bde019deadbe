//! Expectation maximisation with full covariances (Dempster, Laird and Rubin 1977), exact. The result is the same for any
//! number of threads.

use super::em_fit::EmFit;
use super::em_settings::EmSettings;
use super::em_state::EmState;
use super::point_blocks::PointBlocks;
use super::pool::in_pool;
use super::{Mixture, MixtureError};
use nalgebra::Point3;

/// Runs EM from `start` on `points` (metres) with `weights` (1 if absent). Takes at most n K steps per iteration, fewer where
/// components are local, and no memory of that size.
///
/// # Errors
/// No points, no components, coordinates or weights that are not finite, weights without sum,
/// covariances that stay singular (regularisation 0), threads that cannot be had.
pub fn run(
    points: &[Point3<f64>],
    weights: Option<&[f64]>,
    start: Mixture,
    settings: &EmSettings,
) -> Result<EmFit, MixtureError> {
    run_frozen(points, weights, start, 0, settings)
}

/// As [`run`], with means and covariances of the first `frozen` components fixed; their weights are free.
///
/// # Errors
/// As [`run`].
pub(super) fn run_frozen(
    points: &[Point3<f64>],
    weights: Option<&[f64]>,
    start: Mixture,
    frozen: usize,
    settings: &EmSettings,
) -> Result<EmFit, MixtureError> {
    run_with_mass_penalty(points, weights, start, frozen, 0.0, settings)
}

/// As [`run_frozen`], with `mass_penalty` (in mean point weights) subtracted from every component in each M step (see
/// [`super::mml`]).
pub(super) fn run_with_mass_penalty(
    points: &[Point3<f64>],
    weights: Option<&[f64]>,
    start: Mixture,
    frozen: usize,
    mass_penalty: f64,
    settings: &EmSettings,
) -> Result<EmFit, MixtureError> {
    settings.check()?;
    let start = Mixture::from_masses(start.weights, start.components)?;
    if start.is_empty() {
        return Err(MixtureError::NoComponents);
    }
    in_pool(settings.threads, || {
        let point_blocks = PointBlocks::new(points, weights, settings.threads != 1)?;
        let mass_penalty = mass_penalty * point_blocks.total_weight / points.len() as f64;
        EmState::new(&point_blocks, start, frozen, mass_penalty, settings)?.run()
    })?
}

#[cfg(test)]
mod tests {
    use super::{run, run_frozen};
    use crate::mixture::{
        Collapse, EmFit, EmSettings, Gaussian, InstructionSet, Mixture, MixtureError, StopReason,
    };
    use nalgebra::{Matrix3, Point3, Vector3};
    use proptest::prelude::*;

    fn exact_iterations(iterations: usize) -> EmSettings {
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
                let settings = EmSettings { regularisation_m2: 1e-15, ..exact_iterations(iterations) };
                let fit = run(&points, None, start_at(&points, k), &settings).expect("fits");
                prop_assert!(fit.mean_log_likelihood >= last - 1e-10);
                last = fit.mean_log_likelihood;
                let direct = points.iter().map(|p| fit.mixture.log_density(p).expect("density")).sum::<f64>()
                    / points.len() as f64;
                prop_assert!((direct - last).abs() < 1e-10, "{direct} {last}");
            }
        }

        #[test]
        fn translating_the_cloud_translates_the_mixture(points in cloud(100..300), k in 1usize..5) {
            let shift = Vector3::new(1e6, -1e6, 5e5);
            let far: Vec<_> = points.iter().map(|p| p + shift).collect();
            let here = run(&points, None, start_at(&points, k), &exact_iterations(10)).expect("fits");
            let there = run(&far, None, start_at(&far, k), &exact_iterations(10)).expect("fits");
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
            let fit = run(&points, None, start_at(&points, k), &exact_iterations(12)).expect("defined");
            prop_assert!(fit.mean_log_likelihood.is_finite());
            prop_assert!(Mixture::try_new(fit.mixture.weights, fit.mixture.components).is_ok());
        }
    }

    fn curve_points(n: usize) -> Vec<Point3<f64>> {
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
        let points = curve_points(20_000);
        let one = run(&points, None, start_at(&points, 12), &exact_iterations(5)).expect("fits");
        for threads in [0, 2, 3] {
            let settings = EmSettings {
                threads,
                ..exact_iterations(5)
            };
            let fit = run(&points, None, start_at(&points, 12), &settings).expect("fits");
            let expected = EmFit {
                threads: fit.threads,
                ..one.clone()
            };
            assert_eq!(fit, expected);
        }
    }

    #[test]
    fn all_instruction_sets_agree() {
        let (near, mut far) = (curve_points(5_000), curve_points(5_000));
        far.iter_mut()
            .for_each(|p| *p += Vector3::new(1e6, -1e6, 0.0));
        for points in [near, far] {
            let fit = |instructions| {
                let settings = EmSettings {
                    instructions,
                    ..exact_iterations(12)
                };
                run(&points, None, start_at(&points, 9), &settings).expect("fits")
            };
            let portable = fit(InstructionSet::Portable);
            for set in InstructionSet::ALL
                .into_iter()
                .filter(|set| set.available())
            {
                let got = fit(set);
                assert_eq!(got.instructions, set);
                assert!((got.mean_log_likelihood - portable.mean_log_likelihood).abs() < 1e-9);
                for k in 0..9 {
                    let (a, b) = (got.mixture.components[k], portable.mixture.components[k]);
                    let difference = got.mixture.weights[k] - portable.mixture.weights[k];
                    assert!(difference.abs() < 1e-9 && (a.mean - b.mean).norm() < 1e-9);
                    assert!((a.covariance - b.covariance).amax() < 1e-9);
                }
            }
        }
    }

    #[test]
    fn a_million_points_and_more_components_than_points_are_fitted() {
        let many = curve_points(1_000_000);
        let fit = run(&many, None, start_at(&many, 3), &exact_iterations(1)).expect("fits");
        assert!(fit.mean_log_likelihood.is_finite() && fit.collapsed.is_empty());
        let few = &many[..3];
        let fit = run(few, None, start_at(few, 10), &exact_iterations(5)).expect("fits");
        assert!(fit.mean_log_likelihood.is_finite());
        assert!(fit.mixture.weights.iter().all(|w| w.is_finite()));
    }

    #[test]
    fn weights_equal_repeated_points() {
        let points = curve_points(300);
        let weights: Vec<f64> = (0..300).map(|i| f64::from(i % 3)).collect();
        let repeated: Vec<_> = (0..300).flat_map(|i| vec![points[i]; i % 3]).collect();
        let start = start_at(&points, 4);
        let a = run(
            &points,
            Some(&weights),
            start.clone(),
            &exact_iterations(10),
        )
        .expect("fits");
        let b = run(&repeated, None, start, &exact_iterations(10)).expect("fits");
        assert!((a.mean_log_likelihood - b.mean_log_likelihood).abs() < 1e-11);
        for (x, y) in a.mixture.components.iter().zip(&b.mixture.components) {
            assert!((x.mean - y.mean).norm() < 1e-9 && (x.covariance - y.covariance).amax() < 1e-9);
        }
    }

    #[test]
    fn degenerate_clouds_give_finite_fits() {
        let p = Point3::new(1e6, -3.0, 2.0);
        assert_eq!(
            run(&[], None, start_at(&[p], 1), &exact_iterations(1)).expect_err("refused"),
            MixtureError::NoPoints
        );
        assert_eq!(
            run(&[p], None, Mixture::default(), &exact_iterations(1)).expect_err("refused"),
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
                let fit =
                    run(points, None, start_at(points, k), &exact_iterations(20)).expect("defined");
                assert!(fit.mean_log_likelihood.is_finite());
                let mixture = fit.mixture;
                Mixture::try_new(mixture.weights, mixture.components).expect("a sound mixture");
                assert!(!fit.collapsed.is_empty());
            }
            let bare = EmSettings {
                regularisation_m2: 0.0,
                ..exact_iterations(3)
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
                &exact_iterations(1)
            ),
            Err(MixtureError::PointNotFinite { index: 1 })
        ));
    }

    #[test]
    fn a_component_far_from_all_points_is_reported_as_collapsed() {
        let points = curve_points(500);
        let mut start = start_at(&points, 2);
        start.components[1].mean = Point3::new(500.0, 0.0, 0.0);
        let fit = run(&points, None, start, &exact_iterations(5)).expect("fits");
        assert_eq!(fit.mixture.weights, vec![1.0, 0.0]);
        assert_eq!(fit.collapsed, vec![(1, Collapse::NoMass)]);
        assert!((fit.mixture.components[1].mean.x - 500.0).abs() < 1e-9);
    }

    #[test]
    fn frozen_components_keep_their_shape_and_change_their_weight() {
        let points = curve_points(900);
        let start = start_at(&points, 3);
        let fit = run_frozen(&points, None, start.clone(), 2, &exact_iterations(8)).expect("fits");
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
    fn it_stops_when_converged_or_at_the_cap() {
        let points = curve_points(400);
        let settings = EmSettings {
            iterations: 1000,
            tolerance: 1e-6,
            ..EmSettings::default()
        };
        let fit = run(&points, None, start_at(&points, 2), &settings).expect("fits");
        assert_eq!(fit.stopped, StopReason::Converged);
        assert!(fit.iterations < 1000);
        let capped = run(&points, None, start_at(&points, 2), &exact_iterations(3)).expect("fits");
        assert_eq!(
            (capped.stopped, capped.iterations),
            (StopReason::IterationCap, 3)
        );
    }
}
