//! The simulated pairs behind `evaluate`: their truth is true, and the same seed gives the same pair.

use nalgebra::{Point3, Vector3};
use patrold_engine::geometry::View;
use patrold_engine::novelty::Verdict;
use patrold_lab::evaluate::{Change, Engine, Given, Label, Pair, Planned, Set, judge};

const SEED: u64 = 11;

fn taken(change: Change, number: usize, set: Set) -> Pair {
    Pair::take(&Planned::new(change, number, set), SEED).expect("a scene")
}

fn count(pair: &Pair, side: usize, label: Label) -> usize {
    pair.labels[side].iter().filter(|l| **l == label).count()
}

fn views(pair: &Pair) -> [&View; 2] {
    [&pair.sweeps[0].view, &pair.sweeps[1].view]
}

#[test]
fn the_same_seed_gives_the_same_pair_and_another_another() {
    let planned = Planned::new(Change::Moved, 3, Set::Tuned);
    let [a, b] = [SEED, SEED].map(|seed| Pair::take(&planned, seed).expect("a scene"));
    assert_eq!(views(&a), views(&b));
    assert_eq!(a.labels, b.labels);
    let c = Pair::take(&planned, SEED + 1).expect("a scene");
    assert_ne!(views(&a), views(&c));
}

#[test]
fn labels_are_on_the_side_where_the_change_is() {
    for number in 0..3 {
        let quiet = taken(Change::Quiet, number, Set::Tuned);
        assert!(quiet.labels.iter().flatten().all(|l| *l == Label::Other));
        for (change, sides) in [
            (Change::Person, [false, true]),
            (Change::Pillar, [false, true]),
            (Change::Removed, [true, false]),
            (Change::Moved, [true, true]),
        ] {
            let pair = taken(change, number, Set::Tuned);
            for (side, changed) in sides.into_iter().enumerate() {
                let told = format!("{change:?} {number}, {}, side {side}", pair.told);
                assert_eq!(
                    pair.labels[side].len(),
                    views(&pair)[side].points.len(),
                    "{told}"
                );
                let passed = count(&pair, side, Label::Seen) + count(&pair, side, Label::Beyond);
                assert_eq!(passed > 10, changed, "{told}");
            }
        }
    }
}

#[test]
fn a_ball_is_where_it_is_promised_and_of_its_size() {
    for (change, diameter_m, distance_m) in [
        (Change::Ball30, 0.3, 3.0),
        (Change::Ball20, 0.2, 2.5),
        (Change::Ball10, 0.1, 1.0),
    ] {
        for number in 0..3 {
            let pair = taken(change, number, Set::HeldOutPlaces);
            let view = views(&pair)[1];
            let own: Vec<&Point3<f64>> = view
                .points
                .iter()
                .zip(&pair.labels[1])
                .filter(|(_, l)| **l == Label::Seen)
                .map(|(p, _)| p)
                .collect();
            assert!(own.len() > 10, "{change:?} {number}: {} points", own.len());
            // Half of a ball's visible side lies within 2/3 of its radius before its middle; the robot stands up to
            // 10 cm off.
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
fn the_true_pose_carries_the_reference_onto_the_revisit() {
    for (number, set) in [(2, Set::Tuned), (3, Set::Tuned), (1, Set::HeldOutSensor)] {
        let pair = taken(Change::Quiet, number, set);
        let [then, now] = views(&pair);
        let carried = then
            .points
            .iter()
            .step_by(211)
            .map(|p| pair.current_from_reference * p);
        let (mut near, mut all) = (0, 0);
        for place in carried {
            let nearest = now
                .points
                .iter()
                .map(|p| (p - place).norm_squared())
                .fold(f64::INFINITY, f64::min);
            all += 1;
            near += usize::from(nearest.sqrt() < 0.1);
        }
        assert!(10 * near >= 9 * all, "{set:?} {number}: {near} of {all}");
    }
}

#[test]
fn a_pose_does_not_walk_along_what_the_corridor_leaves_open() {
    // In the coarse stages the pose walks 16 cm along this corridor; left there, a post seems to have gone.
    let planned = Planned::named("quiet-25").expect("a name of the plan");
    let pair = Pair::take(&planned, 5).expect("a scene");
    let settings = Engine::Standard.settings();
    for given in [Given::Bare, Given::Sweep] {
        let judged = judge(&pair, given, &settings, &|| 0.0).expect("enough points");
        let found = judged.detection;
        assert_eq!(found.registration.unobservable.len(), 1);
        let told_m = found.registration.current_from_reference.translation.vector;
        assert!(told_m.norm() < 0.1, "{told_m} m");
        assert_eq!(found.verdict, Verdict::Quiet, "{}", found.reason);
    }
}
