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
