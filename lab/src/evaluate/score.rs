//! What a judged pair is worth, held against its truth.

use super::judge::{Engine, Given, Judged};
use super::pair::Pair;
use super::plan::Planned;
use super::truth::Label;
use nalgebra::{Point3, Vector3};
use patrold_engine::geometry::Pose;
use patrold_engine::novelty::{Kind, Novelty, Verdict};

/// A listed novelty against the truth.
#[derive(Debug, Clone, PartialEq)]
pub struct Listed {
    /// Came or went.
    pub kind: Kind,
    /// Its points.
    pub points: usize,
    /// Points of it that truly came or went.
    pub true_points: usize,
    /// Its support.
    pub support: f64,
    /// Its mean, the revisit's frame, metres.
    pub centre: [f64; 3],
    /// Its box along the axes, metres.
    pub extent: [f64; 3],
    /// Its share of d_GMM.
    pub contribution: f64,
}

impl Listed {
    /// Whether at least half of its points truly came or went.
    pub fn right(&self) -> bool {
        2 * self.true_points >= self.points
    }
}

/// One pair judged in one way.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// The pair.
    pub planned: Planned,
    /// Its change in a word or two.
    pub told: String,
    /// Judged by which engine.
    pub engine: Engine,
    /// From what.
    pub given: Given,
    /// The verdict.
    pub verdict: Verdict,
    /// Why.
    pub reason: String,
    /// d_GMM.
    pub d_gmm: f64,
    /// The part of d_GMM that no novelty explains.
    pub unexplained: f64,
    /// What was listed.
    pub listed: Vec<Listed>,
    /// Points that truly came or went, of both clouds.
    pub true_points: usize,
    /// Those where the other visit looked.
    pub seen_points: usize,
    /// Those where it looked, got nothing back, and was too far off for that to prove anything.
    pub beyond_points: usize,
    /// Listed points over both clouds against the true ones: intersection over union. `None` of quiet pairs.
    pub iou: Option<f64>,
    /// The same, where what the other visit could not see counts neither way.
    pub iou_seen: Option<f64>,
    /// How far the registration is off in directions that it claims to know, metres.
    pub shift_error_m: f64,
    /// The same as an angle, degrees.
    pub turn_error_deg: f64,
    /// Directions that it does not claim to know.
    pub unobservable: Vec<String>,
    /// Share of the surface that the registration explains.
    pub share: f64,
    /// Noise between the views over their own.
    pub disagreement: f64,
    /// Making the reference ready, milliseconds.
    pub prepare_ms: f64,
    /// From view to verdict, milliseconds.
    pub verdict_ms: f64,
}

impl Outcome {
    /// Whether something came, went or moved.
    pub fn changed(&self) -> bool {
        self.true_points > 0
    }

    /// Whether the verdict is the wanted one and nothing false is listed.
    pub fn good(&self) -> bool {
        let wanted = if self.changed() {
            Verdict::Changed
        } else {
            Verdict::Quiet
        };
        self.verdict == wanted && self.listed.iter().all(Listed::right)
    }
}

/// Holds a judgement against the truth.
pub fn score(pair: &Pair, engine: Engine, given: Given, judged: &Judged) -> Outcome {
    let detection = &judged.detection;
    let side = |n: &Novelty| usize::from(n.kind == Kind::Appeared);
    let mut on = [0, 1].map(|s| vec![false; pair.labels[s].len()]);
    let mut listed = Vec::new();
    for novelty in &detection.novelties {
        let s = side(novelty);
        let label = |i: &usize| pair.labels[s].get(*i).copied().unwrap_or(Label::Other);
        let is_true = |i: &&usize| matches!(label(i), Label::Seen | Label::Beyond | Label::Hidden);
        let counts = |i: &&usize| label(i) != Label::Same;
        for i in &novelty.points {
            if let Some(place) = on[s].get_mut(*i) {
                *place = true;
            }
        }
        let points = novelty.points.iter().filter(counts).count();
        listed.push(Listed {
            kind: novelty.kind,
            points,
            true_points: novelty.points.iter().filter(is_true).count(),
            support: novelty.support,
            centre: novelty.moments.mean.coords.into(),
            extent: novelty.extent_m,
            contribution: novelty.contribution,
        });
    }
    let of = |wanted: &[Label]| {
        let all = pair.labels.iter().flatten();
        all.filter(|l| wanted.contains(l)).count()
    };
    let (seen_points, beyond_points) = (of(&[Label::Seen]), of(&[Label::Beyond]));
    let true_points = seen_points + beyond_points + of(&[Label::Hidden]);
    let (shift_error_m, turn_error_deg) = registration_error(
        &pair.current_from_reference,
        &detection.registration.current_from_reference,
        &pair.sweeps[0].view.origin,
        &detection.registration.unobservable,
    );
    Outcome {
        planned: pair.planned,
        told: pair.told.clone(),
        engine,
        given,
        verdict: detection.verdict,
        reason: detection.reason.clone(),
        d_gmm: detection.d_gmm,
        unexplained: detection.unexplained,
        iou: overlap(&pair.labels, &on, &[Label::Same]).filter(|_| true_points > 0),
        iou_seen: overlap(
            &pair.labels,
            &on,
            &[Label::Same, Label::Hidden, Label::Beyond],
        )
        .filter(|_| seen_points > 0),
        listed,
        true_points,
        seen_points,
        beyond_points,
        shift_error_m,
        turn_error_deg,
        unobservable: detection.registration.unobservable.clone(),
        share: detection.registration.share,
        disagreement: detection.disagreement,
        prepare_ms: judged.prepare_ms,
        verdict_ms: judged.verdict_ms,
    }
}

/// Intersection over union of listed and true points, leaving out those with one of these labels.
fn overlap(labels: &[Vec<Label>; 2], on: &[Vec<bool>; 2], without: &[Label]) -> Option<f64> {
    let (mut both, mut either) = (0usize, 0usize);
    for (label, on) in labels.iter().flatten().zip(on.iter().flatten()) {
        if without.contains(label) {
            continue;
        }
        let truly = *label != Label::Other;
        both += usize::from(truly && *on);
        either += usize::from(truly || *on);
    }
    (either > 0).then(|| both as f64 / either as f64)
}

/// How far `found` is from the truth at the laser, metres and degrees, without the directions told as unobservable.
fn registration_error(
    truth: &Pose,
    found: &Pose,
    origin: &Point3<f64>,
    unobservable: &[String],
) -> (f64, f64) {
    let off = truth.inverse() * found;
    let mut shift: Vector3<f64> = off * origin - origin;
    let mut turn = off.rotation.scaled_axis();
    for told in unobservable {
        let Some((about, axis)) = direction(told) else {
            continue;
        };
        let which = if about { &mut turn } else { &mut shift };
        *which -= axis * axis.dot(which);
    }
    (shift.norm(), turn.norm().to_degrees())
}

/// The direction in "along (0.99, 0.05, 0.00)", and whether it is a turn ("about ...").
fn direction(told: &str) -> Option<(bool, Vector3<f64>)> {
    let (word, rest) = told.split_once('(')?;
    let (numbers, _) = rest.split_once(')')?;
    let numbers: Vec<f64> = numbers
        .split(',')
        .map(|n| n.trim().parse())
        .collect::<Result<_, _>>()
        .ok()?;
    let axis = Vector3::from_column_slice(numbers.get(..3)?).try_normalize(1e-6)?;
    Some((word.trim() == "about", axis))
}

#[cfg(test)]
mod tests {
    use super::{Label, direction, overlap, registration_error};
    use nalgebra::{Point3, Vector3};
    use patrold_engine::geometry::Pose;

    #[test]
    fn told_directions_are_read() {
        assert_eq!(
            direction("along (0.00, 1.00, 0.00)"),
            Some((false, Vector3::y()))
        );
        assert_eq!(
            direction("about (0.00, 0.00, -2.00)"),
            Some((true, -Vector3::z()))
        );
        assert_eq!(direction("sideways"), None);
        assert_eq!(direction("along (a, b, c)"), None);
    }

    #[test]
    fn what_a_registration_does_not_claim_is_no_error() {
        let found = Pose::new(Vector3::new(0.03, 0.04, 0.0), Vector3::z() * 0.01);
        let error = |told: &[&str]| {
            let told: Vec<String> = told.iter().map(|t| (*t).to_owned()).collect();
            registration_error(&Pose::identity(), &found, &Point3::origin(), &told)
        };
        assert!((error(&[]).0 - 0.05).abs() < 1e-12);
        assert!((error(&[]).1 - 0.01_f64.to_degrees()).abs() < 1e-12);
        assert!((error(&["along (1, 0, 0)"]).0 - 0.04).abs() < 1e-12);
        assert!(error(&["about (0, 0, 1)"]).1 < 1e-12);
    }

    #[test]
    fn overlap_leaves_out_what_counts_neither_way() {
        use Label::{Hidden, Other, Same, Seen};
        let labels = [vec![Seen, Seen, Other], vec![Same, Hidden, Other, Seen]];
        let on = [vec![true, false, false], vec![true, true, true, true]];
        assert_eq!(overlap(&labels, &on, &[Same]), Some(0.6));
        assert_eq!(overlap(&labels, &on, &[Same, Hidden]), Some(0.5));
        let none = [Vec::new(), vec![Other]];
        assert_eq!(overlap(&none, &[Vec::new(), vec![false]], &[]), None);
    }
}
