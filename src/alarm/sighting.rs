//! A novelty of a visit as far as needed to recognize the thing later, with the uncertainty of each figure.

use super::constants::{
    BODY_SD_M, BODY_SD_SHARE, CENTRE_SD_M, DEPTH_SD_M, WIDTH_SD_M, WIDTH_SD_SHARE,
};
use nalgebra::{Matrix3, Point3, SymmetricEigen};
use patrold_engine::novelty::NoveltyKind;
use patrold_engine::report::{NoveltyRecord, ShapeRecord};

/// Classes of shapes, in the order of [`Sighting::classes`].
pub const SHAPE_CLASSES: [&str; 6] = ["sphere", "cylinder", "plane", "box", "cone", "superquadric"];

/// Three full lengths, the longest first, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lengths {
    /// The lengths.
    pub m: [f64; 3],
    /// Their standard deviations.
    pub sd_m: [f64; 3],
}

/// One thing as one visit saw it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    /// Appeared or disappeared.
    pub kind: NoveltyKind,
    /// Mean of its points in the waypoint's reference frame, metres.
    pub centre: Point3<f64>,
    /// Standard deviation of that mean from one visit to another, along the axes of the frame.
    pub centre_sd_m: [f64; 3],
    /// Covariance of its points, square metres.
    pub spread: Matrix3<f64>,
    /// Widths of its points along their principal axes: of the part that is seen.
    pub widths: Lengths,
    /// Lengths of the whole thing, by its shape.
    pub body: Option<Lengths>,
    /// Probabilities of [`SHAPE_CLASSES`]; their sum is 1.
    pub classes: [f64; SHAPE_CLASSES.len()],
}

impl Sighting {
    /// What a record of the log says, in the frame of the record.
    pub fn new(novelty: &NoveltyRecord) -> Self {
        let spread = Matrix3::from_fn(|row, column| novelty.covariance[row][column]);
        let shape = novelty.shape.as_ref();
        let pose_sd = novelty.pose_sd.unwrap_or_default();
        Self {
            kind: if novelty.kind == NoveltyKind::Disappeared.as_str() {
                NoveltyKind::Disappeared
            } else {
                NoveltyKind::Appeared
            },
            centre: Point3::from(novelty.centre),
            centre_sd_m: [0, 1, 2].map(|axis| {
                // Neighbouring points share their errors: the shape's figure, where there is one, knows.
                let own = shape.map_or(0.0, |s| s.centre_sd[axis]);
                finite_or_zero(own)
                    .hypot(finite_or_zero(pose_sd[axis]))
                    .hypot(CENTRE_SD_M)
            }),
            spread,
            widths: widths_of(&spread),
            body: shape.and_then(body_of),
            classes: shape.map_or([1.0 / 6.0; 6], class_probabilities),
        }
    }
}

fn finite_or_zero(x: f64) -> f64 {
    if x.is_finite() { x } else { 0.0 }
}

/// Those of a box with this covariance.
fn widths_of(spread: &Matrix3<f64>) -> Lengths {
    let values = if spread.iter().all(|x| x.is_finite()) {
        SymmetricEigen::new(*spread).eigenvalues
    } else {
        // A record that cannot be read any more.
        nalgebra::Vector3::zeros()
    };
    let mut m: [f64; 3] = [0, 1, 2].map(|axis| {
        let variance: f64 = values[axis];
        (12.0 * variance.max(0.0)).sqrt()
    });
    m.sort_by(|a, b| b.total_cmp(a));
    let mut sd_m = m.map(|width| WIDTH_SD_M.hypot(WIDTH_SD_SHARE * width));
    sd_m[2] = sd_m[2].hypot(DEPTH_SD_M);
    Lengths { m, sd_m }
}

/// `None` for a figure that is not finite.
fn body_of(shape: &ShapeRecord) -> Option<Lengths> {
    let mut lengths = [0, 1, 2].map(|axis| (shape.size[axis], shape.size_sd[axis]));
    let finite = |(size, sd): &(f64, f64)| size.is_finite() && sd.is_finite();
    if !lengths.iter().all(finite) {
        return None;
    }
    lengths.sort_by(|a, b| b.0.total_cmp(&a.0));
    let m = lengths.map(|(size, _)| size);
    let mut sd_m = lengths.map(|(size, sd)| sd.hypot(BODY_SD_SHARE * size).hypot(BODY_SD_M));
    if shape.class == "plane" {
        // What a flat front hides may be as deep as it is wide.
        sd_m[2] = sd_m[2].hypot(m[1]);
    }
    Some(Lengths { m, sd_m })
}

/// What the shape states, as probabilities; what it states of no class is shared by all.
fn class_probabilities(shape: &ShapeRecord) -> [f64; SHAPE_CLASSES.len()] {
    let stated = SHAPE_CLASSES.map(|class| {
        let own = (shape.class == class).then_some(shape.probability);
        let rival = shape.alternatives.iter().find(|a| a.class == class);
        let probability = own.or(rival.map(|a| a.probability)).unwrap_or(0.0);
        finite_or_zero(probability).clamp(0.0, 1.0)
    });
    let total: f64 = stated.iter().sum();
    let rest = (1.0 - total).max(0.0) / SHAPE_CLASSES.len() as f64;
    stated.map(|p| (p + rest) / total.max(1.0))
}

#[cfg(test)]
mod tests {
    use super::{body_of, class_probabilities};
    use patrold_engine::report::{AlternativeRecord, ShapeRecord};

    fn shape(class: &str, probability: f64, rivals: &[(&str, f64)]) -> ShapeRecord {
        let rival = |(class, probability): &(&str, f64)| AlternativeRecord {
            class: (*class).to_owned(),
            probability: *probability,
        };
        ShapeRecord {
            class: class.to_owned(),
            method: "covariance".to_owned(),
            probability,
            alternatives: rivals.iter().map(rival).collect(),
            centre: [0.0; 3],
            centre_sd: [0.0; 3],
            rotation: [[0.0; 3]; 3],
            size: [0.2, 0.8, 0.4],
            size_sd: [0.0; 3],
            exponents: None,
            residual_m: 0.0,
            inliers: 10,
        }
    }

    /// In the order sphere, cylinder, plane, box, cone, superquadric.
    #[test]
    fn what_a_shape_states_of_no_class_is_shared_by_all() {
        let near = |shape: &ShapeRecord, expected: [f64; 6]| {
            let got = class_probabilities(shape);
            let is_near = got.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12);
            assert!(is_near, "{got:?} {expected:?}");
        };
        near(&shape("box", 1.0, &[]), [0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
        near(
            &shape("box", 0.5, &[("cone", 0.2)]),
            [0.05, 0.05, 0.05, 0.55, 0.25, 0.05],
        );
        near(
            &shape("ambiguous", f64::NAN, &[("sphere", 0.4)]),
            [0.5, 0.1, 0.1, 0.1, 0.1, 0.1],
        );
        // More than there is.
        near(
            &shape("box", 0.9, &[("plane", 0.6)]),
            [0.0, 0.0, 0.4, 0.6, 0.0, 0.0],
        );
    }

    #[test]
    fn a_front_may_be_as_deep_as_it_is_wide_and_a_body_is_as_it_says() {
        let near = |a: [f64; 3], b: [f64; 3]| {
            assert!(
                a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12),
                "{a:?} {b:?}"
            );
        };
        let body = body_of(&shape("box", 1.0, &[])).expect("a body");
        assert_eq!(body.m, [0.8, 0.4, 0.2]);
        let own = body.m.map(|m| f64::hypot(0.1 * m, 0.01));
        near(body.sd_m, own);
        let plane = body_of(&shape("plane", 1.0, &[])).expect("a body");
        near(plane.sd_m, [own[0], own[1], own[2].hypot(0.4)]);
        let mut broken = shape("box", 1.0, &[]);
        broken.size_sd[1] = f64::INFINITY;
        assert!(body_of(&broken).is_none());
    }
}
