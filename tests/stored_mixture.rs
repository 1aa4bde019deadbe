//! The stored mixture decides: Gaussians taken out of it, put into it, or given another weight, with view and sweep untouched
//! (`docs/novelty.md section 3`). It prints (`--nocapture`) what every trial found.
#![allow(clippy::print_stdout, reason = "it prints a table")]

use nalgebra::{Matrix3, Point3};
use patrold_engine::distance::emd;
use patrold_engine::geometry::View;
use patrold_engine::inspect::EngineSettings;
use patrold_engine::mixture::{Gaussian, Mixture};
use patrold_engine::novelty::{
    ComponentBeams, Detection, Novelty, NoveltyKind, NoveltySettings, Reference, ReferenceMixture,
    Verdict, detect,
};
use patrold_lab::evaluate::{
    ChangeClass, PairPlan, PairSet, PointLabel, PoseErrorClass, SimulatedPair,
};
use rand::SeedableRng;
use rand_distr::{Distribution, Normal};

/// Standard deviation of the ranges of a second look, metres.
const SECOND_LOOK_SIGMA_M: f64 = 0.004;
/// Boxes of every trial.
const BOXES: usize = 20;
/// Points on a box at least: it is far above the gates.
const MIN_BOX_POINTS: usize = 250;
/// Pairs of two poses, one in each kind of place, and how many must be right without the reference's view: of 36 pairs 33 are
/// (`patrold evaluate --seed 4 --pairs 36 --view bare --reference mixture`).
const POSES: usize = 6;
const MIN_POSES: usize = 5;
/// How near to its truth a change must be found, metres.
const MAX_ERROR_M: f64 = 0.05;

/// The same view, looked at again.
fn second_look(view: &View, seed: u64) -> View {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let noise = Normal::new(0.0, SECOND_LOOK_SIGMA_M).expect("a deviation");
    let mut again = view.clone();
    for p in &mut again.points {
        let ray = (*p - view.origin).normalize();
        *p += ray * noise.sample(&mut rng);
    }
    again
}

/// Pairs whose second sweep has a box that the first has not, in different places.
fn pairs_with_a_box(count: usize) -> Vec<SimulatedPair> {
    (0..)
        .map(|number| {
            let plan = PairPlan {
                pose_error: PoseErrorClass::None,
                ..PairPlan::new(ChangeClass::Box, number, PairSet::Tuned)
            };
            SimulatedPair::simulate(&plan, 14).expect("a scene")
        })
        .filter(|pair| box_points(pair).len() >= MIN_BOX_POINTS)
        .take(count)
        .collect()
}

fn box_points(pair: &SimulatedPair) -> Vec<Point3<f64>> {
    let sweep = &pair.sweeps[1].view;
    let labels = sweep.points.iter().zip(&pair.labels[1]);
    labels
        .filter(|(_, label)| **label != PointLabel::Unchanged)
        .map(|(p, _)| *p)
        .collect()
}

/// Components of `gamma`, fitted to the second sweep, most of whose points are the box's.
fn on_box(gamma: &ReferenceMixture, pair: &SimulatedPair) -> Vec<bool> {
    let mixture = &gamma.mixture;
    let densities: Vec<(Matrix3<f64>, f64)> = mixture
        .components
        .iter()
        .zip(&mixture.weights)
        .map(|(g, weight)| {
            let inverse = g.covariance.try_inverse().expect("a volume");
            (inverse, weight.ln() - 0.5 * g.covariance.determinant().ln())
        })
        .collect();
    let mut counts = vec![[0, 0]; mixture.len()];
    for (p, label) in pair.sweeps[1].view.points.iter().zip(&pair.labels[1]) {
        let log_density = |k: usize| {
            let (inverse, log_peak) = &densities[k];
            let off = p - mixture.components[k].mean;
            log_peak - 0.5 * off.dot(&(inverse * off))
        };
        let best = (0..mixture.len())
            .max_by(|a, b| log_density(*a).total_cmp(&log_density(*b)))
            .expect("components");
        counts[best][usize::from(*label != PointLabel::Unchanged)] += 1;
    }
    counts.iter().map(|[other, own]| own > other).collect()
}

fn chosen(
    gamma: &ReferenceMixture,
    which: impl Fn(usize) -> bool,
) -> (Vec<f64>, Vec<Gaussian>, Vec<ComponentBeams>) {
    let chosen = (0..gamma.mixture.len()).filter(|k| which(*k));
    let (mut weights, mut components, mut beams) = (Vec::new(), Vec::new(), Vec::new());
    for k in chosen {
        weights.push(gamma.mixture.weights[k]);
        components.push(gamma.mixture.components[k]);
        beams.push(gamma.beams[k]);
    }
    (weights, components, beams)
}

fn judge(view: &View, gamma: ReferenceMixture, current: &View) -> Detection {
    let settings = NoveltySettings::default();
    let reference = Reference::from_stored(view, gamma, &settings).expect("a reference");
    detect(&reference, current, &settings, 1, &mut |_| ()).expect("a verdict")
}

/// The mean of the beams of some components.
fn middle(components: &[Gaussian], beams: &[ComponentBeams]) -> Point3<f64> {
    let counts = beams.iter().map(|beams| beams.count).collect();
    let part = Mixture::from_masses(counts, components.to_vec()).expect("a mixture");
    part.total_moments().expect("mass").mean
}

/// How far from `truth` the nearest novelty of `kind` is, metres.
fn error_m(detection: &Detection, kind: NoveltyKind, truth: &Point3<f64>) -> f64 {
    let novelties = detection.novelties.iter().filter(|n| n.kind == kind);
    novelties
        .map(|n| (n.moments.mean - truth).norm())
        .fold(f64::INFINITY, f64::min)
}

#[test]
fn gaussians_taken_out_of_the_mixture_appear() {
    let settings = NoveltySettings::default();
    let mut right = 0;
    for (trial, pair) in pairs_with_a_box(BOXES).iter().enumerate() {
        let with_box = &pair.sweeps[1].view;
        let points = box_points(pair);
        let fitted = Reference::prepare(with_box, &settings, 1).expect("a reference");
        let own = on_box(&fitted.gamma, pair);
        let (weights, components, beams) = chosen(&fitted.gamma, |k| !own[k]);
        let without = ReferenceMixture {
            mixture: Mixture::from_masses(weights, components).expect("a mixture"),
            beams,
        };
        let current = second_look(with_box, trial as u64);
        let stored = Reference::from_stored(with_box, fitted.gamma.clone(), &settings);
        assert_eq!(stored.expect("a reference").contradictions, [0, 0]);
        let untouched = judge(with_box, fitted.gamma.clone(), &current);
        assert_eq!(untouched.verdict, Verdict::Quiet, "{}", untouched.reason);
        let found = judge(with_box, without, &current);
        let (_, boxes, of_boxes) = chosen(&fitted.gamma, |k| own[k]);
        let error = error_m(&found, NoveltyKind::Appeared, &middle(&boxes, &of_boxes));
        println!(
            "{} {}: {} of {} Gaussians, {} points: {:?}, {error:.3} m, novelties of {:?} points, d {:.5}",
            pair.plan.name(),
            pair.change_description,
            own.iter().filter(|own| **own).count(),
            own.len(),
            points.len(),
            found.verdict,
            found
                .novelties
                .iter()
                .map(|n| n.points.len())
                .collect::<Vec<_>>(),
            found.d_gmm
        );
        right += usize::from(found.verdict == Verdict::Changed && error < MAX_ERROR_M);
    }
    assert_eq!(right, BOXES);
}

#[test]
fn gaussians_put_into_the_mixture_disappear() {
    let settings = NoveltySettings::default();
    let mut right = 0;
    for (trial, pair) in pairs_with_a_box(BOXES).iter().enumerate() {
        let [without_box, with_box] = [0, 1].map(|side| &pair.sweeps[side].view);
        let points = box_points(pair);
        let other = Reference::prepare(with_box, &settings, 1).expect("a reference");
        let fitted = Reference::prepare(without_box, &settings, 1).expect("a reference");
        let own = on_box(&other.gamma, pair);
        let (mut weights, mut components, mut beams) = chosen(&fitted.gamma, |_| true);
        let (more, boxes, of_boxes) = chosen(&other.gamma, |k| own[k]);
        let truth = middle(&boxes, &of_boxes);
        weights.extend(more);
        components.extend(boxes);
        beams.extend(of_boxes);
        let with = ReferenceMixture {
            mixture: Mixture::from_masses(weights, components).expect("a mixture"),
            beams,
        };
        let current = second_look(without_box, trial as u64);
        let found = judge(without_box, with, &current);
        let error = error_m(&found, NoveltyKind::Disappeared, &truth);
        println!(
            "{} {}: {} Gaussians, {} points: {:?}, {error:.3} m, {} novelties, d {:.5}",
            pair.plan.name(),
            pair.change_description,
            own.iter().filter(|own| **own).count(),
            points.len(),
            found.verdict,
            found.novelties.len(),
            found.d_gmm
        );
        right += usize::from(found.verdict == Verdict::Changed && error < MAX_ERROR_M);
    }
    assert_eq!(right, BOXES);
}

#[test]
fn a_doubled_weight_gives_the_distance_of_the_mixtures() {
    let settings = NoveltySettings::default();
    for pair in pairs_with_a_box(3) {
        let view = &pair.sweeps[0].view;
        let fitted = Reference::prepare(view, &settings, 1).expect("a reference");
        let weights = &fitted.gamma.mixture.weights;
        let largest = (0..weights.len())
            .max_by(|a, b| weights[*a].total_cmp(&weights[*b]))
            .expect("components");
        let mut doubled = fitted.gamma.clone();
        doubled.mixture.weights[largest] *= 2.0;
        let mixture = Mixture::from_masses(doubled.mixture.weights, doubled.mixture.components);
        doubled.mixture = mixture.expect("a mixture");
        let found = judge(view, doubled, &second_look(view, 3));
        let [gamma, theta] = [0, 1].map(|side| found.compared.mixture(side).expect("a mixture"));
        let d = emd(&gamma, &theta, settings.quantify.ground)
            .expect("a distance")
            .d;
        assert!((found.d_gmm - d).abs() < 1e-12, "{} {d}", found.d_gmm);
        // No beam deviates: the difference has no novelty.
        assert_eq!(found.verdict, Verdict::NotObserved, "{}", found.reason);
    }
}

#[test]
fn the_mixture_alone_tells_a_box_from_another_pose() {
    let settings = NoveltySettings::default();
    let judge_alone = |pair: &SimulatedPair| {
        let [reference, current] = [0, 1].map(|side| &pair.sweeps[side].view);
        let fitted = Reference::prepare(reference, &settings, 1).expect("a reference");
        let alone = Reference::from_mixture_alone(reference, fitted.gamma, &settings);
        detect(
            &alone.expect("a reference"),
            current,
            &settings,
            1,
            &mut |_| {},
        )
        .expect("a verdict")
    };
    let (mut quiet, mut found) = (0, 0);
    for number in 0..POSES {
        // Numbers come in turns of six kinds of place.
        let plan = |change| PairPlan {
            pose_error: PoseErrorClass::Large,
            ..PairPlan::new(change, number, PairSet::Tuned)
        };
        let unchanged = SimulatedPair::simulate(&plan(ChangeClass::Quiet), 15).expect("a scene");
        let answer = judge_alone(&unchanged);
        println!("{}: {}", unchanged.plan.name(), answer.reason);
        quiet += usize::from(answer.verdict == Verdict::Quiet);
        let with_box = SimulatedPair::simulate(&plan(ChangeClass::Box), 15).expect("a scene");
        let answer = judge_alone(&with_box);
        let truth = box_points(&with_box);
        let near = |p: &Point3<f64>| truth.iter().any(|q| (p - q).norm() < 1e-6);
        let right = |n: &Novelty| 2 * n.points.iter().filter(|p| near(p)).count() > n.points.len();
        println!("{}: {}", with_box.plan.name(), answer.reason);
        found +=
            usize::from(answer.verdict == Verdict::Changed && answer.novelties.iter().any(right));
    }
    assert!(quiet >= MIN_POSES && found >= MIN_POSES, "{quiet} {found}");
}

#[test]
fn a_cloud_against_itself_is_quiet() {
    for pair in pairs_with_a_box(3) {
        let view = &pair.sweeps[1].view;
        for engine in [EngineSettings::standard(), EngineSettings::paper()] {
            let settings = engine.novelty;
            let fitted = Reference::prepare(view, &settings, 1).expect("a reference");
            let found = detect(&fitted, view, &settings, 1, &mut |_| ()).expect("a verdict");
            assert_eq!((found.verdict, found.d_gmm), (Verdict::Quiet, 0.0));
        }
    }
}
