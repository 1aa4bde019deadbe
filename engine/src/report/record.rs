//! Novelties and shapes in the form of the contract (`docs/contract.md`): what JSON and the log show.

use super::figure;
use crate::geometry::Pose;
use crate::novelty::{Kind, Novelty};
use crate::shape::{Class, Method, Retrieval, Shape};
use nalgebra::{Matrix3, Point3, Vector3};
use serde::{Deserialize, Serialize};

/// A class with its probability.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AlternativeRecord {
    /// The class.
    pub class: String,
    /// Its posterior probability.
    #[serde(deserialize_with = "figure::one")]
    pub probability: f64,
}

/// One retrieved shape.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ShapeRecord {
    /// What it is.
    pub class: String,
    /// How it was found.
    pub method: String,
    /// Posterior probability of the class.
    #[serde(deserialize_with = "figure::one")]
    pub probability: f64,
    /// The other classes.
    pub alternatives: Vec<AlternativeRecord>,
    /// Centre, metres.
    #[serde(deserialize_with = "figure::three")]
    pub centre: [f64; 3],
    /// Its standard deviation, metres.
    #[serde(deserialize_with = "figure::three")]
    pub centre_sd: [f64; 3],
    /// Rows of the rotation whose columns are the shape's axes.
    #[serde(deserialize_with = "figure::nine")]
    pub rotation: [[f64; 3]; 3],
    /// Full lengths along the axes, metres.
    #[serde(deserialize_with = "figure::three")]
    pub size: [f64; 3],
    /// Their standard deviations, metres.
    #[serde(deserialize_with = "figure::three")]
    pub size_sd: [f64; 3],
    /// e1 and e2 of a superquadric.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exponents: Option<[f64; 2]>,
    /// Root mean square distance of its points, metres.
    #[serde(deserialize_with = "figure::one")]
    pub residual_m: f64,
    /// Points on it.
    pub inliers: usize,
}

/// The answers of both methods side by side.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, Default)]
pub struct MethodsRecord {
    /// Covariance matching.
    pub covariance: Option<ShapeRecord>,
    /// RANSAC.
    pub ransac: Option<ShapeRecord>,
}

/// One thing that came or went.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NoveltyRecord {
    /// `appeared` or `disappeared`.
    pub kind: String,
    /// Index of the disappeared novelty that this is the same thing as.
    pub moved_from: Option<usize>,
    /// Mean of its points, metres.
    #[serde(deserialize_with = "figure::three")]
    pub centre: [f64; 3],
    /// Covariance of its points, square metres.
    #[serde(deserialize_with = "figure::nine")]
    pub covariance: [[f64; 3]; 3],
    /// Axis-aligned extent of its points, metres.
    #[serde(deserialize_with = "figure::three")]
    pub extent: [f64; 3],
    /// How many points it has.
    pub points: usize,
    /// Its share of the commonly visible mass.
    #[serde(deserialize_with = "figure::one")]
    pub mass: f64,
    /// Its part of d_GMM.
    #[serde(deserialize_with = "figure::one")]
    pub contribution: f64,
    /// Summed evidence of its points.
    #[serde(deserialize_with = "figure::one")]
    pub support: f64,
    /// Its shape; null where it has too few points for one.
    pub shape: Option<ShapeRecord>,
    /// Each method's own answer.
    pub shapes: MethodsRecord,
    /// Several primitives where one does not do.
    pub parts: Vec<ShapeRecord>,
}

impl NoveltyRecord {
    /// The contract's form of a novelty and what was retrieved for it.
    pub fn new(novelty: &Novelty, retrieval: Option<&Retrieval>) -> Self {
        let by = |shape: Option<&Shape>| shape.map(ShapeRecord::new);
        Self {
            kind: kind_word(novelty.kind).to_owned(),
            moved_from: novelty.moved_from,
            centre: novelty.moments.mean.coords.into(),
            covariance: rows(&novelty.moments.covariance),
            extent: novelty.extent_m,
            points: novelty.points.len(),
            mass: novelty.mass,
            contribution: novelty.contribution,
            support: novelty.support,
            shape: by(retrieval.map(|r| &r.best)),
            shapes: MethodsRecord {
                covariance: by(retrieval.and_then(|r| r.covariance.as_ref())),
                ransac: by(retrieval.and_then(|r| r.ransac.as_ref())),
            },
            parts: retrieval
                .map_or_else(Vec::new, |r| r.parts.iter().map(ShapeRecord::new).collect()),
        }
    }

    /// The contract's form of a novelty in another frame than that of the revisit, its extent along that frame's
    /// axes.
    pub fn new_in(
        novelty: &Novelty,
        retrieval: Option<&Retrieval>,
        other_from_this: &Pose,
    ) -> Self {
        let record = Self::new(novelty, retrieval).in_frame(other_from_this);
        let mut places = novelty.places.iter().map(|p| other_from_this * p);
        let Some(first) = places.next() else {
            return record;
        };
        let (low, high) = places.fold((first, first), |(low, high), p| (low.inf(&p), high.sup(&p)));
        Self {
            extent: (high - low).into(),
            ..record
        }
    }

    /// The same novelty in another frame. Its extent stays along the axes of the frame it was measured in, for the
    /// record has no points to measure it anew: [`NoveltyRecord::new_in`] has.
    pub fn in_frame(&self, other_from_this: &Pose) -> Self {
        let turn = other_from_this.rotation.to_rotation_matrix();
        let covariance = turn.matrix() * matrix(&self.covariance) * turn.matrix().transpose();
        let shape = |s: &ShapeRecord| s.in_frame(other_from_this);
        Self {
            centre: moved(other_from_this, self.centre),
            covariance: rows(&covariance),
            shape: self.shape.as_ref().map(shape),
            shapes: MethodsRecord {
                covariance: self.shapes.covariance.as_ref().map(shape),
                ransac: self.shapes.ransac.as_ref().map(shape),
            },
            parts: self.parts.iter().map(shape).collect(),
            ..self.clone()
        }
    }
}

impl ShapeRecord {
    /// The contract's form of a shape.
    pub fn new(shape: &Shape) -> Self {
        let alternative = |a: &crate::shape::Alternative| AlternativeRecord {
            class: class_word(a.class).to_owned(),
            probability: a.probability,
        };
        Self {
            class: class_word(shape.class).to_owned(),
            method: method_word(shape.method).to_owned(),
            probability: shape.probability,
            alternatives: shape.alternatives.iter().map(alternative).collect(),
            centre: shape.centre.coords.into(),
            centre_sd: shape.centre_sd_m,
            rotation: rows(&shape.rotation),
            size: shape.size_m,
            size_sd: shape.size_sd_m,
            exponents: shape.exponents,
            residual_m: shape.residual_m,
            inliers: shape.inliers,
        }
    }

    fn in_frame(&self, other_from_this: &Pose) -> Self {
        let turn = other_from_this.rotation.to_rotation_matrix();
        Self {
            centre: moved(other_from_this, self.centre),
            centre_sd: turned_sd(turn.matrix(), self.centre_sd),
            rotation: rows(&(turn.matrix() * matrix(&self.rotation))),
            ..self.clone()
        }
    }
}

/// Standard deviations along the turned axes, those along the old ones taken as independent.
fn turned_sd(turn: &Matrix3<f64>, sd: [f64; 3]) -> [f64; 3] {
    let variances = Matrix3::from_diagonal(&Vector3::from(sd.map(|s| s * s)));
    let turned = turn * variances * turn.transpose();
    [0, 1, 2].map(|axis| turned[(axis, axis)].max(0.0).sqrt())
}

fn moved(pose: &Pose, p: [f64; 3]) -> [f64; 3] {
    (pose * Point3::from(p)).coords.into()
}

fn rows(m: &Matrix3<f64>) -> [[f64; 3]; 3] {
    std::array::from_fn(|r| std::array::from_fn(|c| m[(r, c)]))
}

fn matrix(rows: &[[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|r, c| rows[r][c])
}

/// `appeared` or `disappeared`.
pub fn kind_word(kind: Kind) -> &'static str {
    match kind {
        Kind::Appeared => "appeared",
        Kind::Disappeared => "disappeared",
    }
}

/// The class in the contract's words.
pub fn class_word(class: Class) -> &'static str {
    match class {
        Class::Sphere => "sphere",
        Class::Cylinder => "cylinder",
        Class::Plane => "plane",
        Class::Box => "box",
        Class::Cone => "cone",
        Class::Superquadric => "superquadric",
        Class::Ambiguous => "ambiguous",
    }
}

/// The method in the contract's words.
pub fn method_word(method: Method) -> &'static str {
    match method {
        Method::Ransac => "ransac",
        Method::Covariance => "covariance",
    }
}

#[cfg(test)]
mod tests {
    use super::{NoveltyRecord, turned_sd};
    use crate::geometry::RollPitchYaw;
    use crate::mixture::{Gaussian, Mixture};
    use crate::novelty::{Kind, Novelty, Rim};
    use nalgebra::{Matrix3, Point3, Vector3};

    fn novelty(places: Vec<Point3<f64>>) -> Novelty {
        Novelty {
            kind: Kind::Appeared,
            moved_from: None,
            points: vec![1, 2, 3],
            places,
            moments: Gaussian {
                mean: Point3::new(1.0, 2.0, 3.0),
                covariance: Matrix3::from_diagonal(&Vector3::new(1.0, 2.0, 3.0)),
            },
            mixture: Mixture::default(),
            extent_m: [1.0, 2.0, 3.0],
            rim: Rim::default(),
            mass: 0.1,
            contribution: 0.2,
            support: 300.0,
        }
    }

    #[test]
    fn extent_and_deviations_follow_the_axes_of_the_frame() {
        let quarter = RollPitchYaw {
            roll_rad: 0.0,
            pitch_rad: 0.0,
            yaw_rad: std::f64::consts::FRAC_PI_2,
        }
        .with_translation([4.0, 5.0, 6.0]);
        let places = vec![Point3::origin(), Point3::new(3.0, 1.0, 2.0)];
        let record = NoveltyRecord::new_in(&novelty(places), None, &quarter);
        for (got, expected) in record.extent.into_iter().zip([1.0, 3.0, 2.0]) {
            assert!((got - expected).abs() < 1e-12);
        }
        let turned = turned_sd(
            quarter.rotation.to_rotation_matrix().matrix(),
            [0.1, 0.2, 0.3],
        );
        for (got, expected) in turned.into_iter().zip([0.2, 0.1, 0.3]) {
            assert!((got - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn a_figure_that_is_not_finite_is_null_and_reads_back() {
        let mut record = NoveltyRecord::new(&novelty(Vec::new()), None);
        record.centre[1] = f64::NAN;
        record.covariance[0][2] = f64::INFINITY;
        record.support = f64::NAN;
        let text = serde_json::to_string(&record).expect("JSON");
        let back: NoveltyRecord = serde_json::from_str(&text).expect("reads");
        assert!(back.centre[1].is_nan() && back.covariance[0][2].is_nan() && back.support.is_nan());
        assert_eq!(back.mass, record.mass);
    }

    #[test]
    fn there_and_back_is_the_same_record() {
        let record = NoveltyRecord::new(&novelty(Vec::new()), None);
        let pose = RollPitchYaw {
            roll_rad: 0.1,
            pitch_rad: 0.2,
            yaw_rad: 0.3,
        }
        .with_translation([4.0, 5.0, 6.0]);
        let moved = record.in_frame(&pose);
        assert!((moved.centre[0] - record.centre[0]).abs() > 1.0);
        let back = moved.in_frame(&pose.inverse());
        for axis in 0..3 {
            assert!((back.centre[axis] - record.centre[axis]).abs() < 1e-12);
            assert!((back.covariance[axis][axis] - record.covariance[axis][axis]).abs() < 1e-12);
        }
    }
}
