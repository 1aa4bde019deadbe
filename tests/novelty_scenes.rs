//! The engine in small analytic rooms: rays against boxes and balls, with known noise and changes.

use nalgebra::{Point3, Unit, Vector3};
use patrold::geometry::{NoiseLaw, Pose, RollPitchYaw, View};
use patrold::novelty::{
    Detection, Kind, Model, Reference, Segmentation, Settings, Verdict, detect,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// A solid in the room.
#[derive(Clone, Copy)]
enum Solid {
    /// Centre, radius.
    Ball([f64; 3], f64),
    /// Lowest and highest corner.
    Block([f64; 3], [f64; 3]),
}

/// How a sensor looks around.
#[derive(Clone, Copy, Debug)]
enum Pattern {
    /// URG-04LX on a tilt unit: 683 beams over 240 deg, lines this many degrees apart.
    Tilted(f64),
    /// 16 rings 2 deg apart, 0.4 deg along.
    Rings,
    /// A narrow camera-like grid of 57 x 43 deg.
    Camera,
    /// 400 directions all around, none of them twice.
    Sparse,
}

struct Scene {
    room: ([f64; 3], [f64; 3]),
    solids: Vec<Solid>,
}

/// 6 m x 4.4 m x 2.6 m, sensor at the origin half a metre above the floor, some furniture.
fn room() -> Scene {
    Scene {
        room: ([-2.5, -2.0, -0.5], [3.5, 2.4, 2.1]),
        solids: vec![
            Solid::Block([1.5, 1.6, -0.5], [2.7, 2.4, 1.4]),
            Solid::Block([2.6, -2.0, -0.5], [3.5, -1.1, 0.3]),
            Solid::Ball([-1.5, -1.3, -0.1], 0.4),
        ],
    }
}

impl Scene {
    fn with(mut self, solid: Solid) -> Self {
        self.solids.push(solid);
        self
    }

    fn range(&self, o: &Point3<f64>, d: &Vector3<f64>) -> f64 {
        let slab = |low: &[f64; 3], high: &[f64; 3]| {
            let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
            for axis in 0..3 {
                let (a, b) = (
                    (low[axis] - o[axis]) / d[axis],
                    (high[axis] - o[axis]) / d[axis],
                );
                near = near.max(a.min(b));
                far = far.min(a.max(b));
            }
            (near, far)
        };
        let mut range = slab(&self.room.0, &self.room.1).1;
        for solid in &self.solids {
            match solid {
                Solid::Block(low, high) => {
                    let (near, far) = slab(low, high);
                    if near < far && near > 0.0 {
                        range = range.min(near);
                    }
                }
                Solid::Ball(centre, radius) => {
                    let to = Point3::from(*centre) - o;
                    let along = to.dot(d);
                    let off2 = to.norm_squared() - along * along;
                    if off2 < radius * radius && along > 0.0 {
                        range = range.min(along - (radius * radius - off2).sqrt());
                    }
                }
            }
        }
        range
    }

    /// What a sensor standing at `pose` sees, in its own frame.
    fn look(
        &self,
        pattern: Pattern,
        pose: &Pose,
        noise: NoiseLaw,
        reach_m: f64,
        seed: u64,
    ) -> View {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut view = View::bare(Vec::new(), Point3::origin());
        for d in directions(pattern, &mut rng) {
            let r = self.range(&(pose * Point3::origin()), &(pose * d));
            let gauss: f64 = StandardNormal.sample(&mut rng);
            let flicker = rng.random_range(0.0..1.0) < 0.03;
            if r > reach_m || flicker {
                if reach_m.is_finite() {
                    view.no_return.push(Unit::new_normalize(d));
                }
                continue;
            }
            view.points
                .push(Point3::from(d * (r + gauss * noise.sigma_m(r))));
        }
        if reach_m.is_finite() {
            view.free_range_m = 0.9 * reach_m;
        }
        view
    }
}

fn directions(pattern: Pattern, rng: &mut ChaCha8Rng) -> Vec<Vector3<f64>> {
    let mut all = Vec::new();
    // No two sweeps start at quite the same angle.
    let (a, b): (f64, f64) = (rng.random_range(0.0..1.0), rng.random_range(0.0..1.0));
    let from = |az: f64, el: f64| {
        let (az, el) = (az.to_radians(), el.to_radians());
        Vector3::new(el.cos() * az.cos(), el.cos() * az.sin(), el.sin())
    };
    match pattern {
        Pattern::Tilted(pitch) => {
            let lines = (70.0 / pitch) as i32;
            for line in 0..lines {
                let tilt = (-35.0 + (f64::from(line) + a) * pitch).to_radians();
                for beam in 0..683 {
                    let d = from(-120.0 + f64::from(beam) * 0.3515, 0.0);
                    all.push(Vector3::new(d.x * tilt.cos(), d.y, d.x * tilt.sin()));
                }
            }
        }
        Pattern::Rings => {
            for ring in -8..8 {
                for step in 0..900 {
                    all.push(from(
                        (f64::from(step) + a) * 0.4,
                        f64::from(ring) * 2.0 + 1.0,
                    ));
                }
            }
        }
        Pattern::Camera => {
            for u in 0..160 {
                for v in 0..120 {
                    all.push(
                        Vector3::new(
                            1.0,
                            (f64::from(u) + a - 80.0) / 80.0 * 0.543,
                            (f64::from(v) + b - 60.0) / 60.0 * 0.394,
                        )
                        .normalize(),
                    );
                }
            }
        }
        Pattern::Sparse => {
            for i in 0..400 {
                let z = 1.0 - 2.0 * (f64::from(i) + a) / 400.0;
                let az = f64::from(i) * 2.399_963 + b;
                let r = (1.0 - z * z).max(0.0).sqrt();
                all.push(Vector3::new(r * az.cos(), r * az.sin(), z));
            }
        }
    }
    all
}

const URG: NoiseLaw = NoiseLaw {
    at_zero_m: 0.005,
    per_m: 0.003,
};
const COARSE: NoiseLaw = NoiseLaw {
    at_zero_m: 0.03,
    per_m: 0.0,
};

fn here() -> Pose {
    Pose::identity()
}

fn off(x: f64, y: f64, yaw_deg: f64) -> Pose {
    RollPitchYaw {
        roll_rad: 0.0,
        pitch_rad: 0.0,
        yaw_rad: yaw_deg.to_radians(),
    }
    .with_translation([x, y, 0.0])
}

fn compare(reference: &View, current: &View) -> Detection {
    let settings = Settings::default();
    let reference = Reference::prepare(reference, &settings, 1).expect("a reference");
    let found = detect(&reference, current, &settings, 1, &mut |_| {}).expect("a detection");
    eprintln!(
        "    {:?} {} | t {:.3} rot {:.2} share {:.2} {:?} overlap {:.2?} noise {:?}",
        found.verdict,
        found.reason,
        found
            .registration
            .current_from_reference
            .translation
            .vector
            .norm(),
        found
            .registration
            .current_from_reference
            .rotation
            .angle()
            .to_degrees(),
        found.registration.share,
        found.registration.unobservable,
        found.overlap,
        found.noise[1]
    );
    for n in &found.novelties {
        eprintln!(
            "        {:?} n {} support {:.0} mass {:.5} contribution {:.5} moved {:?} at {:.2?} extent {:.2?}",
            n.kind,
            n.points.len(),
            n.support,
            n.mass,
            n.contribution,
            n.moved_from,
            n.moments.mean.coords.as_slice(),
            n.extent_m
        );
    }
    let parts: f64 = found.novelties.iter().map(|n| n.contribution).sum();
    assert!((parts + found.unexplained - found.d_gmm).abs() < 1e-9);
    found
}

fn patterns() -> [(Pattern, NoiseLaw, f64); 6] {
    [
        (Pattern::Tilted(0.5), URG, f64::INFINITY),
        (Pattern::Tilted(1.0), URG, f64::INFINITY),
        (Pattern::Tilted(1.0), URG, 2.6),
        (Pattern::Rings, URG, f64::INFINITY),
        (Pattern::Camera, URG, f64::INFINITY),
        (Pattern::Sparse, COARSE, f64::INFINITY),
    ]
}

#[test]
fn rooms_without_change_are_quiet() {
    for (pattern, noise, reach) in patterns() {
        let reference = room().look(pattern, &here(), noise, reach, 1);
        for seed in 2..5 {
            for pose in [here(), off(0.05, -0.03, 2.0), off(-0.15, 0.1, -6.0)] {
                eprintln!(
                    "{pattern:?} reach {reach} seed {seed} {:.2}",
                    pose.translation.vector.norm()
                );
                let current = room().look(pattern, &pose, noise, reach, seed);
                let found = compare(&reference, &current);
                assert!(found.novelties.is_empty());
                assert_eq!(found.verdict, Verdict::Quiet);
                assert!(found.d_gmm < 2e-4);
            }
        }
    }
}

#[test]
fn a_ball_that_came_is_found_and_its_shadow_is_no_novelty() {
    for (pattern, noise, reach) in patterns() {
        // 400 directions hit only what is large.
        let (radius, z) = if matches!(pattern, Pattern::Sparse) {
            (0.9, 0.5)
        } else {
            (0.25, -0.25)
        };
        let place = Point3::new(2.2, 0.2, z);
        let ball = Solid::Ball([place.x, place.y, place.z], radius);
        let reference = room().look(pattern, &here(), noise, reach, 1);
        for (seed, pose) in [
            (2, here()),
            (3, off(0.05, 0.04, 3.0)),
            (4, off(-0.08, 0.05, -5.0)),
        ] {
            eprintln!("{pattern:?} reach {reach} seed {seed}");
            let current = room().with(ball).look(pattern, &pose, noise, reach, seed);
            let found = compare(&reference, &current);
            assert_eq!(found.verdict, Verdict::Changed);
            assert_eq!(found.novelties.len(), 1);
            let centre = pose.inverse() * place;
            assert_eq!(found.novelties[0].kind, Kind::Appeared);
            assert!((found.novelties[0].moments.mean - centre).norm() < radius + 0.1);
            // And the other way round it went.
            let reference = current;
            let current = room().look(pattern, &here(), noise, reach, seed + 10);
            let found = compare(&reference, &current);
            assert_eq!(found.verdict, Verdict::Changed);
            assert_eq!(found.novelties.len(), 1);
            assert_eq!(found.novelties[0].kind, Kind::Disappeared);
        }
    }
}

#[test]
fn a_range_limit_ends_what_is_judged_and_not_what_was_looked_through() {
    let hall = || Scene {
        room: ([-1.5, -2.0, -0.5], [6.0, 2.0, 2.1]),
        solids: vec![Solid::Block([1.5, 1.6, -0.5], [2.7, 2.0, 1.4])],
    };
    let person = Solid::Block([3.2, -0.2, -0.5], [3.4, 0.2, 1.2]);
    let settings = Settings {
        max_range_m: Some(4.0),
        ..Settings::default()
    };
    let noise = NoiseLaw {
        at_zero_m: 0.003,
        per_m: 0.001,
    };
    let sees = |scene: Scene, pose: &Pose, seed: u64| {
        scene.look(Pattern::Tilted(0.65), pose, noise, f64::INFINITY, seed)
    };
    let reference = sees(hall(), &here(), 1);
    let prepared = Reference::prepare(&reference, &settings, 1).expect("a reference");
    let pose = off(0.05, -0.03, 2.0);
    let quiet = sees(hall(), &pose, 2);
    let found = detect(&prepared, &quiet, &settings, 1, &mut |_| {}).expect("a detection");
    assert_eq!(found.verdict, Verdict::Quiet, "{}", found.reason);
    assert!(found.novelties.is_empty());
    let current = sees(hall().with(person), &pose, 3);
    let found = detect(&prepared, &current, &settings, 1, &mut |_| {}).expect("a detection");
    assert_eq!(found.verdict, Verdict::Changed, "{}", found.reason);
    let [novelty] = &found.novelties[..] else {
        panic!("{} novelties", found.novelties.len());
    };
    assert_eq!(novelty.kind, Kind::Appeared);
    for (i, place) in novelty.points.iter().zip(&novelty.places) {
        assert!((current.points[*i] - place).norm() < 1e-9 && found.labels[*i]);
        assert!(place.coords.norm() <= 4.0);
    }
    assert_eq!(
        found.labels.iter().filter(|l| **l).count(),
        novelty.points.len()
    );
    // Beyond the limit a thing is no novelty and weighs nothing.
    let far = Solid::Block([5.0, -0.2, -0.5], [5.2, 0.2, 1.2]);
    let current = sees(hall().with(far), &pose, 4);
    let found = detect(&prepared, &current, &settings, 1, &mut |_| {}).expect("a detection");
    assert_eq!(found.verdict, Verdict::Quiet, "{}", found.reason);
    assert!(found.novelties.is_empty());
}

#[test]
fn a_ball_that_moved_is_one_thing() {
    let at = |x: f64, y: f64| room().with(Solid::Ball([x, y, -0.2], 0.3));
    let reference = at(2.2, -0.6).look(Pattern::Tilted(0.5), &here(), URG, f64::INFINITY, 1);
    let current = at(2.0, 0.7).look(Pattern::Tilted(0.5), &here(), URG, f64::INFINITY, 2);
    let found = compare(&reference, &current);
    assert_eq!(found.verdict, Verdict::Changed);
    let came = found
        .novelties
        .iter()
        .find(|n| n.kind == Kind::Appeared)
        .expect("it came");
    let went = came.moved_from.expect("it went elsewhere");
    assert_eq!(found.novelties[went].kind, Kind::Disappeared);
}

#[test]
fn another_room_is_not_observed() {
    let other = Scene {
        room: ([-4.0, -1.2, -0.9], [1.5, 3.9, 3.0]),
        solids: Vec::new(),
    };
    let reference = room().look(Pattern::Tilted(1.0), &here(), URG, f64::INFINITY, 1);
    let current = other.look(Pattern::Tilted(1.0), &here(), URG, f64::INFINITY, 2);
    assert_eq!(compare(&reference, &current).verdict, Verdict::NotObserved);
}

#[test]
fn the_same_pair_gives_the_same_answer_on_any_number_of_threads() {
    let reference = room().look(Pattern::Rings, &here(), URG, f64::INFINITY, 1);
    let current = room().with(Solid::Ball([2.2, 0.2, -0.2], 0.3)).look(
        Pattern::Rings,
        &here(),
        URG,
        f64::INFINITY,
        2,
    );
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("a pool");
        pool.install(|| {
            let found = compare(&reference, &current);
            (found.d_gmm.to_bits(), found.labels, found.novelties)
        })
    };
    assert!(with(1) == with(3));
}

/// Algorithm 1 as the paper has it.
fn by_algorithm_1(model: Model, seed: u64) -> Detection {
    let ball = Solid::Ball([2.2, 0.2, -0.2], 0.3);
    let settings = Settings {
        segmentation: Segmentation::Mixture,
        model,
        ..Settings::default()
    };
    let look =
        |scene: Scene, seed| scene.look(Pattern::Tilted(1.0), &here(), URG, f64::INFINITY, seed);
    let reference = Reference::prepare(&look(room(), 1), &settings, seed).expect("a reference");
    let current = look(room().with(ball), 2);
    let found = detect(&reference, &current, &settings, seed, &mut |_| {}).expect("a detection");
    eprintln!(
        "{model:?} {:?} {} {:?}",
        found.verdict, found.reason, found.components
    );
    for n in &found.novelties {
        eprintln!(
            "    {:?} {} at {:.2?}",
            n.kind,
            n.points.len(),
            n.moments.mean.coords.as_slice()
        );
    }
    found
}

#[test]
fn algorithm_1_on_a_refitted_revisit_takes_out_the_ball() {
    let found = by_algorithm_1(Model::Refit, 1);
    let ball = Point3::new(2.0, 0.2, -0.2);
    assert!(
        found
            .novelties
            .iter()
            .any(|n| { n.kind == Kind::Appeared && (n.moments.mean - ball).norm() < 0.3 })
    );
}

#[test]
fn algorithm_1_on_independent_fits_ends_and_is_deterministic() {
    let (a, b) = (
        by_algorithm_1(Model::Independent { most: 12 }, 5),
        by_algorithm_1(Model::Independent { most: 12 }, 5),
    );
    assert_eq!(a.d_gmm.to_bits(), b.d_gmm.to_bits());
    assert_eq!(a.novelties, b.novelties);
}
