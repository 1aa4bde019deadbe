//! The engine in small analytic rooms: rays against boxes and balls, with known noise and changes.

#[path = "harness/analytic.rs"]
mod analytic;

use analytic::{COARSE, Pattern, Scene, Solid, URG, compare, here, off, room};
use nalgebra::Point3;
use patrold_engine::geometry::{NoiseLaw, Pose};
use patrold_engine::novelty::{
    Detection, Kind, Model, Reference, Segmentation, Settings, Verdict, detect,
};

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
