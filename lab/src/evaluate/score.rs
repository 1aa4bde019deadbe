//! Scores of the engine's answers against the truth.

use super::pair::SimulatedPair;
use super::plan::PairPlan;
use super::point_labels::PointLabel;
use super::quiet_threshold::QuietThreshold;
use super::run_engine::EngineInput;
use crate::timing::Timed;
use nalgebra::{Point3, Translation3, Vector3, Vector6};
use patrold_engine::geometry::{Pose, Registration};
use patrold_engine::inspect::Engine;
use patrold_engine::novelty::{Detection, Novelty, NoveltyKind, Verdict};

/// A listed novelty and its truth.
#[derive(Debug, Clone, PartialEq)]
pub struct ListedNovelty {
    /// Appeared or disappeared.
    pub kind: NoveltyKind,
    /// Points, without those on unmoved surfaces.
    pub points: usize,
    /// Points that truly appeared or disappeared.
    pub true_points: usize,
    /// Support as the engine states it.
    pub support: f64,
    /// Mean, frame of the revisit, metres.
    pub centre: [f64; 3],
    /// Extent along the axes, metres.
    pub extent: [f64; 3],
    /// Share of d_GMM.
    pub contribution: f64,
}

impl ListedNovelty {
    /// Whether at least half of its points truly appeared or disappeared.
    pub fn is_correct(&self) -> bool {
        2 * self.true_points >= self.points
    }
}

/// The score of one pair with one engine and input.
#[derive(Debug, Clone, PartialEq)]
pub struct PairScore {
    /// The pair.
    pub plan: PairPlan,
    /// The change, for people.
    pub change_description: String,
    /// The engine.
    pub engine: Engine,
    /// What it got.
    pub input: EngineInput,
    /// Its verdict.
    pub verdict: Verdict,
    /// Its reason.
    pub reason: String,
    /// d_GMM.
    pub d_gmm: f64,
    /// U_th that it was judged by.
    pub u_th: f64,
    /// Quiet visits to its place that were not observed; 0 where U_th is the engine's own.
    pub unobserved_visits: usize,
    /// The part of d_GMM that no novelty explains.
    pub unexplained: f64,
    /// The listed novelties.
    pub listed: Vec<ListedNovelty>,
    /// Points of both clouds that truly appeared or disappeared.
    pub true_points: usize,
    /// Those at which the other visit saw free space.
    pub seen_points: usize,
    /// Those at which it got no return, beyond the range up to which this proves free space.
    pub beyond_points: usize,
    /// Intersection over union of listed and true points of both clouds; `None` of quiet pairs.
    pub iou: Option<f64>,
    /// The same without points that the other visit could not see.
    pub iou_seen: Option<f64>,
    /// Error of the registration in the directions that it calls observable, metres.
    pub shift_error_m: f64,
    /// The same as an angle, degrees.
    pub turn_error_deg: f64,
    /// Its squared error in units of the covariance that it states, see `POSE_CHI2_95`.
    pub pose_chi2: f64,
    /// Directions that it calls unobservable.
    pub unobservable: Vec<String>,
    /// Share of the surface that the registration explains.
    pub share: f64,
    /// The same where every direction that the surfaces fix counts alike.
    pub share_by_direction: f64,
    /// Noise between the views over the noise of each.
    pub disagreement: f64,
    /// From the current view to the verdict, milliseconds.
    pub verdict_ms: f64,
    /// Bytes of the reference as the store keeps it: its mixture, and its view.
    pub stored_bytes: [usize; 2],
}

impl PairScore {
    /// Whether an object appeared, disappeared or moved.
    pub fn is_changed(&self) -> bool {
        self.true_points > 0
    }

    /// Whether the verdict is `changed`, with at least one correct novelty.
    pub fn is_found(&self) -> bool {
        self.verdict == Verdict::Changed && self.listed.iter().any(ListedNovelty::is_correct)
    }

    /// Whether the verdict is right and no false novelty is listed.
    pub fn is_correct(&self) -> bool {
        let expected = if self.is_changed() {
            Verdict::Changed
        } else {
            Verdict::Quiet
        };
        self.verdict == expected && self.listed.iter().all(ListedNovelty::is_correct)
    }
}

/// Compares an answer with the truth; `threshold` is that of its place, if it was judged by that.
pub fn score(
    pair: &SimulatedPair,
    engine: Engine,
    input: EngineInput,
    threshold: Option<&QuietThreshold>,
    answer: &Timed<Detection>,
) -> PairScore {
    let detection = &answer.answer;
    let side = |n: &Novelty| usize::from(n.kind == NoveltyKind::Appeared);
    let mut on = [0, 1].map(|s| vec![false; pair.labels[s].len()]);
    let mut listed = Vec::new();
    for novelty in &detection.novelties {
        let s = side(novelty);
        let label = |i: &usize| {
            pair.labels[s]
                .get(*i)
                .copied()
                .unwrap_or(PointLabel::Unchanged)
        };
        let is_true = |i: &&usize| {
            matches!(
                label(i),
                PointLabel::FreeSpace | PointLabel::BeyondFreeRange | PointLabel::NotVisible
            )
        };
        let counts = |i: &&usize| label(i) != PointLabel::OnSurface;
        for i in &novelty.point_indices {
            if let Some(is_listed) = on[s].get_mut(*i) {
                *is_listed = true;
            }
        }
        let points = novelty.point_indices.iter().filter(counts).count();
        listed.push(ListedNovelty {
            kind: novelty.kind,
            points,
            true_points: novelty.point_indices.iter().filter(is_true).count(),
            support: novelty.support,
            centre: novelty.moments.mean.coords.into(),
            extent: novelty.extent_m,
            contribution: novelty.contribution,
        });
    }
    let count = |label: PointLabel| {
        pair.labels
            .iter()
            .flatten()
            .filter(|l| **l == label)
            .count()
    };
    let (seen_points, beyond_points) = (
        count(PointLabel::FreeSpace),
        count(PointLabel::BeyondFreeRange),
    );
    let true_points = seen_points + beyond_points + count(PointLabel::NotVisible);
    let (shift_error_m, turn_error_deg) = registration_error(
        &pair.current_from_reference,
        &detection.registration.current_from_reference,
        &pair.sweeps[0].view.origin,
        &detection.registration.unobservable,
    );
    PairScore {
        plan: pair.plan,
        change_description: pair.change_description.clone(),
        engine,
        input,
        verdict: detection.verdict,
        reason: detection.reason.clone(),
        d_gmm: detection.d_gmm,
        u_th: detection.u_th,
        unobserved_visits: threshold.map_or(0, |t| t.unobserved),
        unexplained: detection.unexplained,
        iou: overlap(&pair.labels, &on, &[PointLabel::OnSurface]).filter(|_| true_points > 0),
        iou_seen: overlap(
            &pair.labels,
            &on,
            &[
                PointLabel::OnSurface,
                PointLabel::NotVisible,
                PointLabel::BeyondFreeRange,
            ],
        )
        .filter(|_| seen_points > 0),
        listed,
        true_points,
        seen_points,
        beyond_points,
        shift_error_m,
        turn_error_deg,
        pose_chi2: pose_chi2(&pair.current_from_reference, &detection.registration),
        unobservable: detection.registration.unobservable.clone(),
        share: detection.registration.agreement,
        share_by_direction: detection.registration.agreement_by_direction,
        disagreement: detection.disagreement,
        verdict_ms: answer.answer_ms,
        stored_bytes: answer.stored_bytes,
    }
}

/// Intersection over union of listed and true points, without points of the labels `without`.
fn overlap(
    labels: &[Vec<PointLabel>; 2],
    on: &[Vec<bool>; 2],
    without: &[PointLabel],
) -> Option<f64> {
    let (mut both, mut either) = (0usize, 0usize);
    for (label, on) in labels.iter().flatten().zip(on.iter().flatten()) {
        if without.contains(label) {
            continue;
        }
        let changed = *label != PointLabel::Unchanged;
        both += usize::from(changed && *on);
        either += usize::from(changed || *on);
    }
    (either > 0).then(|| both as f64 / either as f64)
}

/// Error of `found` at the laser, metres and degrees, without the unobservable directions.
fn registration_error(
    truth: &Pose,
    found: &Pose,
    origin: &Point3<f64>,
    unobservable: &[String],
) -> (f64, f64) {
    let off = truth.inverse() * found;
    let mut shift: Vector3<f64> = off * origin - origin;
    let mut rotation = off.rotation.scaled_axis();
    for text in unobservable {
        let Some((about, axis)) = parse_direction(text) else {
            continue;
        };
        let error = if about { &mut rotation } else { &mut shift };
        *error -= axis * axis.dot(error);
    }
    (shift.norm(), rotation.norm().to_degrees())
}

/// Squared error of the pose in units of the stated covariance: chi-square with six degrees of freedom where that is true.
fn pose_chi2(truth: &Pose, found: &Registration) -> f64 {
    let back = Translation3::from(-found.reference_origin.coords);
    let off = back * (found.current_from_reference.inverse() * truth) * back.inverse();
    let (shift, turn) = (off.translation.vector, off.rotation.scaled_axis());
    let error = Vector6::new(shift.x, shift.y, shift.z, turn.x, turn.y, turn.z);
    found
        .covariance
        .cholesky()
        .map_or(f64::INFINITY, |c| error.dot(&c.solve(&error)))
}

/// The direction in "along (0.99, 0.05, 0.00)", and whether it is an axis of rotation ("about ...").
fn parse_direction(text: &str) -> Option<(bool, Vector3<f64>)> {
    let (kind, rest) = text.split_once('(')?;
    let (numbers, _) = rest.split_once(')')?;
    let numbers: Vec<f64> = numbers
        .split(',')
        .map(|n| n.trim().parse())
        .collect::<Result<_, _>>()
        .ok()?;
    let axis = Vector3::from_column_slice(numbers.get(..3)?).try_normalize(1e-6)?;
    Some((kind.trim() == "about", axis))
}

#[cfg(test)]
mod tests {
    use super::{PointLabel, overlap, parse_direction, registration_error};
    use nalgebra::{Point3, Vector3};
    use patrold_engine::geometry::Pose;

    #[test]
    fn directions_are_parsed() {
        assert_eq!(
            parse_direction("along (0.00, 1.00, 0.00)"),
            Some((false, Vector3::y()))
        );
        assert_eq!(
            parse_direction("about (0.00, 0.00, -2.00)"),
            Some((true, -Vector3::z()))
        );
        assert_eq!(parse_direction("sideways"), None);
        assert_eq!(parse_direction("along (a, b, c)"), None);
    }

    #[test]
    fn unobservable_directions_are_no_error() {
        let found = Pose::new(Vector3::new(0.03, 0.04, 0.0), Vector3::z() * 0.01);
        let error = |unobservable: &[&str]| {
            let unobservable: Vec<String> = unobservable.iter().map(|t| (*t).to_owned()).collect();
            registration_error(&Pose::identity(), &found, &Point3::origin(), &unobservable)
        };
        assert!((error(&[]).0 - 0.05).abs() < 1e-12);
        assert!((error(&[]).1 - 0.01_f64.to_degrees()).abs() < 1e-12);
        assert!((error(&["along (1, 0, 0)"]).0 - 0.04).abs() < 1e-12);
        assert!(error(&["about (0, 0, 1)"]).1 < 1e-12);
    }

    #[test]
    fn overlap_leaves_out_the_given_labels() {
        use PointLabel::{FreeSpace, NotVisible, OnSurface, Unchanged};
        let labels = [
            vec![FreeSpace, FreeSpace, Unchanged],
            vec![OnSurface, NotVisible, Unchanged, FreeSpace],
        ];
        let on = [vec![true, false, false], vec![true, true, true, true]];
        assert_eq!(overlap(&labels, &on, &[OnSurface]), Some(0.6));
        assert_eq!(overlap(&labels, &on, &[OnSurface, NotVisible]), Some(0.5));
        let none = [Vec::new(), vec![Unchanged]];
        assert_eq!(overlap(&none, &[Vec::new(), vec![false]], &[]), None);
    }
}
