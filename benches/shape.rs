//! Time of method A by number of points: on one primitive or three among 30 % outliers, normals 5 deg wrong, with the
//! normals given and estimated, and on the inputs of other libraries' benchmarks (folder `PEERS_DATA`); and of the shape of one novelty by both methods.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use nalgebra::{Matrix3, Point3, Vector3};
use patrold_engine::mixture::{Gaussian, Mixture};
use patrold_engine::novelty::Surroundings;
use patrold_engine::shape::ransac::{RansacSettings, detect, estimate_normals, surface_samples};
use patrold_engine::shape::{ShapeSettings, detect_shapes, retrieve};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal, UnitSphere};
use std::path::PathBuf;

type OrientedCloud = (Vec<Point3<f64>>, Vec<Vector3<f64>>);

const EPSILON_M: f64 = 0.03;

fn gaussian(sigma: f64, rng: &mut ChaCha8Rng) -> Vector3<f64> {
    let n: [f64; 3] = std::array::from_fn(|_| StandardNormal.sample(rng));
    Vector3::from(n) * sigma
}

/// `n` points: 70 % on those of sphere (0), cylinder (1) and plate (2) that `primitives` lists, the rest outliers.
fn cloud(primitives: &[usize], n: usize, seed: u64) -> OrientedCloud {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let own = n * 7 / 10;
    let mut out: Vec<(Point3<f64>, Vector3<f64>)> = Vec::with_capacity(n);
    for i in 0..own {
        let u: [f64; 3] = UnitSphere.sample(&mut rng);
        let u = Vector3::from(u);
        let (a, b) = (rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0));
        let round = Vector3::new(u.x, u.y, 0.0).normalize();
        let (p, normal) = match primitives[i % primitives.len()] {
            0 => (Point3::new(3.0, 0.4, 0.2) + u * 0.5, u),
            1 => (Point3::new(3.0, -1.0, a) + round * 0.3, round),
            _ => (Point3::new(3.5, 1.5 + a, b), Vector3::x()),
        };
        let normal = (normal + gaussian(0.087, &mut rng)).normalize();
        out.push((p + gaussian(0.01, &mut rng), normal));
    }
    for _ in own..n {
        let u: [f64; 3] = UnitSphere.sample(&mut rng);
        let at = Vector3::from_fn(|_, _| rng.random_range(-1.4..1.4));
        out.push((Point3::new(3.2, 0.3, 0.0) + at, Vector3::from(u)));
    }
    out.into_iter().unzip()
}

/// Points and normals of a PLY file: x y z nx ny nz as little-endian f32, one byte of label.
fn cloud_from_file(name: &str) -> Option<OrientedCloud> {
    let folder = PathBuf::from(std::env::var_os("PEERS_DATA")?);
    let bytes = std::fs::read(folder.join(name)).ok()?;
    let head = b"end_header\n";
    let from = bytes.windows(head.len()).position(|w| w == head)? + head.len();
    let rows = bytes.get(from..)?.chunks_exact(25).map(|row| {
        let number = |i: usize| {
            let at = row.get(4 * i..4 * i + 4).and_then(|b| b.try_into().ok());
            f64::from(f32::from_le_bytes(at.unwrap_or_default()))
        };
        (
            Point3::new(number(0), number(1), number(2)),
            Vector3::new(number(3), number(4), number(5)),
        )
    });
    Some(rows.unzip())
}

fn settings(points: usize) -> ShapeSettings {
    ShapeSettings {
        ransac: Some(RansacSettings::with_defaults(points, EPSILON_M, usize::MAX)),
        ..ShapeSettings::default()
    }
}

fn many_primitives(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("primitives");
    group.sample_size(20);
    let mut clouds = Vec::new();
    for n in [1000, 10_000, 100_000] {
        for (name, primitives) in [
            ("sphere", &[0][..]),
            ("cylinder", &[1]),
            ("plate", &[2]),
            ("all", &[0, 1, 2]),
        ] {
            clouds.push((format!("{name}/{n}"), cloud(primitives, n, 1)));
        }
    }
    for kind in ["sphere", "cylinder", "plane", "mixed"] {
        let name = format!("shape_{kind}_100000.ply");
        clouds.extend(cloud_from_file(&name).map(|cloud| (format!("file/{kind}"), cloud)));
    }
    for (name, (points, normals)) in &clouds {
        let settings = settings(points.len());
        group.throughput(Throughput::Elements(points.len() as u64));
        group.bench_function(BenchmarkId::from_parameter(name), |bencher| {
            bencher.iter(|| detect_shapes(points, Some(normals), &Point3::origin(), &settings, 7));
        });
    }
    let (points, _) = cloud(&[0, 1, 2], 10_000, 1);
    group.bench_function("normals estimated/all/10000", |bencher| {
        bencher
            .iter(|| detect_shapes(&points, None, &Point3::origin(), &settings(points.len()), 7));
    });
    group.finish();
}

fn one_novelty(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("novelty");
    for n in [60, 100, 400] {
        let (points, _) = cloud(&[0], n * 10 / 7, 2);
        let points = points.get(..n).unwrap_or_default();
        let origin = Point3::origin();
        group.bench_function(BenchmarkId::new("normals", n), |bencher| {
            bencher.iter(|| estimate_normals(points, &origin, 12));
        });
        group.bench_function(BenchmarkId::new("both methods", n), |bencher| {
            let settings = ShapeSettings::default();
            let surroundings = Surroundings::default();
            bencher.iter(|| {
                retrieve(
                    points,
                    &surroundings,
                    &Mixture::default(),
                    &origin,
                    &settings,
                    1,
                )
            });
        });
    }
    let round = Mixture {
        weights: vec![0.5, 0.5],
        components: [0.0, 0.3]
            .map(|y| Gaussian {
                mean: Point3::new(3.0, y, 0.0),
                covariance: Matrix3::from_diagonal(&Vector3::new(0.002, 0.02, 0.03)),
            })
            .to_vec(),
    };
    group.bench_function("samples on ellipsoids/3722", |bencher| {
        bencher.iter(|| surface_samples(&round, 3722, 1.0, 3));
    });
    let (points, normals) = surface_samples(&round, 3722, 1.0, 3);
    group.bench_function("primitives of the samples/3722", |bencher| {
        let settings = RansacSettings::with_defaults(points.len(), EPSILON_M, 2);
        bencher.iter(|| detect(&points, &normals, &settings, 3));
    });
    group.finish();
}

criterion_group!(benches, many_primitives, one_novelty);
criterion_main!(benches);
