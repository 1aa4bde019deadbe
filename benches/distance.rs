//! Times of ground distances and exact transport by number of components, on one thread and two; and of the transport on
//! inputs of other libraries' benchmarks (folder `PEERS_DATA`), for comparison.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use nalgebra::{Matrix3, Point3};
use patrold_engine::distance::{GroundDistance, cost_matrix, emd_of_costs};
use patrold_engine::mixture::{Gaussian, Mixture, MixtureRecord};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::path::PathBuf;

fn mixture(k: usize, seed: u64) -> Mixture {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut uniform = || rng.random::<f64>() - 0.5;
    let mut masses = Vec::with_capacity(k);
    let mut components = Vec::with_capacity(k);
    for _ in 0..k {
        masses.push(uniform() + 0.6);
        let root = Matrix3::from_fn(|_, _| uniform());
        let mean = Point3::new(uniform() * 6.0, uniform() * 5.0, uniform() * 2.5);
        components.push(Gaussian {
            mean,
            covariance: root * root.transpose(),
        });
    }
    let total: f64 = masses.iter().sum();
    Mixture {
        weights: masses.iter().map(|m| m / total).collect(),
        components,
    }
}

fn distance(criterion: &mut Criterion) {
    for k in [10, 30, 100, 300, 1000] {
        let (a, b) = (mixture(k, 1), mixture(k, 2));
        let mut group = criterion.benchmark_group("ground");
        group.sample_size(10);
        for (name, ground) in [
            ("w2", GroundDistance::W2),
            ("euclid", GroundDistance::Euclid),
            ("fm", GroundDistance::Fm),
        ] {
            for threads in [1, 2] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
                let pool = pool.expect("threads");
                let id = BenchmarkId::new(format!("{name}_threads{threads}"), k);
                group.bench_function(id, |bench| {
                    bench.iter(|| pool.install(|| cost_matrix(&a, &b, ground)));
                });
            }
        }
        group.finish();
        let mut group = criterion.benchmark_group("transport");
        group.sample_size(10);
        let costs = cost_matrix(&a, &b, GroundDistance::W2);
        group.bench_function(BenchmarkId::from_parameter(k), |bench| {
            bench.iter(|| emd_of_costs(&a.weights, &b.weights, &costs));
        });
        group.finish();
    }
}

fn peers(criterion: &mut Criterion) {
    let Some(folder) = std::env::var_os("PEERS_DATA").map(PathBuf::from) else {
        eprintln!("transport_on_peers_inputs is left out: PEERS_DATA names no folder");
        return;
    };
    let mut group = criterion.benchmark_group("transport_on_peers_inputs");
    for n in [10, 30, 100, 300, 1000] {
        let read = |side: &str| {
            let path = folder.join(format!("mixture_{side}_{n}.json"));
            MixtureRecord::parse(&std::fs::read_to_string(path).ok()?).ok()
        };
        let (Some(a), Some(b)) = (read("a"), read("b")) else {
            eprintln!("n = {n} is left out: not in {}", folder.display());
            continue;
        };
        let costs = cost_matrix(&a, &b, GroundDistance::W2);
        group.bench_function(BenchmarkId::from_parameter(n), |bench| {
            bench.iter(|| emd_of_costs(&a.weights, &b.weights, &costs));
        });
    }
    group.finish();
}

criterion_group!(benches, distance, peers);
criterion_main!(benches);
