//! Counts and errors over scenes, as in a column of Tables I and II.

use super::score::SceneScore;
use crate::statistics::{mean, median, rms};
use serde::Serialize;

/// Counts and errors over scenes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ColumnSummary {
    /// Scenes with an object.
    pub objects: usize,
    /// Scenes without.
    pub empty: usize,
    /// Shapes reported in all of them, `ambiguous` left out.
    pub shapes: usize,
    /// Objects reported with their class.
    pub right: usize,
    /// Objects reported as ambiguous.
    pub ambiguous: usize,
    /// Reported shapes that do not exist.
    pub wrong: usize,
    /// Share of the objects reported with their class of those not reported as ambiguous; null if there are none.
    pub definite: Option<f64>,
    /// Share of the objects reported as ambiguous; null without objects.
    pub ambiguous_share: Option<f64>,
    /// TruePos and FalsePos (paper Eq. 14) with `NumberShapes` read as the number of true objects, as in Table I; without
    /// objects, of scenes.
    pub per_object: [f64; 2],
    /// The same with `NumberShapes` as printed: the reported shapes.
    pub per_shape: [f64; 2],
    /// Root mean square error of the sizes, centimetres, over shapes of the right class.
    pub size_cm: [Option<f64>; 3],
    /// Mean error of the sizes, centimetres.
    pub size_bias_cm: [Option<f64>; 3],
    /// Median error of the sizes as a share of the true size.
    pub size_share: Option<f64>,
    /// Root mean square rotation about the axes of the shape, degrees.
    pub rotation_deg: [Option<f64>; 3],
    /// Share of sizes within their 95 % interval.
    pub coverage: Option<f64>,
    /// Median time from the current view to the answer, milliseconds.
    pub chain_ms: f64,
    /// Median time of preparing the reference, milliseconds.
    pub reference_ms: f64,
    /// Mean bytes of the reference as the store keeps it: its mixture, and its view.
    pub bytes: [f64; 2],
}

impl ColumnSummary {
    /// Over these scenes.
    pub fn of_scores<'a>(scores: impl Iterator<Item = &'a SceneScore> + Clone) -> Self {
        let count = |of: fn(&SceneScore) -> usize| scores.clone().map(of).sum::<usize>();
        let median_of = |of: fn(&SceneScore) -> f64| median(scores.clone().map(of)).unwrap_or(0.0);
        let scenes = scores.clone().count().max(1) as f64;
        let covered = scores
            .clone()
            .fold([0; 2], |[a, b], s| [a + s.covered[0], b + s.covered[1]]);
        let size_errors_m = |k: usize| scores.clone().filter_map(move |s| s.size_error_m?[k]);
        let rotations_rad = |k: usize| scores.clone().filter_map(move |s| s.rotation_error_rad?[k]);
        let size_shares = scores.clone().filter_map(|s| s.size_share);
        let objects = count(|s| usize::from(s.has_object));
        let empty = count(|s| usize::from(!s.has_object));
        let shapes = count(|s| s.shapes);
        let right = count(|s| usize::from(s.right));
        let ambiguous = count(|s| usize::from(s.ambiguous));
        let wrong = count(|s| s.wrong);
        let definite = objects - ambiguous;
        let rates = |number: usize| [right, wrong].map(|n| n as f64 / number.max(1) as f64);
        Self {
            objects,
            empty,
            shapes,
            right,
            ambiguous,
            wrong,
            definite: (definite > 0).then(|| right as f64 / definite as f64),
            ambiguous_share: (objects > 0).then(|| ambiguous as f64 / objects as f64),
            per_object: rates(if objects > 0 { objects } else { empty }),
            per_shape: rates(shapes),
            size_cm: [0, 1, 2].map(|k| rms(size_errors_m(k)).map(|e| 100.0 * e)),
            size_bias_cm: [0, 1, 2].map(|k| mean(size_errors_m(k)).map(|e| 100.0 * e)),
            size_share: median(size_shares.flatten().flatten()),
            rotation_deg: [0, 1, 2].map(|k| rms(rotations_rad(k)).map(f64::to_degrees)),
            coverage: (covered[1] > 0).then(|| covered[0] as f64 / covered[1] as f64),
            chain_ms: median_of(|s| s.chain_ms),
            reference_ms: median_of(|s| s.reference_ms),
            bytes: [0, 1].map(|k| scores.clone().map(|s| s.bytes[k] as f64).sum::<f64>() / scenes),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::ColumnSummary;
    use crate::reproduce::SceneScore;

    fn scored(has_object: bool, right: bool, wrong: usize) -> SceneScore {
        SceneScore {
            name: String::new(),
            has_object,
            shapes: wrong + usize::from(right),
            right,
            ambiguous: false,
            wrong,
            class: None,
            size_error_m: right.then_some([Some(0.03), Some(-0.04), None]),
            size_share: right.then_some([Some(0.1), Some(0.2), None]),
            rotation_error_rad: None,
            covered: [usize::from(right), 2 * usize::from(right)],
            chain_ms: 1.0,
            reference_ms: 2.0,
            bytes: [40, 4800],
        }
    }

    #[test]
    fn both_readings_of_equation_14_are_counted() {
        let scores = [
            scored(true, true, 0),
            scored(true, true, 1),
            scored(true, false, 1),
            scored(true, false, 0),
            scored(false, false, 1),
        ];
        let summary = ColumnSummary::of_scores(scores.iter());
        // Two objects right, two sizes each: the upper of the two in the middle.
        assert_eq!(summary.size_share, Some(0.2));
        assert_eq!((summary.objects, summary.empty, summary.shapes), (4, 1, 5));
        assert_eq!(summary.per_object, [0.5, 0.75]);
        assert_eq!(summary.per_shape, [0.4, 0.6]);
        assert!((summary.size_cm[1].expect("sizes") - 4.0).abs() < 1e-12);
        assert!((summary.size_bias_cm[0].expect("sizes") - 3.0).abs() < 1e-12);
        assert_eq!((summary.size_cm[2], summary.coverage), (None, Some(0.5)));
    }

    #[test]
    fn ambiguous_is_no_miss_of_the_class() {
        let ambiguous = SceneScore {
            ambiguous: true,
            ..scored(true, false, 0)
        };
        let scores = [
            scored(true, true, 0),
            ambiguous.clone(),
            scored(true, false, 1),
            scored(false, false, 0),
        ];
        let summary = ColumnSummary::of_scores(scores.iter());
        assert_eq!(summary.definite, Some(0.5));
        assert_eq!(summary.ambiguous_share, Some(1.0 / 3.0));
        assert_eq!(ColumnSummary::of_scores([ambiguous].iter()).definite, None);
        let empty = ColumnSummary::of_scores(scores[3..].iter());
        assert_eq!((empty.definite, empty.ambiguous_share), (None, None));
    }
}
