//! The engine in small analytic scenes: rays against boxes and balls, with known noise and changes.

#[path = "harness/analytic.rs"]
mod analytic;

use analytic::{
    AnalyticScene, AnalyticSolid, COARSE_NOISE, ScanPattern, URG_NOISE, at_origin, compare,
    furnished_room, planar_pose,
};
use nalgebra::Point3;
use patrold_engine::geometry::{NoiseLaw, Pose};
use patrold_engine::novelty::{
    Detection, EvidenceSource, NoveltyKind, NoveltySettings, Reference, RemovalExtent,
    RevisitModel, Verdict, detect,
};

fn patterns() -> [(ScanPattern, NoiseLaw, f64); 6] {
    [
        (ScanPattern::Tilted(0.5), URG_NOISE, f64::INFINITY),
        (ScanPattern::Tilted(1.0), URG_NOISE, f64::INFINITY),
        (ScanPattern::Tilted(1.0), URG_NOISE, 2.6),
        (ScanPattern::Rings, URG_NOISE, f64::INFINITY),
        (ScanPattern::Camera, URG_NOISE, f64::INFINITY),
        (ScanPattern::Sparse, COARSE_NOISE, f64::INFINITY),
    ]
}

#[test]
fn an_unchanged_room_is_quiet() {
    for (pattern, noise, reach) in patterns() {
        let reference = furnished_room().scan(pattern, &at_origin(), noise, reach, 1);
        for seed in 2..5 {
            for pose in [
                at_origin(),
                planar_pose(0.05, -0.03, 2.0),
                planar_pose(-0.15, 0.1, -6.0),
            ] {
                eprintln!(
                    "{pattern:?} reach {reach} seed {seed} {:.2}",
                    pose.translation.vector.norm()
                );
                let current = furnished_room().scan(pattern, &pose, noise, reach, seed);
                let found = compare(&reference, &current);
                assert!(found.novelties.is_empty());
                assert_eq!(found.verdict, Verdict::Quiet, "{}", found.reason);
                assert!(found.d_gmm < 2e-4);
            }
        }
    }
}

#[test]
fn an_added_ball_is_found_and_its_shadow_is_no_novelty() {
    for (pattern, noise, reach) in patterns() {
        // 400 directions hit only large objects.
        let (radius, z) = if matches!(pattern, ScanPattern::Sparse) {
            (0.9, 0.5)
        } else {
            (0.25, -0.25)
        };
        let position = Point3::new(2.2, 0.2, z);
        let ball = AnalyticSolid::Ball([position.x, position.y, position.z], radius);
        let reference = furnished_room().scan(pattern, &at_origin(), noise, reach, 1);
        for (seed, pose) in [
            (2, at_origin()),
            (3, planar_pose(0.05, 0.04, 3.0)),
            (4, planar_pose(-0.08, 0.05, -5.0)),
        ] {
            eprintln!("{pattern:?} reach {reach} seed {seed}");
            let current = furnished_room()
                .with(ball)
                .scan(pattern, &pose, noise, reach, seed);
            let found = compare(&reference, &current);
            assert_eq!(found.verdict, Verdict::Changed);
            assert_eq!(found.novelties.len(), 1);
            let centre = pose.inverse() * position;
            assert_eq!(found.novelties[0].kind, NoveltyKind::Appeared);
            assert!((found.novelties[0].moments.mean - centre).norm() < radius + 0.1);
            // In reverse it disappeared.
            let reference = current;
            let current = furnished_room().scan(pattern, &at_origin(), noise, reach, seed + 10);
            let found = compare(&reference, &current);
            assert_eq!(found.verdict, Verdict::Changed);
            assert_eq!(found.novelties.len(), 1);
            assert_eq!(found.novelties[0].kind, NoveltyKind::Disappeared);
        }
    }
}

#[test]
fn a_range_limit_excludes_points_but_not_the_evidence_of_their_rays() {
    let hall = || AnalyticScene {
        room: ([-1.5, -2.0, -0.5], [6.0, 2.0, 2.1]),
        solids: vec![AnalyticSolid::Block([1.5, 1.6, -0.5], [2.7, 2.0, 1.4])],
    };
    let person = AnalyticSolid::Block([3.2, -0.2, -0.5], [3.4, 0.2, 1.2]);
    let settings = NoveltySettings {
        max_range_m: Some(4.0),
        ..NoveltySettings::default()
    };
    let noise = NoiseLaw {
        at_zero_m: 0.003,
        per_m: 0.001,
    };
    let view = |scene: AnalyticScene, pose: &Pose, seed: u64| {
        scene.scan(ScanPattern::Tilted(0.65), pose, noise, f64::INFINITY, seed)
    };
    let reference = view(hall(), &at_origin(), 1);
    let prepared = Reference::prepare(&reference, &settings, 1).expect("a reference");
    let pose = planar_pose(0.05, -0.03, 2.0);
    let quiet = view(hall(), &pose, 2);
    let found = detect(&prepared, &quiet, &settings, 1, &mut |_| {}).expect("a detection");
    assert_eq!(found.verdict, Verdict::Quiet, "{}", found.reason);
    assert!(found.novelties.is_empty());
    let current = view(hall().with(person), &pose, 3);
    let found = detect(&prepared, &current, &settings, 1, &mut |_| {}).expect("a detection");
    assert_eq!(found.verdict, Verdict::Changed, "{}", found.reason);
    let [novelty] = &found.novelties[..] else {
        panic!("{} novelties", found.novelties.len());
    };
    assert_eq!(novelty.kind, NoveltyKind::Appeared);
    for (i, point) in novelty.point_indices.iter().zip(&novelty.points) {
        assert!((current.points[*i] - point).norm() < 1e-9 && found.labels[*i]);
        assert!(point.coords.norm() <= 4.0);
    }
    assert_eq!(
        found.labels.iter().filter(|l| **l).count(),
        novelty.point_indices.len()
    );
    // Beyond the limit an object is no novelty and has no weight.
    let far = AnalyticSolid::Block([5.0, -0.2, -0.5], [5.2, 0.2, 1.2]);
    let current = view(hall().with(far), &pose, 4);
    let found = detect(&prepared, &current, &settings, 1, &mut |_| {}).expect("a detection");
    assert_eq!(found.verdict, Verdict::Quiet, "{}", found.reason);
    assert!(found.novelties.is_empty());
}

#[test]
fn a_moved_ball_is_linked_to_its_former_place() {
    let at = |x: f64, y: f64| furnished_room().with(AnalyticSolid::Ball([x, y, -0.2], 0.3));
    let reference = at(2.2, -0.6).scan(
        ScanPattern::Tilted(0.5),
        &at_origin(),
        URG_NOISE,
        f64::INFINITY,
        1,
    );
    let current = at(2.0, 0.7).scan(
        ScanPattern::Tilted(0.5),
        &at_origin(),
        URG_NOISE,
        f64::INFINITY,
        2,
    );
    let found = compare(&reference, &current);
    assert_eq!(found.verdict, Verdict::Changed);
    let appeared = found
        .novelties
        .iter()
        .find(|n| n.kind == NoveltyKind::Appeared)
        .expect("it appeared");
    let former = appeared.moved_from.expect("it moved");
    assert_eq!(found.novelties[former].kind, NoveltyKind::Disappeared);
}

#[test]
fn another_room_is_not_observed() {
    let other = AnalyticScene {
        room: ([-4.0, -1.2, -0.9], [1.5, 3.9, 3.0]),
        solids: Vec::new(),
    };
    let reference = furnished_room().scan(
        ScanPattern::Tilted(1.0),
        &at_origin(),
        URG_NOISE,
        f64::INFINITY,
        1,
    );
    let current = other.scan(
        ScanPattern::Tilted(1.0),
        &at_origin(),
        URG_NOISE,
        f64::INFINITY,
        2,
    );
    assert_eq!(compare(&reference, &current).verdict, Verdict::NotObserved);
}

#[test]
fn views_that_do_not_match_are_compared_over_nothing() {
    let scan = |scene: &AnalyticScene, seed| {
        let pattern = ScanPattern::Tilted(1.0);
        scene.scan(pattern, &at_origin(), URG_NOISE, f64::INFINITY, seed)
    };
    let reference = scan(&furnished_room(), 1);
    // Points through the whole volume: no pose lays them on walls.
    let mut current = scan(&furnished_room(), 2);
    for (i, p) in current.points.iter_mut().enumerate() {
        p.coords *= (i % 97) as f64 / 97.0 + 0.01;
    }
    let found = compare(&reference, &current);
    assert_eq!(found.verdict, Verdict::NotObserved);
    assert!(found.reason.contains("do not match"), "{}", found.reason);
    assert_eq!((found.overlap, found.d_gmm), ([0.0; 2], 0.0));
    assert_eq!(found.coverage.solid_angle, 0.0);
    assert_eq!(found.coverage.missing, "everything");
    assert!(found.novelties.is_empty() && !found.labels.contains(&true));
    // Views that match are compared.
    let found = compare(&reference, &scan(&furnished_room(), 3));
    assert!(found.overlap[0] > 0.9 && found.overlap[1] > 0.9);
}

#[test]
fn the_result_does_not_depend_on_the_number_of_threads() {
    let reference = furnished_room().scan(
        ScanPattern::Rings,
        &at_origin(),
        URG_NOISE,
        f64::INFINITY,
        1,
    );
    let current = furnished_room()
        .with(AnalyticSolid::Ball([2.2, 0.2, -0.2], 0.3))
        .scan(
            ScanPattern::Rings,
            &at_origin(),
            URG_NOISE,
            f64::INFINITY,
            2,
        );
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("a pool");
        pool.install(|| {
            let found = compare(&reference, &current);
            (found.d_gmm.to_bits(), found.labels, found.novelties)
        })
    };
    assert!(run(1) == run(3));
}

/// Detection by the paper's Algorithm 1.
fn by_algorithm_1(evidence_source: EvidenceSource, model: RevisitModel, seed: u64) -> Detection {
    let ball = AnalyticSolid::Ball([2.2, 0.2, -0.2], 0.3);
    let settings = NoveltySettings {
        evidence_source,
        model,
        removal_extent: RemovalExtent::UntilBelowThreshold,
        ..NoveltySettings::default()
    };
    let view = |scene: AnalyticScene, seed| {
        scene.scan(
            ScanPattern::Tilted(1.0),
            &at_origin(),
            URG_NOISE,
            f64::INFINITY,
            seed,
        )
    };
    let reference =
        Reference::prepare(&view(furnished_room(), 1), &settings, seed).expect("a reference");
    let current = view(furnished_room().with(ball), 2);
    let found = detect(&reference, &current, &settings, seed, &mut |_| {}).expect("a detection");
    eprintln!(
        "{model:?} {:?} {} {:?}",
        found.verdict, found.reason, found.components
    );
    for n in &found.novelties {
        eprintln!(
            "    {:?} {} at {:.2?}",
            n.kind,
            n.point_indices.len(),
            n.moments.mean.coords.as_slice()
        );
    }
    found
}

#[test]
fn algorithm_1_on_a_refitted_revisit_finds_the_ball() {
    let found = by_algorithm_1(EvidenceSource::Mixture, RevisitModel::Refit, 1);
    let ball = Point3::new(2.0, 0.2, -0.2);
    assert!(
        found
            .novelties
            .iter()
            .any(|n| { n.kind == NoveltyKind::Appeared && (n.moments.mean - ball).norm() < 0.3 })
    );
}

#[test]
fn algorithm_1_on_independent_fits_terminates_and_is_deterministic() {
    let alone = RevisitModel::Independent { max_components: 12 };
    let [a, b] = [5, 5].map(|seed| by_algorithm_1(EvidenceSource::Rays, alone, seed));
    assert_eq!(a.d_gmm.to_bits(), b.d_gmm.to_bits());
    assert_eq!(a.novelties, b.novelties);
}
