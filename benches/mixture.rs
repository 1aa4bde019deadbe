//! Times of EM and splitting by number of points and components, on one thread and two; and of EM on inputs of other
//! libraries' benchmarks (folder `PEERS_DATA`), for comparison.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use nalgebra::{Matrix3, Point3, Vector3};
use patrold_engine::formats::read_cloud;
use patrold_engine::geometry::voxel_downsample;
use patrold_engine::mixture::{
    ComponentSelection, EmSettings, FitSettings, Gaussian, InstructionSet, Mixture, MixtureRecord,
    SplitSettings, em, fit, kmeans, split_until_flat,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::path::{Path, PathBuf};

const SIZES: [usize; 3] = [20_000, 82_000, 300_000];

fn exact_iterations(iterations: usize, threads: usize) -> EmSettings {
    EmSettings {
        iterations,
        tolerance: 0.0,
        threads,
        ..EmSettings::default()
    }
}

/// `n` points around `k` centres in a box of 6 m, and a start at the centres.
fn clusters(n: usize, k: usize) -> (Vec<Point3<f64>>, Mixture) {
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

fn ascent(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("em_ten_iterations");
    group.sample_size(10);
    for (n, k) in SIZES.map(|n| (n, 30)).into_iter().chain([(82_000, 120)]) {
        let (points, start) = clusters(n, k);
        group.throughput(Throughput::Elements((n * k * 10) as u64));
        for threads in [1, 2] {
            group.bench_function(
                BenchmarkId::new(format!("threads{threads}"), format!("n{n}_k{k}")),
                |b| {
                    b.iter(|| {
                        em::run(&points, None, start.clone(), &exact_iterations(10, threads))
                    });
                },
            );
        }
    }
    let (points, start) = clusters(82_000, 30);
    for instructions in InstructionSet::ALL
        .into_iter()
        .filter(|set| set.available())
    {
        let settings = EmSettings {
            instructions,
            ..exact_iterations(10, 1)
        };
        group.bench_function(BenchmarkId::new(instructions.name(), "n82000_k30"), |b| {
            b.iter(|| em::run(&points, None, start.clone(), &settings));
        });
    }
    group.finish();
}

/// Arranging the points with one pass, k-means++, and the choice of the number of components.
fn stages(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("fit_stages");
    group.sample_size(10);
    for n in SIZES {
        let (points, start) = clusters(n, 30);
        for threads in [1, 2] {
            group.bench_function(
                BenchmarkId::new(format!("one_pass_threads{threads}"), n),
                |b| {
                    b.iter(|| em::run(&points, None, start.clone(), &exact_iterations(0, threads)));
                },
            );
        }
        group.bench_function(BenchmarkId::new("k_means", n), |b| {
            b.iter(|| kmeans::k_means_start(&points, None, 30, 7, 0));
        });
    }
    let (points, _) = clusters(20_000, 8);
    for (name, components) in [
        ("bic", ComponentSelection::Bic { max: 12 }),
        ("mml", ComponentSelection::Mml { max: 12 }),
    ] {
        let settings = FitSettings {
            components,
            ..FitSettings::default()
        };
        group.bench_function(BenchmarkId::new(name, 20_000), |b| {
            b.iter(|| fit(&points, None, &settings))
        });
    }
    group.finish();
}

fn split(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("thin_and_split");
    group.sample_size(20);
    for n in SIZES {
        let points = room(n);
        group.bench_function(BenchmarkId::from_parameter(n), |b| {
            b.iter(|| {
                let thinned = voxel_downsample(&points, 0.06);
                split_until_flat(&thinned.points, None, &SplitSettings::default())
            });
        });
    }
    group.finish();
}

/// A cloud and a start from `PEERS_DATA`; `None` if missing.
fn peer_input(folder: &Path, n: usize, k: usize) -> Option<(Vec<Point3<f64>>, Mixture)> {
    let bytes = std::fs::read(folder.join(format!("room_a_{n}.ply"))).ok()?;
    let start = std::fs::read_to_string(folder.join(format!("init_{n}_{k}.json"))).ok()?;
    let points = read_cloud(&bytes, Some("ply")).ok()?.points;
    Some((points, MixtureRecord::parse(&start).ok()?))
}

fn peers(criterion: &mut Criterion) {
    let Some(folder) = std::env::var_os("PEERS_DATA").map(PathBuf::from) else {
        eprintln!("em_on_peers_inputs is left out: PEERS_DATA names no folder");
        return;
    };
    let mut group = criterion.benchmark_group("em_on_peers_inputs_twelve_iterations");
    group.sample_size(10);
    for (n, k) in [
        (20_000, 30),
        (100_000, 10),
        (100_000, 30),
        (100_000, 100),
        (500_000, 30),
    ] {
        let Some((points, start)) = peer_input(&folder, n, k) else {
            eprintln!("n = {n}, k = {k} is left out: not in {}", folder.display());
            continue;
        };
        for threads in [1, 2] {
            group.bench_function(
                BenchmarkId::new(format!("threads{threads}"), format!("n{n}_k{k}")),
                |b| {
                    b.iter(|| {
                        em::run(&points, None, start.clone(), &exact_iterations(12, threads))
                    });
                },
            );
        }
    }
    group.finish();
}

criterion_group!(benches, ascent, stages, split, peers);
criterion_main!(benches);
