//! Time of a verdict by stage and by size of the sweep: 20, 82 and 300 thousand beams, one thread and two, on simulated
//! sweeps of a shipped scene with a person in it.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use patrold_engine::geometry::View;
use patrold_engine::inspect::{EngineSettings, inspect, prepare};
use patrold_engine::novelty::{PreparedView, Reference, detect};
use patrold_sim::world::{
    MountGeometry, NoiseOptions, Pose2d, Scene, SimulatedRobot, SweepRows, simulate_sweep,
};
use std::time::Duration;

/// Lines of a sweep; each has 683 beams.
const LINES: [usize; 3] = [30, 120, 440];

fn simulated_view(name: &str, lines: usize, seed: u64, shift_m: f64) -> View {
    let folder = patrold_test_support::workspace_root().join("config/scenes");
    let load = |file: &str| std::fs::read_to_string(folder.join(file)).map_err(|e| e.to_string());
    let scene = Scene::resolve(name, &load).expect("a shipped scene");
    let world = scene.build(None).expect("no cloud in it");
    let mut robot = SimulatedRobot {
        map_from_base: scene.map_from_base,
        mount: MountGeometry::default(),
    };
    let waypoint = &scene.map_from_base;
    robot.drive_to(Pose2d {
        x_m: waypoint.translation.x + shift_m,
        y_m: waypoint.translation.y,
        yaw_rad: waypoint.rotation.euler_angles().2 + shift_m,
    });
    let rows = SweepRows::evenly(-35.0, 25.0, lines).starting_at(Duration::from_secs(seed));
    simulate_sweep(&world, &robot, &rows, &NoiseOptions::seeded(seed)).view
}

fn verdict(criterion: &mut Criterion) {
    let settings = EngineSettings::standard();
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("a pool");
        for lines in LINES {
            let reference = simulated_view("corridor.toml", lines, 1, 0.0);
            let current = simulated_view("corridor-person.toml", lines, 2, 0.03);
            let beams = (lines * 683) as u64;
            let prepared = pool
                .install(|| prepare(&reference, &settings, 7))
                .expect("enough points");
            let mut group = criterion.benchmark_group(format!("threads_{threads}"));
            group
                .sample_size(20)
                .throughput(Throughput::Elements(beams));
            group.bench_function(BenchmarkId::new("reference", beams), |b| {
                b.iter(|| pool.install(|| prepare(&reference, &settings, 7)));
            });
            group.bench_function(BenchmarkId::new("stored_reference", beams), |b| {
                b.iter(|| {
                    let gamma = prepared.gamma.clone();
                    pool.install(|| Reference::from_stored(&reference, gamma, &settings.novelty))
                });
            });
            group.bench_function(BenchmarkId::new("fit", beams), |b| {
                b.iter(|| {
                    pool.install(|| {
                        PreparedView::new(&current, "current", &settings.novelty.evidence)
                    })
                });
            });
            group.bench_function(BenchmarkId::new("without_shapes", beams), |b| {
                b.iter(|| {
                    pool.install(|| detect(&prepared, &current, &settings.novelty, 7, &mut |_| {}))
                });
            });
            group.bench_function(BenchmarkId::new("verdict", beams), |b| {
                b.iter(|| pool.install(|| inspect(&prepared, &current, &settings, 7, &mut |_| {})));
            });
        }
    }
}

criterion_group!(benches, verdict);
criterion_main!(benches);
