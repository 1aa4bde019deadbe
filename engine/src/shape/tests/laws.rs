//! Properties of every answer: it moves with the scene, is exact on perfect data, and is defined on degenerate input.

use super::scenes::{cast_ray, random_primitive, simulate_view};
use crate::geometry::{NoiseLaw, Pose};
use crate::mixture::{Gaussian, Mixture};
use crate::novelty::Surroundings;
use crate::shape::{
    BeamDensity, Class, Method, MethodChoice, Plane, Primitive, RansacSource, Retrieval,
    ShapeError, ShapeSettings, Sphere, retrieve,
};
use nalgebra::{Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::FRAC_PI_2;

fn retrieved(points: &[Point3<f64>], sensor: &Point3<f64>, settings: &ShapeSettings) -> Retrieval {
    retrieve(
        points,
        &Surroundings::default(),
        &Mixture::default(),
        sensor,
        settings,
        1,
    )
    .expect("a shape")
}

/// Standard settings for points with this noise.
fn with_noise(sigma_m: f64) -> ShapeSettings {
    ShapeSettings {
        noise: NoiseLaw {
            at_zero_m: sigma_m,
            per_m: 0.0,
        },
        ..ShapeSettings::default()
    }
}

fn assert_rotation(r: &Matrix3<f64>) {
    assert!(
        (r.transpose() * r - Matrix3::identity()).norm() < 1e-9,
        "{r}"
    );
    assert!((r.determinant() - 1.0).abs() < 1e-9, "{r}");
}

#[test]
fn primitives_are_recovered_from_dense_views_without_noise() {
    for class in 0..3 {
        for seed in 0..10 {
            let (truth, mut rng) = random_primitive(class, seed);
            let seen = simulate_view(&truth, &Point3::origin(), 3000, 0.0, &mut rng);
            let best = retrieved(&seen, &Point3::origin(), &with_noise(0.0)).best;
            assert_eq!(best.class, truth.class(), "{truth:?} {best:?}");
            for k in 0..3 {
                let error = (best.size_m[k] - truth.size_m()[k]).abs();
                assert!(error <= 0.03 * truth.size_m()[k], "{truth:?} {best:?}");
            }
            assert!(
                (best.centre - truth.centre()).norm() < 0.03,
                "{truth:?} {best:?}"
            );
            if class < 2 {
                assert!(best.residual_m < 0.01, "{best:?}");
            }
            let third = best
                .rotation
                .column(2)
                .dot(&truth.canonical_rotation(&Point3::origin()).column(2));
            assert!(class == 0 || third.abs() > 0.999, "{truth:?} {best:?}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(48)
    })]

    #[test]
    fn the_answer_moves_with_the_scene(
        class in 0usize..3,
        seed in 0u64..50,
        turn in prop::array::uniform3(-3.0f64..3.0),
        shift in prop::array::uniform3(-20.0f64..20.0),
    ) {
        let (truth, mut rng) = random_primitive(class, seed);
        let seen = simulate_view(&truth, &Point3::origin(), 200, 0.01, &mut rng);
        let pose = Pose::from_parts(
            Translation3::from(Vector3::from(shift)),
            UnitQuaternion::from_scaled_axis(Vector3::from(turn)),
        );
        let settings = with_noise(0.01);
        let here = retrieved(&seen, &Point3::origin(), &settings).best;
        let moved: Vec<_> = seen.iter().map(|p| pose * p).collect();
        let there = retrieved(&moved, &(pose * Point3::origin()), &settings).best;
        prop_assert_eq!(here.class, there.class);
        // The solver stops within a fraction of the stated uncertainty of its optimum.
        let slack = |sd: &[f64; 3]| 1e-3 + 0.5 * sd.iter().fold(0.0f64, |a, &b| a.max(b));
        let apart = (pose * here.centre - there.centre).norm();
        prop_assert!(apart < slack(&here.centre_sd_m), "{here:?} {there:?}");
        for k in 0..3 {
            let apart = (here.size_m[k] - there.size_m[k]).abs();
            prop_assert!(apart < slack(&here.size_sd_m), "{here:?} {there:?}");
        }
        assert_rotation(&there.rotation);
        if class > 0 {
            let third = pose.rotation * here.rotation.column(2);
            prop_assert!(third.dot(&there.rotation.column(2)).abs() > 0.9999);
        }
    }

    #[test]
    fn finite_points_give_finite_answers_or_an_error(
        points in prop::collection::vec(prop::array::uniform3(-2.0f64..2.0), 0..40),
        sensor in prop::array::uniform3(-3.0f64..3.0),
        flat in any::<bool>(),
    ) {
        let points: Vec<_> = points
            .into_iter()
            .map(|[x, y, z]| Point3::new(x, y, if flat { 0.5 } else { z }))
            .collect();
        let sensor = Point3::from(sensor);
        if let Ok(found) = retrieve(&points, &Surroundings::default(), &Mixture::default(), &sensor, &with_noise(0.01), 3) {
            for shape in [Some(&found.best), found.covariance.as_ref(), found.ransac.as_ref()]
                .into_iter()
                .flatten()
                .chain(&found.parts)
            {
                let numbers = shape.size_m.iter().chain(&shape.size_sd_m).chain(&shape.centre_sd_m);
                prop_assert!(numbers.chain(shape.centre.iter()).all(|v| v.is_finite()));
                prop_assert!(shape.probability.is_finite() && shape.residual_m.is_finite());
                assert_rotation(&shape.rotation);
            }
        }
    }
}

#[test]
fn a_few_points_of_a_far_wall_change_nothing() {
    for class in 0..3 {
        for seed in 0..10 {
            let (truth, mut rng) = random_primitive(class, seed);
            let seen = simulate_view(&truth, &Point3::origin(), 90, 0.01, &mut rng);
            let settings = with_noise(0.01);
            let alone = retrieved(&seen, &Point3::origin(), &settings).best;
            let behind = [[2.2, 0.3, 0.1], [1.6, -1.1, 0.4]].map(Vector3::from);
            let outliers = behind.map(|v| truth.centre() + v);
            let both = retrieved(
                &[&seen[..], &outliers].concat(),
                &Point3::origin(),
                &settings,
            )
            .best;
            assert_eq!(both, alone, "{truth:?}");
        }
    }
}

#[test]
fn same_input_same_answer_and_another_input_another() {
    let settings = with_noise(0.01);
    let answers: Vec<Retrieval> = (0..3)
        .map(|class| {
            let (truth, mut rng) = random_primitive(class, 4);
            let seen = simulate_view(&truth, &Point3::origin(), 150, 0.01, &mut rng);
            let once = retrieved(&seen, &Point3::origin(), &settings);
            assert_eq!(once, retrieved(&seen, &Point3::origin(), &settings));
            assert_eq!(once.best.class, truth.class());
            let off = (once.best.centre - truth.centre()).norm();
            assert!(off < 0.1, "{off} {truth:?}");
            once
        })
        .collect();
    assert_ne!(answers[0], answers[1]);
    assert_ne!(answers[1], answers[2]);
}

#[test]
fn degenerate_input_has_typed_errors() {
    let origin = Point3::origin();
    let error = |points: &[Point3<f64>]| {
        let settings = ShapeSettings::default();
        retrieve(
            points,
            &Surroundings::default(),
            &Mixture::default(),
            &origin,
            &settings,
            0,
        )
        .expect_err("no shape")
    };
    let few = vec![Point3::new(1.0, 0.0, 0.0); 3];
    assert_eq!(error(&few), ShapeError::TooFewPoints { got: 3, min: 10 });
    let same = vec![Point3::new(1.0, 2.0, 3.0); 50];
    assert!(matches!(error(&same), ShapeError::NoSurface { .. }));
    let line: Vec<_> = (0..50)
        .map(|i| Point3::new(2.0, f64::from(i) * 0.02, 0.0))
        .collect();
    assert!(matches!(error(&line), ShapeError::NoSurface { .. }));
    let mut bad = line;
    bad[7].y = f64::NAN;
    assert!(matches!(error(&bad), ShapeError::NotFinite { .. }));
}

#[test]
fn a_shape_is_found_a_thousand_kilometres_from_the_origin() {
    let (truth, mut rng) = random_primitive(0, 5);
    let seen = simulate_view(&truth, &Point3::origin(), 150, 0.005, &mut rng);
    let away = Vector3::new(1e6, -1e6, 1e3);
    let moved: Vec<_> = seen.iter().map(|p| p + away).collect();
    let best = retrieved(&moved, &Point3::from(away), &with_noise(0.005)).best;
    assert_eq!(best.class, Class::Sphere);
    assert!((best.size_m[0] - truth.size_m()[0]).abs() < 0.03);
}

#[test]
fn a_sphere_around_the_sensor_is_matched_as_a_whole_surface() {
    let ball = Sphere {
        centre: Point3::new(0.05, 0.0, 0.0),
        radius_m: 0.4,
    };
    let mixture = Mixture {
        weights: vec![1.0],
        components: vec![Gaussian {
            mean: ball.centre,
            covariance: Matrix3::identity() * (0.16 / 3.0),
        }],
    };
    let (points, _) = crate::shape::ransac::surface_samples(&mixture, 800, 3f64.sqrt(), 2);
    let best = retrieved(&points, &Point3::origin(), &with_noise(0.005)).best;
    assert_eq!(best.class, Class::Sphere, "{best:?}");
    assert!((best.size_m[0] - 0.8).abs() < 0.02, "{best:?}");
}

#[test]
fn ransac_on_the_ellipsoid_of_a_round_gaussian_finds_a_sphere() {
    let components = vec![Gaussian {
        mean: Point3::new(3.0, 0.0, 0.0),
        covariance: Matrix3::identity() * 0.03,
    }];
    let mixture = Mixture {
        weights: vec![1.0],
        components,
    };
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let ball = Primitive::Sphere(Sphere {
        centre: Point3::new(3.0, 0.0, 0.0),
        radius_m: 0.3,
    });
    let seen = simulate_view(&ball, &Point3::origin(), 100, 0.01, &mut rng);
    let settings = ShapeSettings {
        choice: MethodChoice::Ransac,
        ransac_source: RansacSource::Ellipsoids {
            samples: 3722,
            scale: 3f64.sqrt(),
        },
        ..with_noise(0.01)
    };
    let best = retrieve(
        &seen,
        &Surroundings::default(),
        &mixture,
        &Point3::origin(),
        &settings,
        1,
    )
    .expect("a shape")
    .best;
    assert_eq!((best.class, best.method), (Class::Sphere, Method::Ransac));
    assert!((best.size_m[0] - 0.6).abs() < 0.01, "{best:?}");
    let paper = retrieve(
        &seen,
        &Surroundings::default(),
        &mixture,
        &Point3::origin(),
        &ShapeSettings::paper_independent(),
        1,
    )
    .expect("a shape");
    let covariance = paper.covariance.expect("method B ran");
    assert_eq!(covariance.class, Class::Sphere, "{covariance:?}");
    // A whole sphere of variance .03 per axis, less the noise: r = sqrt(3 * .03).
    assert!((covariance.size_m[0] - 0.6).abs() < 0.02, "{covariance:?}");
}

#[test]
fn an_object_of_two_primitives_is_split_into_parts() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let (cylinder, _) = random_primitive(1, 2);
    let ball = Primitive::Sphere(Sphere {
        centre: cylinder.centre() + Vector3::new(0.0, 0.75, -0.2),
        radius_m: 0.35,
    });
    let mut seen = simulate_view(&cylinder, &Point3::origin(), 600, 0.005, &mut rng);
    seen.extend(simulate_view(
        &ball,
        &Point3::origin(),
        600,
        0.005,
        &mut rng,
    ));
    let found = retrieved(&seen, &Point3::origin(), &with_noise(0.005));
    let classes: Vec<_> = found.parts.iter().map(|p| p.class).collect();
    assert!(classes.contains(&Class::Sphere), "{found:?}");
    assert!(classes.contains(&Class::Cylinder), "{found:?}");
    let total: usize = found.parts.iter().map(|p| p.inliers).sum();
    assert!(total <= seen.len());
    let sphere = found.parts.iter().find(|p| p.class == Class::Sphere);
    assert!(
        sphere.is_some_and(|s| (s.size_m[0] - 0.7).abs() < 0.02),
        "{found:?}"
    );
}

#[test]
fn the_density_of_the_sweep_changes_the_moments() {
    // A wide plate far to the left of a tilt sweep: rows crowd towards the tilt axis.
    let plate = Plane {
        centre: Point3::new(1.2, 1.3, 0.0),
        rotation: Rotation3::from_axis_angle(&Vector3::x_axis(), FRAC_PI_2),
        sides_m: [1.4, 0.8],
    };
    let truth = Primitive::Plane(plate);
    let mut seen = Vec::new();
    for row in -60..=60 {
        for column in 0..120 {
            let (tilt, azimuth) = (f64::from(row) * 0.015, 0.4 + f64::from(column) * 0.01);
            let (x, y) = (azimuth.cos(), azimuth.sin());
            let d = Vector3::new(x * tilt.cos(), y, x * tilt.sin());
            seen.extend(cast_ray(&truth, &Point3::origin(), &d).map(|t| Point3::from(d * t)));
        }
    }
    let error = |density| {
        let settings = ShapeSettings {
            density,
            use_point_distances: false,
            ..with_noise(0.001)
        };
        let best = retrieved(&seen, &Point3::origin(), &settings).best;
        assert_eq!(best.class, Class::Plane);
        (best.size_m[0] - 1.4).abs() + (best.size_m[1] - 0.8).abs()
    };
    let axis = Vector3::y_axis();
    let (sweep, plain) = (
        error(BeamDensity::TiltSweep { axis }),
        error(BeamDensity::SolidAngle),
    );
    assert!(sweep < 0.02, "{sweep}");
    assert!(plain > 2.0 * sweep, "{plain} against {sweep}");
}
