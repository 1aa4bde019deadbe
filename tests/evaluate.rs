//! The simulated pairs of `evaluate`: their truth is right, and the same seed gives the same pair.

use nalgebra::{Point3, Vector3};
use patrold_engine::geometry::View;
use patrold_engine::inspect::EngineSettings;
use patrold_engine::novelty::Verdict;
use patrold_lab::evaluate::{
    ChangeClass, EngineInput, KeptReference, PairPlan, PairSet, PointLabel, SimulatedPair,
    quiet_threshold, quiet_visits, run_engine,
};

const SEED: u64 = 11;

fn simulate(change: ChangeClass, number: usize, set: PairSet) -> SimulatedPair {
    SimulatedPair::simulate(&PairPlan::new(change, number, set), SEED).expect("a scene")
}

fn count(pair: &SimulatedPair, side: usize, label: PointLabel) -> usize {
    pair.labels[side].iter().filter(|l| **l == label).count()
}

fn views(pair: &SimulatedPair) -> [&View; 2] {
    [&pair.sweeps[0].view, &pair.sweeps[1].view]
}

#[test]
fn the_seed_determines_the_pair() {
    let plan = PairPlan::new(ChangeClass::Moved, 3, PairSet::Tuned);
    let [a, b] = [SEED, SEED].map(|seed| SimulatedPair::simulate(&plan, seed).expect("a scene"));
    assert_eq!(views(&a), views(&b));
    assert_eq!(a.labels, b.labels);
    let c = SimulatedPair::simulate(&plan, SEED + 1).expect("a scene");
    assert_ne!(views(&a), views(&c));
}

#[test]
fn labels_are_on_the_side_where_the_change_is() {
    for number in 0..3 {
        let quiet = simulate(ChangeClass::Quiet, number, PairSet::Tuned);
        assert!(
            quiet
                .labels
                .iter()
                .flatten()
                .all(|l| *l == PointLabel::Unchanged)
        );
        for (change, sides) in [
            (ChangeClass::Person, [false, true]),
            (ChangeClass::Pillar, [false, true]),
            (ChangeClass::Removed, [true, false]),
            (ChangeClass::Moved, [true, true]),
        ] {
            let pair = simulate(change, number, PairSet::Tuned);
            for (side, changed) in sides.into_iter().enumerate() {
                let name = format!(
                    "{change:?} {number}, {}, side {side}",
                    pair.change_description
                );
                assert_eq!(
                    pair.labels[side].len(),
                    views(&pair)[side].points.len(),
                    "{name}"
                );
                let changed_points = count(&pair, side, PointLabel::FreeSpace)
                    + count(&pair, side, PointLabel::BeyondFreeRange);
                assert_eq!(changed_points > 10, changed, "{name}");
            }
        }
    }
}

#[test]
fn a_ball_has_the_planned_distance_and_size() {
    for (change, diameter_m, distance_m) in [
        (ChangeClass::Ball30, 0.3, 3.0),
        (ChangeClass::Ball20, 0.2, 2.5),
        (ChangeClass::Ball10, 0.1, 1.0),
    ] {
        for number in 0..3 {
            let pair = simulate(change, number, PairSet::HeldOutPlaces);
            let view = views(&pair)[1];
            let own: Vec<&Point3<f64>> = view
                .points
                .iter()
                .zip(&pair.labels[1])
                .filter(|(_, l)| **l == PointLabel::FreeSpace)
                .map(|(p, _)| p)
                .collect();
            assert!(own.len() > 10, "{change:?} {number}: {} points", own.len());
            // Half of a ball's visible side is nearer than 2/3 of the radius before its centre. The pose error is up to 10 cm.
            let mut ranges: Vec<f64> = own.iter().map(|p| (*p - view.origin).norm()).collect();
            ranges.sort_by(f64::total_cmp);
            let median = ranges[ranges.len() / 2];
            let expected = distance_m - diameter_m / 3.0;
            assert!(
                (median - expected).abs() < 0.15,
                "{change:?} {number}: {median}"
            );
            let mean: Vector3<f64> =
                own.iter().map(|p| p.coords).sum::<Vector3<f64>>() / own.len() as f64;
            let far = own
                .iter()
                .filter(|p| (p.coords - mean).norm() > 0.6 * diameter_m + 0.03)
                .count();
            assert!(
                20 * far <= own.len(),
                "{change:?} {number}: {far} of {}",
                own.len()
            );
        }
    }
}

#[test]
fn the_true_pose_maps_the_reference_onto_the_revisit() {
    for (number, set) in [
        (2, PairSet::Tuned),
        (3, PairSet::Tuned),
        (1, PairSet::HeldOutSensor),
    ] {
        let pair = simulate(ChangeClass::Quiet, number, set);
        let [reference, current] = views(&pair);
        let mapped = reference
            .points
            .iter()
            .step_by(211)
            .map(|p| pair.current_from_reference * p);
        let (mut near, mut all) = (0, 0);
        for point in mapped {
            let nearest = current
                .points
                .iter()
                .map(|p| (p - point).norm_squared())
                .fold(f64::INFINITY, f64::min);
            all += 1;
            near += usize::from(nearest.sqrt() < 0.1);
        }
        assert!(10 * near >= 9 * all, "{set:?} {number}: {near} of {all}");
    }
}

#[test]
fn the_pose_stays_put_along_the_unobservable_direction_of_a_corridor() {
    // The coarse stages of the registration move 16 cm along this corridor; a post then seems to have disappeared.
    let plan = PairPlan::from_name("quiet-25").expect("a name of the plan");
    let pair = SimulatedPair::simulate(&plan, 5).expect("a scene");
    let settings = EngineSettings::standard().novelty;
    for input in [EngineInput::Bare, EngineInput::Sweep] {
        let found = run_engine(&pair, input, KeptReference::View, &settings, &|| 0.0)
            .expect("enough points")
            .answer;
        assert_eq!(found.registration.unobservable.len(), 1);
        let correction_m = found.registration.current_from_reference.translation.vector;
        assert!(correction_m.norm() < 0.1, "{correction_m} m");
        assert_eq!(found.verdict, Verdict::Quiet, "{}", found.reason);
    }
}

#[test]
fn quiet_visits_are_determined_by_the_pair_and_never_its_own_sweeps() {
    let pair = simulate(ChangeClass::Person, 4, PairSet::Tuned);
    let visits = quiet_visits(&pair, 3).expect("a place");
    assert_eq!(visits, quiet_visits(&pair, 3).expect("a place"));
    // How many are asked for changes none of them.
    assert_eq!(visits[..2], quiet_visits(&pair, 2).expect("a place"));
    let own = views(&pair);
    for (number, visit) in visits.iter().enumerate() {
        assert!(own.iter().all(|view| *view != visit), "visit {number}");
        assert!(!visits[..number].contains(visit), "visit {number}");
    }
}

#[test]
fn the_threshold_of_a_place_lies_below_what_changed_there() {
    let settings = EngineSettings::standard().novelty;
    for (change, number) in [(ChangeClass::Person, 4), (ChangeClass::Removed, 2)] {
        let pair = simulate(change, number, PairSet::Tuned);
        let visits = quiet_visits(&pair, 3).expect("a place");
        for input in [EngineInput::Bare, EngineInput::Sweep] {
            let quiet = quiet_threshold(&pair, &visits, input, &settings).expect("points");
            assert_eq!(quiet.unobserved, 0);
            let u_th = quiet.u_th.expect("observed visits");
            // The visits see the place without the change.
            let judged = run_engine(
                &pair,
                input,
                KeptReference::View,
                &quiet.apply(settings.clone()),
                &|| 0.0,
            );
            let judged = judged.expect("points").answer;
            assert!(u_th < judged.d_gmm, "{change:?}: {u_th}, {}", judged.d_gmm);
            assert_eq!((judged.u_th, judged.verdict), (u_th, Verdict::Changed));
        }
    }
}
