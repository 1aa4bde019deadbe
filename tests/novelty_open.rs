//! The engine in open places, with sensors that differ between the visits, and on few points: all with the default settings.

#[path = "harness/analytic.rs"]
mod analytic;

use analytic::{
    AnalyticScene, AnalyticSolid, COARSE_NOISE, ScanPattern, URG_NOISE, at_origin, compare,
    compare_with, furnished_room, planar_pose,
};
use nalgebra::{Point3, Vector3};
use patrold_engine::geometry::{NoiseLaw, Pose, View};
use patrold_engine::novelty::{Detection, EvidenceSettings, NoveltyKind, NoveltySettings, Verdict};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Only one object appeared, with its centre within `within_m` of `expected` (the current view's frame).
fn assert_one_appeared(found: &Detection, expected: Point3<f64>, within_m: f64) {
    assert_eq!(found.verdict, Verdict::Changed, "{}", found.reason);
    assert_eq!(found.novelties.len(), 1);
    assert_eq!(found.novelties[0].kind, NoveltyKind::Appeared);
    let off_m = (found.novelties[0].moments.mean - expected).norm();
    assert!(off_m < within_m, "{off_m} m off");
}

fn assert_quiet(found: &Detection) {
    assert_eq!(found.verdict, Verdict::Quiet, "{}", found.reason);
    assert!(found.novelties.is_empty());
}

#[test]
fn a_return_beyond_the_reliable_range_proves_free_space_before_it() {
    let hall = || AnalyticScene {
        room: ([-1.5, -2.0, -0.5], [5.0, 2.0, 2.1]),
        solids: vec![AnalyticSolid::Block([1.5, 1.6, -0.5], [2.7, 2.0, 1.4])],
    };
    let person = AnalyticSolid::Block([4.2, -0.25, -0.5], [4.5, 0.25, 1.2]);
    let view = |scene: AnalyticScene, pose: &Pose, seed: u64| {
        let mut seen = scene.scan(ScanPattern::Tilted(0.65), pose, URG_NOISE, 5.6, seed);
        seen.free_range_m = 4.0;
        seen
    };
    let reference = view(hall(), &at_origin(), 1);
    for (seed, pose) in [(2, at_origin()), (3, planar_pose(0.05, -0.03, 2.0))] {
        assert_quiet(&compare(&reference, &view(hall(), &pose, seed)));
        let found = compare(&reference, &view(hall().with(person), &pose, seed + 10));
        assert_one_appeared(&found, pose.inverse() * Point3::new(4.2, 0.0, 0.35), 0.15);
    }
}

/// A hall whose walls and ceiling are out of range, with pillars ahead, to both sides and near the ends of the scan lines.
fn open_hall() -> AnalyticScene {
    let pillar = |x: f64, y: f64| AnalyticSolid::Block([x, y, -0.5], [x + 0.4, y + 0.4, 4.0]);
    AnalyticScene {
        room: ([-9.0, -9.0, -0.5], [9.0, 9.0, 6.0]),
        solids: vec![
            pillar(3.4, 1.6),
            pillar(3.0, -2.4),
            pillar(-0.2, 2.6),
            pillar(0.3, -3.2),
            pillar(-1.6, 2.6),
            pillar(-1.9, -2.8),
            AnalyticSolid::Block([1.2, 3.4, -0.5], [2.6, 4.2, 0.6]),
        ],
    }
}

/// Without the directions that gave no return.
fn points_only(mut view: View) -> View {
    view.no_return.clear();
    view.free_range_m = 0.0;
    view
}

fn hall_view(scene: &AnalyticScene, pose: &Pose, seed: u64) -> View {
    points_only(scene.scan(ScanPattern::Tilted(0.65), pose, URG_NOISE, 5.6, seed))
}

#[test]
fn an_object_with_nothing_behind_it_is_found_from_points_alone() {
    let reference = hall_view(&open_hall(), &at_origin(), 1);
    let all =
        analytic::directions(ScanPattern::Tilted(0.65), &mut ChaCha8Rng::seed_from_u64(1)).len();
    assert!(
        10 * reference.points.len() < 7 * all,
        "{} of {all}",
        reference.points.len()
    );
    let centre = Point3::new(2.45, 0.2, 0.5);
    let ball = AnalyticSolid::Ball([centre.x, centre.y, centre.z], 0.15);
    // Without the field of view nothing tells that the space was measured.
    let no_field = NoveltySettings {
        evidence: EvidenceSettings {
            field_margin_spacings: 1e6,
            no_return_reach_share: 0.0,
            ..EvidenceSettings::default()
        },
        ..NoveltySettings::default()
    };
    for (seed, pose) in [
        (2, at_origin()),
        (3, planar_pose(0.04, -0.03, 3.0)),
        (4, planar_pose(-0.03, 0.04, -3.0)),
    ] {
        let current = hall_view(&open_hall().with(ball), &pose, seed);
        assert_one_appeared(
            &compare(&reference, &current),
            pose.inverse() * centre,
            0.25,
        );
        assert!(
            compare_with(&reference, &current, &no_field)
                .novelties
                .is_empty()
        );
        // In reverse it disappeared.
        let found = compare(&current, &reference);
        assert_eq!(found.verdict, Verdict::Changed, "{}", found.reason);
        assert_eq!(found.novelties.len(), 1);
        assert_eq!(found.novelties[0].kind, NoveltyKind::Disappeared);
    }
}

#[test]
fn an_unchanged_open_hall_is_quiet_up_to_the_edges_of_the_field_of_view() {
    let reference = hall_view(&open_hall(), &at_origin(), 1);
    let near_edges = reference.points.iter().filter(|p| {
        let azimuth_deg = p.y.atan2(p.x).abs().to_degrees();
        p.z > -0.3 && (azimuth_deg > 110.0 || (azimuth_deg - 90.0).abs() < 8.0)
    });
    assert!(near_edges.count() > 500, "points near the edges");
    let errors = [
        at_origin(),
        planar_pose(0.05, 0.0, 3.0),
        planar_pose(-0.03, 0.04, -3.0),
        planar_pose(0.0, -0.05, 1.5),
        planar_pose(-0.05, -0.02, 2.5),
        planar_pose(0.1, 0.05, -5.0),
    ];
    for (seed, pose) in (2..).zip(errors) {
        assert_quiet(&compare(&reference, &hall_view(&open_hall(), &pose, seed)));
    }
}

#[test]
fn objects_missed_by_a_coarse_revisit_have_not_disappeared() {
    // A table-top, and an open rack whose boards are thinner than lines 1.4 deg apart.
    let furnished = || {
        let board = |z: f64| AnalyticSolid::Block([2.2, -0.6, z], [2.25, 0.5, z + 0.04]);
        let boards = [-0.25, -0.05, 0.1, 0.25, 0.4].map(board);
        let table = AnalyticSolid::Block([1.2, -1.7, -0.2], [2.0, -1.0, -0.17]);
        boards
            .into_iter()
            .fold(furnished_room().with(table), AnalyticScene::with)
    };
    let view = |lines_deg: f64, pose: &Pose, seed: u64| {
        let pattern = ScanPattern::Tilted(lines_deg);
        furnished().scan(pattern, pose, URG_NOISE, f64::INFINITY, seed)
    };
    let poses = [
        at_origin(),
        planar_pose(0.05, -0.03, 2.0),
        planar_pose(-0.04, 0.02, -1.0),
    ];
    for (fine, coarse) in [(0.5, 1.4), (1.4, 0.5)] {
        for (seed, pose) in (2..8).zip(poses.iter().cycle()) {
            let reference = view(fine, &at_origin(), 100 + seed);
            assert_quiet(&compare(&reference, &view(coarse, pose, seed)));
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
fn drifted_ranges_are_no_change_and_do_not_affect_the_pose() {
    let mut no_drift = NoveltySettings::default();
    no_drift.registration.drift_sd_m = 1e-9;
    no_drift.registration.drift_sd_per_m = 1e-9;
    for pattern in [ScanPattern::Tilted(0.65), ScanPattern::Rings] {
        let reference = furnished_room().scan(pattern, &at_origin(), URG_NOISE, f64::INFINITY, 1);
        for (a, b) in [(0.015, 0.0), (0.0, 0.003), (-0.015, 0.0)] {
            for (seed, pose) in [
                (2, planar_pose(0.04, -0.03, 2.0)),
                (3, planar_pose(-0.05, 0.0, -2.0)),
            ] {
                let current = drifted(
                    furnished_room().scan(pattern, &pose, URG_NOISE, f64::INFINITY, seed),
                    a,
                    b,
                );
                let mut ranges: Vec<f64> = current.points.iter().map(|p| p.coords.norm()).collect();
                ranges.sort_by(f64::total_cmp);
                let median_m = ranges[ranges.len() / 2];
                let found = compare(&reference, &current);
                assert_quiet(&found);
                let pose_error = found.registration.current_from_reference * pose;
                let drift = found.registration.drift;
                let drift_m = drift.at_zero_m + drift.per_m * median_m;
                eprintln!(
                    "{pattern:?} drift {a} {b}: pose off {:.4} m {:.3} deg, drift found {drift_m:.4} at {median_m:.2} m",
                    pose_error.translation.vector.norm(),
                    pose_error.rotation.angle().to_degrees()
                );
                assert!(pose_error.translation.vector.norm() < 0.01);
                assert!(pose_error.rotation.angle().to_degrees() < 0.1);
                assert!((drift_m + a + b * median_m).abs() < 0.003);
                // Without a drift estimate the surfaces of this pair disagree more.
                assert!(
                    compare_with(&reference, &current, &no_drift).disagreement > found.disagreement
                );
            }
        }
    }
}

#[test]
fn different_weights_without_deviating_points_are_no_difference() {
    // The maker's accuracy of 1 % as three standard deviations.
    let bound = NoiseLaw {
        at_zero_m: 0.0,
        per_m: 0.01 / 3.0,
    };
    for pattern in [ScanPattern::Tilted(1.0), ScanPattern::Tilted(0.5)] {
        for seed in 0..6 {
            let view = |pose: &Pose, seed| furnished_room().scan(pattern, pose, bound, 5.6, seed);
            let pose = planar_pose(0.02 * (seed as f64 - 2.5), 0.03, 1.5 - 0.6 * seed as f64);
            let found = compare(&view(&at_origin(), 2 * seed), &view(&pose, 2 * seed + 1));
            assert_quiet(&found);
            assert!(found.d_gmm < 1e-9, "{}", found.d_gmm);
        }
    }
}

/// A corridor of 400 points with 3 cm noise, and an object sampled with a number of points of its own.
fn sparse_corridor(object: Option<(AnalyticSolid, usize)>, seed: u64) -> View {
    let mut scene = AnalyticScene {
        room: ([-4.0, -1.1, -0.6], [5.0, 1.1, 1.9]),
        solids: Vec::new(),
    };
    let Some((solid, points)) = object else {
        return scene.scan(
            ScanPattern::Sparse,
            &at_origin(),
            COARSE_NOISE,
            f64::INFINITY,
            seed,
        );
    };
    let range_m = |scene: &AnalyticScene, d: &Vector3<f64>| scene.range(&Point3::origin(), d);
    let empty_corridor = AnalyticScene {
        room: scene.room,
        solids: Vec::new(),
    };
    scene = scene.with(solid);
    let mut view = scene.scan(
        ScanPattern::Sparse,
        &at_origin(),
        COARSE_NOISE,
        f64::INFINITY,
        seed,
    );
    let mut rng = ChaCha8Rng::seed_from_u64(seed + 1000);
    let mut missing = points;
    while missing > 0 {
        let d = Vector3::new(
            1.0,
            rng.random_range(-0.6..0.6),
            rng.random_range(-0.6..0.8),
        )
        .normalize();
        let range = range_m(&scene, &d);
        if range < range_m(&empty_corridor, &d) - 1e-6 {
            let gauss: f64 = StandardNormal.sample(&mut rng);
            view.points
                .push(Point3::from(d * (range + COARSE_NOISE.at_zero_m * gauss)));
            missing -= 1;
        }
    }
    view
}

#[test]
fn the_defaults_also_work_on_400_points() {
    let objects = [
        (
            "person",
            AnalyticSolid::Block([2.0, -0.2, -0.6], [2.3, 0.3, 1.1]),
        ),
        ("ball", AnalyticSolid::Ball([2.0, 0.1, -0.1], 0.35)),
        (
            "box in a corner",
            AnalyticSolid::Block([1.8, -0.8, -0.6], [2.3, -0.3, 0.0]),
        ),
    ];
    let mut quiet = 0;
    let mut changed = [[0; 3]; 3];
    let mut strays = 0;
    for seed in 0..10 {
        let reference = sparse_corridor(None, 100 + seed);
        let found = compare(&reference, &sparse_corridor(None, 200 + seed));
        quiet += usize::from(found.verdict == Verdict::Quiet && found.novelties.is_empty());
        for (row, (name, solid)) in changed.iter_mut().zip(objects) {
            for (count, points) in row.iter_mut().zip([60, 90, 120]) {
                eprintln!("{name} of {points} points, seed {seed}");
                let current = sparse_corridor(Some((solid, points)), 300 + seed);
                let found = compare(&reference, &current);
                *count += usize::from(found.verdict == Verdict::Changed);
                // Rows are half a metre apart; the denser points of the object must not draw in points of the wall behind.
                let far = |p: &Point3<f64>| (p - Point3::new(2.1, 0.0, 0.2)).norm() > 1.5;
                let novelties = found.novelties.iter();
                strays += novelties.flat_map(|n| &n.points).filter(|p| far(p)).count();
            }
        }
    }
    eprintln!("quiet {quiet} of 10; changed of 10, by object and 60, 90, 120 points: {changed:?}");
    assert_eq!(quiet, 10);
    assert_eq!(strays, 0, "points of far walls in novelties");
    let [person, ball, corner] = changed;
    assert!(person.iter().chain(&ball).all(|n| *n == 10), "{changed:?}");
    // In the corner, in some seeds no direction of the reference passes near enough.
    assert!(corner.iter().all(|n| *n >= 5), "{changed:?}");
}

#[test]
fn an_unobservable_direction_is_left_as_it_is() {
    // A corridor whose ends are out of range: only a few thin posts fix the position along it.
    let post = |x: f64, y: f64| AnalyticSolid::Block([x, y, -0.5], [x + 0.06, y + 0.06, 1.0]);
    let corridor = AnalyticScene {
        room: ([-20.0, -1.2, -0.5], [20.0, 1.2, 2.1]),
        solids: vec![post(1.6, 0.7), post(2.3, -0.8), post(-0.9, 0.8)],
    };
    let view = |scene: &AnalyticScene, pose: &Pose, seed: u64| {
        scene.scan(ScanPattern::Tilted(0.65), pose, URG_NOISE, 5.6, seed)
    };
    let reference = view(&corridor, &at_origin(), 1);
    let mut unobservable = 0;
    for (seed, along_m) in [(2, 0.0), (3, 0.05), (4, 0.08), (5, -0.08), (6, 0.1)] {
        let pose = planar_pose(along_m, 0.0, 0.0);
        for (reference, current) in [
            (reference.clone(), view(&corridor, &pose, seed)),
            (
                points_only(reference.clone()),
                points_only(view(&corridor, &pose, seed)),
            ),
        ] {
            let found = compare(&reference, &current);
            unobservable += usize::from(!found.registration.unobservable.is_empty());
            assert_ne!(found.verdict, Verdict::Changed, "{along_m} m along");
            // The unobservable part of the correction is zero.
            let correction_m = found.registration.current_from_reference.translation.x;
            assert!(correction_m.abs() < 0.02, "{correction_m} m of {along_m} m");
        }
    }
    assert_eq!(
        unobservable, 10,
        "the corridor does not fix the position along it"
    );
    // A person is found nevertheless.
    let person = AnalyticSolid::Block([2.6, -0.25, -0.5], [2.9, 0.25, 1.2]);
    let pose = planar_pose(0.08, 0.0, 0.0);
    let with_person = AnalyticScene {
        room: corridor.room,
        solids: [corridor.solids.clone(), vec![person]].concat(),
    };
    let found = compare(&reference, &view(&with_person, &pose, 7));
    assert_eq!(found.verdict, Verdict::Changed, "{}", found.reason);
}
