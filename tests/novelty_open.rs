//! Where nothing stands behind a thing, where sensors differ from visit to visit, and where there is little to go by: one
//! set of defaults answers all of it.

#[path = "harness/analytic.rs"]
mod analytic;

use analytic::{COARSE, Pattern, Scene, Solid, URG, compare, compare_with, here, off, room};
use nalgebra::{Point3, Vector3};
use patrold_engine::geometry::{NoiseLaw, Pose, View};
use patrold_engine::novelty::{Detection, EvidenceSettings, Kind, Settings, Verdict};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// The only thing that came; its middle lies within `within_m` of `place` (the current view's frame).
fn only_came(found: &Detection, place: Point3<f64>, within_m: f64) {
    assert_eq!(found.verdict, Verdict::Changed, "{}", found.reason);
    assert_eq!(found.novelties.len(), 1);
    assert_eq!(found.novelties[0].kind, Kind::Appeared);
    let off_m = (found.novelties[0].moments.mean - place).norm();
    assert!(off_m < within_m, "{off_m} m off");
}

fn nothing(found: &Detection) {
    assert_eq!(found.verdict, Verdict::Quiet, "{}", found.reason);
    assert!(found.novelties.is_empty());
}

#[test]
fn a_return_beyond_the_reliable_range_proves_what_lies_before_it_free() {
    let hall = || Scene {
        room: ([-1.5, -2.0, -0.5], [5.0, 2.0, 2.1]),
        solids: vec![Solid::Block([1.5, 1.6, -0.5], [2.7, 2.0, 1.4])],
    };
    let person = Solid::Block([4.2, -0.25, -0.5], [4.5, 0.25, 1.2]);
    let sees = |scene: Scene, pose: &Pose, seed: u64| {
        let mut view = scene.look(Pattern::Tilted(0.65), pose, URG, 5.6, seed);
        view.free_range_m = 4.0;
        view
    };
    let reference = sees(hall(), &here(), 1);
    for (seed, pose) in [(2, here()), (3, off(0.05, -0.03, 2.0))] {
        nothing(&compare(&reference, &sees(hall(), &pose, seed)));
        let found = compare(&reference, &sees(hall().with(person), &pose, seed + 10));
        only_came(&found, pose.inverse() * Point3::new(4.2, 0.0, 0.35), 0.15);
    }
}

/// A hall whose walls and roof are out of reach; pillars stand ahead, to both sides and near the ends of the lines.
fn open_hall() -> Scene {
    let pillar = |x: f64, y: f64| Solid::Block([x, y, -0.5], [x + 0.4, y + 0.4, 4.0]);
    Scene {
        room: ([-9.0, -9.0, -0.5], [9.0, 9.0, 6.0]),
        solids: vec![
            pillar(3.4, 1.6),
            pillar(3.0, -2.4),
            pillar(-0.2, 2.6),
            pillar(0.3, -3.2),
            pillar(-1.6, 2.6),
            pillar(-1.9, -2.8),
            Solid::Block([1.2, 3.4, -0.5], [2.6, 4.2, 0.6]),
        ],
    }
}

/// Points only: where nothing came back is not said.
fn bare(mut view: View) -> View {
    view.no_return.clear();
    view.free_range_m = 0.0;
    view
}

fn hall_seen(scene: &Scene, pose: &Pose, seed: u64) -> View {
    bare(scene.look(Pattern::Tilted(0.65), pose, URG, 5.6, seed))
}

#[test]
fn a_thing_with_nothing_behind_it_is_found_from_bare_clouds() {
    let reference = hall_seen(&open_hall(), &here(), 1);
    let all = analytic::directions(Pattern::Tilted(0.65), &mut ChaCha8Rng::seed_from_u64(1)).len();
    assert!(
        10 * reference.points.len() < 7 * all,
        "{} of {all}",
        reference.points.len()
    );
    let place = Point3::new(2.45, 0.2, 0.5);
    let ball = Solid::Ball([place.x, place.y, place.z], 0.15);
    // What says that such a place was looked at; without it there is nothing to go by.
    let no_field = Settings {
        evidence: EvidenceSettings {
            field_margin_spacings: 1e6,
            hole_reach: 0.0,
            ..EvidenceSettings::default()
        },
        ..Settings::default()
    };
    for (seed, pose) in [
        (2, here()),
        (3, off(0.04, -0.03, 3.0)),
        (4, off(-0.03, 0.04, -3.0)),
    ] {
        let current = hall_seen(&open_hall().with(ball), &pose, seed);
        only_came(&compare(&reference, &current), pose.inverse() * place, 0.25);
        assert!(
            compare_with(&reference, &current, &no_field)
                .novelties
                .is_empty()
        );
        // The other way round it went.
        let found = compare(&current, &reference);
        assert_eq!(found.verdict, Verdict::Changed, "{}", found.reason);
        assert_eq!(found.novelties.len(), 1);
        assert_eq!(found.novelties[0].kind, Kind::Disappeared);
    }
}

#[test]
fn an_open_hall_without_change_is_quiet_up_to_the_ends_of_the_field() {
    let reference = hall_seen(&open_hall(), &here(), 1);
    let ends = reference.points.iter().filter(|p| {
        let azimuth_deg = p.y.atan2(p.x).abs().to_degrees();
        p.z > -0.3 && (azimuth_deg > 110.0 || (azimuth_deg - 90.0).abs() < 8.0)
    });
    assert!(ends.count() > 500, "something stands near the ends");
    let errors = [
        here(),
        off(0.05, 0.0, 3.0),
        off(-0.03, 0.04, -3.0),
        off(0.0, -0.05, 1.5),
        off(-0.05, -0.02, 2.5),
        off(0.1, 0.05, -5.0),
    ];
    for (seed, pose) in (2..).zip(errors) {
        nothing(&compare(&reference, &hall_seen(&open_hall(), &pose, seed)));
    }
}

#[test]
fn what_a_coarse_revisit_may_pass_by_has_not_gone() {
    // A table-top, and an open rack whose boards are thinner than lines 1.4 deg apart.
    let furnished = || {
        let board = |z: f64| Solid::Block([2.2, -0.6, z], [2.25, 0.5, z + 0.04]);
        let boards = [-0.25, -0.05, 0.1, 0.25, 0.4].map(board);
        let table = Solid::Block([1.2, -1.7, -0.2], [2.0, -1.0, -0.17]);
        boards.into_iter().fold(room().with(table), Scene::with)
    };
    let sees = |lines_deg: f64, pose: &Pose, seed: u64| {
        let pattern = Pattern::Tilted(lines_deg);
        furnished().look(pattern, pose, URG, f64::INFINITY, seed)
    };
    let poses = [here(), off(0.05, -0.03, 2.0), off(-0.04, 0.02, -1.0)];
    for (fine, coarse) in [(0.5, 1.4), (1.4, 0.5)] {
        for (seed, pose) in (2..8).zip(poses.iter().cycle()) {
            let reference = sees(fine, &here(), 100 + seed);
            nothing(&compare(&reference, &sees(coarse, pose, seed)));
        }
    }
}

/// The view of a sensor whose ranges come out longer by `at_zero_m + per_m * range`.
fn drifted(mut view: View, at_zero_m: f64, per_m: f64) -> View {
    for p in &mut view.points {
        let range_m = p.coords.norm();
        *p = Point3::from(p.coords * ((range_m + at_zero_m + per_m * range_m) / range_m));
    }
    view
}

#[test]
fn ranges_that_drifted_are_no_change_and_do_not_bend_the_pose() {
    let mut held = Settings::default();
    held.registration.drift_sd_m = 1e-9;
    held.registration.drift_sd_per_m = 1e-9;
    for pattern in [Pattern::Tilted(0.65), Pattern::Rings] {
        let reference = room().look(pattern, &here(), URG, f64::INFINITY, 1);
        for (a, b) in [(0.015, 0.0), (0.0, 0.003), (-0.015, 0.0)] {
            for (seed, pose) in [(2, off(0.04, -0.03, 2.0)), (3, off(-0.05, 0.0, -2.0))] {
                let current = drifted(room().look(pattern, &pose, URG, f64::INFINITY, seed), a, b);
                let mut ranges: Vec<f64> = current.points.iter().map(|p| p.coords.norm()).collect();
                ranges.sort_by(f64::total_cmp);
                let median_m = ranges[ranges.len() / 2];
                let found = compare(&reference, &current);
                nothing(&found);
                let wrong = found.registration.current_from_reference * pose;
                let drift = found.registration.drift;
                let told_m = drift.at_zero_m + drift.per_m * median_m;
                eprintln!(
                    "{pattern:?} drift {a} {b}: pose off {:.4} m {:.3} deg, drift told {told_m:.4} at {median_m:.2} m",
                    wrong.translation.vector.norm(),
                    wrong.rotation.angle().to_degrees()
                );
                assert!(wrong.translation.vector.norm() < 0.01);
                assert!(wrong.rotation.angle().to_degrees() < 0.1);
                assert!((told_m + a + b * median_m).abs() < 0.003);
                // Ranges held as they are, the same pair says that surfaces lie apart.
                assert!(
                    compare_with(&reference, &current, &held).disagreement > found.disagreement
                );
            }
        }
    }
}

#[test]
fn weights_that_differ_where_nothing_deviates_are_no_difference() {
    // The makers' bound of 1 % (10 mm below a metre) as three standard deviations.
    let bound = NoiseLaw {
        at_zero_m: 0.0,
        per_m: 0.01 / 3.0,
    };
    for pattern in [Pattern::Tilted(1.0), Pattern::Tilted(0.5)] {
        for seed in 0..6 {
            let sees = |pose: &Pose, seed| room().look(pattern, pose, bound, 5.6, seed);
            let pose = off(0.02 * (seed as f64 - 2.5), 0.03, 1.5 - 0.6 * seed as f64);
            let found = compare(&sees(&here(), 2 * seed), &sees(&pose, 2 * seed + 1));
            nothing(&found);
            assert!(found.d_gmm < 1e-9, "{}", found.d_gmm);
        }
    }
}

/// A corridor in 400 points of 3 cm noise, with what a thing's near side adds at its own density.
fn sparse_corridor(thing: Option<(Solid, usize)>, seed: u64) -> View {
    let mut scene = Scene {
        room: ([-4.0, -1.1, -0.6], [5.0, 1.1, 1.9]),
        solids: Vec::new(),
    };
    let Some((solid, points)) = thing else {
        return scene.look(Pattern::Sparse, &here(), COARSE, f64::INFINITY, seed);
    };
    let empty_m = |scene: &Scene, d: &Vector3<f64>| scene.range(&Point3::origin(), d);
    let bare_corridor = Scene {
        room: scene.room,
        solids: Vec::new(),
    };
    scene = scene.with(solid);
    let mut view = scene.look(Pattern::Sparse, &here(), COARSE, f64::INFINITY, seed);
    let mut rng = ChaCha8Rng::seed_from_u64(seed + 1000);
    let mut missing = points;
    while missing > 0 {
        let d = Vector3::new(
            1.0,
            rng.random_range(-0.6..0.6),
            rng.random_range(-0.6..0.8),
        )
        .normalize();
        let range_m = empty_m(&scene, &d);
        if range_m < empty_m(&bare_corridor, &d) - 1e-6 {
            let gauss: f64 = StandardNormal.sample(&mut rng);
            view.points
                .push(Point3::from(d * (range_m + COARSE.at_zero_m * gauss)));
            missing -= 1;
        }
    }
    view
}

#[test]
fn four_hundred_points_are_judged_by_the_same_defaults() {
    let things = [
        ("person", Solid::Block([2.0, -0.2, -0.6], [2.3, 0.3, 1.1])),
        ("ball", Solid::Ball([2.0, 0.1, -0.1], 0.35)),
        (
            "box in a corner",
            Solid::Block([1.8, -0.8, -0.6], [2.3, -0.3, 0.0]),
        ),
    ];
    let mut quiet = 0;
    let mut changed = [[0; 3]; 3];
    let mut strays = 0;
    for seed in 0..10 {
        let reference = sparse_corridor(None, 100 + seed);
        let found = compare(&reference, &sparse_corridor(None, 200 + seed));
        quiet += usize::from(found.verdict == Verdict::Quiet && found.novelties.is_empty());
        for (row, (name, solid)) in changed.iter_mut().zip(things) {
            for (count, points) in row.iter_mut().zip([60, 90, 120]) {
                eprintln!("{name} of {points} points, seed {seed}");
                let current = sparse_corridor(Some((solid, points)), 300 + seed);
                let found = compare(&reference, &current);
                *count += usize::from(found.verdict == Verdict::Changed);
                // Rows are half a metre apart here; the thing's own points are not, and draw in no wall beyond.
                let far = |p: &Point3<f64>| (p - Point3::new(2.1, 0.0, 0.2)).norm() > 1.5;
                let came = found.novelties.iter();
                strays += came.flat_map(|n| &n.places).filter(|p| far(p)).count();
            }
        }
    }
    eprintln!("quiet {quiet} of 10; changed of 10, by thing and 60, 90, 120 points: {changed:?}");
    assert_eq!(quiet, 10);
    assert_eq!(strays, 0, "points of far walls in novelties");
    let [person, ball, corner] = changed;
    assert!(person.iter().chain(&ball).all(|n| *n == 10), "{changed:?}");
    // In the corner of floor and wall, now and then no direction of the reference passes near enough.
    assert!(corner.iter().all(|n| *n >= 5), "{changed:?}");
}

#[test]
fn what_the_pose_leaves_open_moves_nothing() {
    // A corridor whose ends are out of reach: nothing but a few thin posts says how far along it the robot stands.
    let post = |x: f64, y: f64| Solid::Block([x, y, -0.5], [x + 0.06, y + 0.06, 1.0]);
    let corridor = Scene {
        room: ([-20.0, -1.2, -0.5], [20.0, 1.2, 2.1]),
        solids: vec![post(1.6, 0.7), post(2.3, -0.8), post(-0.9, 0.8)],
    };
    let sees = |scene: &Scene, pose: &Pose, seed: u64| {
        scene.look(Pattern::Tilted(0.65), pose, URG, 5.6, seed)
    };
    let reference = sees(&corridor, &here(), 1);
    let mut left_open = 0;
    for (seed, along_m) in [(2, 0.0), (3, 0.05), (4, 0.08), (5, -0.08), (6, 0.1)] {
        let pose = off(along_m, 0.0, 0.0);
        for (then, now) in [
            (reference.clone(), sees(&corridor, &pose, seed)),
            (bare(reference.clone()), bare(sees(&corridor, &pose, seed))),
        ] {
            let found = compare(&then, &now);
            left_open += usize::from(!found.registration.unobservable.is_empty());
            assert_ne!(found.verdict, Verdict::Changed, "{along_m} m along");
            // Where nothing is known the robot stands where it meant to.
            let told_m = found.registration.current_from_reference.translation.x;
            assert!(told_m.abs() < 0.02, "{told_m} m of {along_m} m");
        }
    }
    assert_eq!(left_open, 10, "the corridor fixes no place along it");
    // A person in the way is one all the same.
    let person = Solid::Block([2.6, -0.25, -0.5], [2.9, 0.25, 1.2]);
    let pose = off(0.08, 0.0, 0.0);
    let with = Scene {
        room: corridor.room,
        solids: [corridor.solids.clone(), vec![person]].concat(),
    };
    let found = compare(&reference, &sees(&with, &pose, 7));
    assert_eq!(found.verdict, Verdict::Changed, "{}", found.reason);
}
