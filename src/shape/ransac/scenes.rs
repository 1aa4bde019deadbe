//! Mixed synthetic scenes with a known answer.

use super::{RansacSettings, detect, estimate_normals};
use crate::shape::primitive::Primitive;
use nalgebra::{Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal, UnitSphere};

/// A ball (r 0.5), a bar (r 0.3, length 2) and a plate (2 x 1.5), 3 mm of noise, and outliers.
fn mixed(each: usize, outlier_share: f64, seed: u64) -> (Vec<Point3<f64>>, Vec<Vector3<f64>>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut out: Vec<(Point3<f64>, Vector3<f64>)> = Vec::new();
    for _ in 0..each {
        let u = Vector3::from(<UnitSphere as Distribution<[f64; 3]>>::sample(
            &UnitSphere,
            &mut rng,
        ));
        out.push((Point3::new(0.0, 0.0, 0.5) + u * 0.5, u));
        let angle = rng.random_range(0.0..std::f64::consts::TAU);
        let n = Vector3::new(angle.cos(), angle.sin(), 0.0);
        let z = rng.random_range(0.0..2.0);
        out.push((Point3::new(2.0, 1.0, z) + n * 0.3, n));
        let (x, y) = (rng.random_range(-1.0..1.0), rng.random_range(-0.75..0.75));
        out.push((Point3::new(x, y, -1.0), Vector3::z()));
    }
    for (p, _) in &mut out {
        let noise: [f64; 3] = std::array::from_fn(|_| StandardNormal.sample(&mut rng));
        *p += Vector3::from(noise) * 0.003;
    }
    let outliers = (out.len() as f64 * outlier_share / (1.0 - outlier_share)) as usize;
    for _ in 0..outliers {
        let u = Vector3::from(<UnitSphere as Distribution<[f64; 3]>>::sample(
            &UnitSphere,
            &mut rng,
        ));
        let p = Point3::new(
            rng.random_range(-1.5..3.0),
            rng.random_range(-1.5..2.0),
            rng.random_range(-1.5..2.5),
        );
        out.push((p, u));
    }
    out.into_iter().unzip()
}

fn settings(min_points: usize) -> RansacSettings {
    RansacSettings {
        epsilon_m: 0.012,
        normal_angle_rad: 0.35,
        min_points,
        probability: 0.99,
        most: usize::MAX,
        cell_m: None,
    }
}

#[test]
fn three_primitives_are_found_among_a_third_of_outliers() {
    for seed in 0..10 {
        let (points, normals) = mixed(1000, 0.3, seed);
        let found = detect(&points, &normals, &settings(200), seed);
        assert_eq!(found.len(), 3, "seed {seed}: {found:?}");
        let mut taken = vec![0; points.len()];
        for d in &found {
            d.inliers.iter().for_each(|&i| taken[i] += 1);
            assert!(
                d.inliers.len() > 900,
                "{:?} {}",
                d.primitive,
                d.inliers.len()
            );
            match d.primitive {
                Primitive::Sphere(s) => {
                    assert!((s.radius_m - 0.5).abs() < 0.005, "{s:?}");
                    assert!((s.centre - Point3::new(0.0, 0.0, 0.5)).norm() < 0.005);
                }
                Primitive::Cylinder(c) => {
                    assert!((c.radius_m - 0.3).abs() < 0.003, "{c:?}");
                    assert!((c.length_m - 2.0).abs() < 0.05, "{c:?}");
                }
                Primitive::Plane(p) => {
                    assert!(p.normal().z.abs() > 0.9999);
                    assert!((p.sides_m[0] - 2.0).abs() < 0.1, "{p:?}");
                    assert!((p.sides_m[1] - 1.5).abs() < 0.1, "{p:?}");
                }
            }
        }
        assert!(taken.iter().all(|&t| t <= 1), "inliers are disjoint");
    }
}

#[test]
fn normals_of_the_points_themselves_do_as_well() {
    let (points, _) = mixed(1500, 0.1, 3);
    let normals = estimate_normals(&points, &Point3::new(-5.0, 0.0, 0.0), 12);
    let found = detect(&points, &normals, &settings(300), 3);
    let sphere = found.iter().find_map(|d| match d.primitive {
        Primitive::Sphere(s) => Some(s),
        _ => None,
    });
    let sphere = sphere.expect("the ball");
    assert!((sphere.radius_m / 0.5 - 1.0).abs() < 0.01, "{sphere:?}");
}

#[test]
fn same_seed_same_answer() {
    let (points, normals) = mixed(300, 0.3, 1);
    let once = detect(&points, &normals, &settings(60), 5);
    assert_eq!(once, detect(&points, &normals, &settings(60), 5));
}

#[test]
fn degenerate_clouds_end_without_nonsense() {
    let same = vec![Point3::new(1.0, 2.0, 3.0); 50];
    let line: Vec<_> = (0..50)
        .map(|i| Point3::new(f64::from(i), 0.0, 0.0))
        .collect();
    let far: Vec<_> = line
        .iter()
        .map(|p| p + Vector3::new(1e6, 1e6, 0.0))
        .collect();
    let bad = vec![Point3::new(f64::NAN, 0.0, 0.0); 50];
    for points in [&same[..], &line, &far, &bad, &[]] {
        let normals = vec![Vector3::z(); points.len()];
        for d in detect(points, &normals, &settings(10), 1) {
            assert!(d.primitive.size_m().iter().all(|v| v.is_finite()));
        }
    }
}

#[test]
fn a_large_cloud_is_searched_by_subsets() {
    let (points, normals) = mixed(25_000, 0.3, 2);
    let found = detect(&points, &normals, &settings(2000), 2);
    assert_eq!(found.len(), 3);
}
