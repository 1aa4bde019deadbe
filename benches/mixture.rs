//! How EM and splitting grow with points and components.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use nalgebra::{Matrix3, Point3, Vector3};
use patrold::geometry::thin;
use patrold::mixture::{EmSettings, Gaussian, Mixture, SplitSettings, em, split_until_flat};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// `n` points around `k` centres in a box of 6 m, and a start at the centres.
fn heaps(n: usize, k: usize) -> (Vec<Point3<f64>>, Mixture) {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut uniform = |scale: f64| Vector3::from_fn(|_, _| (rng.random::<f64>() - 0.5) * scale);
    let centres: Vec<Point3<f64>> = (0..k).map(|_| Point3::from(uniform(6.0))).collect();
    let points = (0..n)
        .map(|i| centres[i % k] + uniform(1.0) + uniform(1.0))
        .collect();
    let covariance = Matrix3::identity() * 0.25;
    let components = centres
        .iter()
        .map(|&mean| Gaussian { mean, covariance })
        .collect();
    (
        points,
        Mixture {
            weights: vec![1.0 / k as f64; k],
            components,
        },
    )
}

/// The walls, floor and ceiling of a room of 6 m by 5 m by 2.5 m, with 1 cm of roughness.
fn room(n: usize) -> Vec<Point3<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let size = [6.0, 5.0, 2.5];
    let mut point = |i: usize| {
        let mut unit = [0.0; 3].map(|_: f64| rng.random::<f64>());
        unit[i % 3] = if i.is_multiple_of(2) { 0.0 } else { 1.0 };
        let mut p = Point3::new(unit[0] * size[0], unit[1] * size[1], unit[2] * size[2]);
        p[i % 3] += (rng.random::<f64>() - 0.5) * 0.02;
        p
    };
    (0..n).map(&mut point).collect()
}

fn fit(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("em_ten_iterations");
    group.sample_size(10);
    for (n, k) in [(20_000, 30), (100_000, 30), (300_000, 30), (100_000, 120)] {
        let (points, start) = heaps(n, k);
        let settings = EmSettings {
            iterations: 10,
            tolerance: 0.0,
            ..EmSettings::default()
        };
        group.throughput(Throughput::Elements((n * k * 10) as u64));
        group.bench_function(BenchmarkId::from_parameter(format!("n{n}_k{k}")), |b| {
            b.iter(|| em::run(&points, None, start.clone(), &settings));
        });
    }
    group.finish();
}

fn split(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("thin_and_split");
    group.sample_size(20);
    for n in [20_000, 80_000, 300_000] {
        let points = room(n);
        group.bench_function(BenchmarkId::from_parameter(n), |b| {
            b.iter(|| {
                let thinned = thin(&points, 0.06);
                split_until_flat(&thinned.points, None, &SplitSettings::default())
            });
        });
    }
    group.finish();
}

criterion_group!(benches, fit, split);
criterion_main!(benches);
