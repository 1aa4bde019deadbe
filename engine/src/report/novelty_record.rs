//! Serialisable records of novelties and shapes (`docs/contract.md`).

use super::nullable;
use crate::geometry::Pose;
use crate::novelty::Novelty;
use crate::shape::{Class, Method, Retrieval, Shape};
use nalgebra::{Matrix3, Point3, Vector3};
use serde::{Deserialize, Serialize};

/// A rival class of a shape.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AlternativeRecord {
    /// Name of the class.
    pub class: String,
    /// Posterior probability, 0 to 1.
    #[serde(deserialize_with = "nullable::number")]
    pub probability: f64,
}

/// One retrieved shape.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ShapeRecord {
    /// Name of the class; `ambiguous` if none prevails.
    pub class: String,
    /// `covariance` or `ransac`.
    pub method: String,
    /// Posterior probability of the class, 0 to 1.
    #[serde(deserialize_with = "nullable::number")]
    pub probability: f64,
    /// The rival classes.
    pub alternatives: Vec<AlternativeRecord>,
    /// Centre, metres.
    #[serde(deserialize_with = "nullable::vector3")]
    pub centre: [f64; 3],
    /// Standard deviation of the centre, metres.
    #[serde(deserialize_with = "nullable::vector3")]
    pub centre_sd: [f64; 3],
    /// Rows of the rotation whose columns are the shape's axes.
    #[serde(deserialize_with = "nullable::matrix3")]
    pub rotation: [[f64; 3]; 3],
    /// Full lengths along the axes, metres.
    #[serde(deserialize_with = "nullable::vector3")]
    pub size: [f64; 3],
    /// Standard deviations of the lengths, metres.
    #[serde(deserialize_with = "nullable::vector3")]
    pub size_sd: [f64; 3],
    /// Exponents e1 and e2, of a superquadric only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exponents: Option<[f64; 2]>,
    /// Root mean square distance of its points from the surface, metres.
    #[serde(deserialize_with = "nullable::number")]
    pub residual_m: f64,
    /// Number of points on the surface.
    pub inliers: usize,
}

/// The answers of both methods side by side.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, Default)]
pub struct MethodsRecord {
    /// By matching moments.
    pub covariance: Option<ShapeRecord>,
    /// By RANSAC.
    pub ransac: Option<ShapeRecord>,
}

/// One listed novelty.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NoveltyRecord {
    /// `appeared` or `disappeared`.
    pub kind: String,
    /// Index, in the same list, of the disappeared novelty that is the same object.
    pub moved_from: Option<usize>,
    /// Mean of its points, metres.
    #[serde(deserialize_with = "nullable::vector3")]
    pub centre: [f64; 3],
    /// Covariance of its points, square metres.
    #[serde(deserialize_with = "nullable::matrix3")]
    pub covariance: [[f64; 3]; 3],
    /// Standard deviation of the centre by the registration of the views, metres; in visits and the alarm log alone, absent in
    /// logs of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pose_sd: Option<[f64; 3]>,
    /// Axis-aligned extent of its points, metres.
    #[serde(deserialize_with = "nullable::vector3")]
    pub extent: [f64; 3],
    /// Number of points.
    pub points: usize,
    /// Its share of the commonly visible mass.
    #[serde(deserialize_with = "nullable::number")]
    pub mass: f64,
    /// Its part of d_GMM, in the unit of d_GMM.
    #[serde(deserialize_with = "nullable::number")]
    pub contribution: f64,
    /// Sum over its points of their deviations in sigmas, capped (`docs/novelty.md section 6`).
    #[serde(deserialize_with = "nullable::number")]
    pub support: f64,
    /// Positions of its Gaussians in Theta if it appeared, in Gamma if it disappeared, as `--mixtures-out` writes them. Empty
    /// in logs of earlier versions.
    #[serde(default)]
    pub components: Vec<usize>,
    /// Whether Algorithm 1 took one of its Gaussians before d_GMM fell below U_th.
    #[serde(default)]
    pub needed_for_alarm: bool,
    /// Best shape; null if it has too few points for one.
    pub shape: Option<ShapeRecord>,
    /// Answer of each method.
    pub shapes: MethodsRecord,
    /// Several primitives, where one does not describe it.
    pub parts: Vec<ShapeRecord>,
}

impl NoveltyRecord {
    /// The record of a novelty and its shape, in the frame of the revisit.
    pub fn new(novelty: &Novelty, retrieval: Option<&Retrieval>) -> Self {
        let by = |shape: Option<&Shape>| shape.map(ShapeRecord::new);
        Self {
            kind: novelty.kind.as_str().to_owned(),
            moved_from: novelty.moved_from,
            centre: novelty.moments.mean.coords.into(),
            covariance: rows(&novelty.moments.covariance),
            pose_sd: None,
            extent: novelty.extent_m,
            points: novelty.point_indices.len(),
            mass: novelty.mass,
            contribution: novelty.contribution,
            support: novelty.support,
            components: novelty.components.clone(),
            needed_for_alarm: novelty.needed_for_alarm,
            shape: by(retrieval.map(|r| &r.best)),
            shapes: MethodsRecord {
                covariance: by(retrieval.and_then(|r| r.covariance.as_ref())),
                ransac: by(retrieval.and_then(|r| r.ransac.as_ref())),
            },
            parts: retrieval
                .map_or_else(Vec::new, |r| r.parts.iter().map(ShapeRecord::new).collect()),
        }
    }

    /// The same in another frame, with the extent along that frame's axes.
    pub fn new_in_frame(
        novelty: &Novelty,
        retrieval: Option<&Retrieval>,
        other_from_this: &Pose,
    ) -> Self {
        let record = Self::new(novelty, retrieval).in_frame(other_from_this);
        let mut points = novelty.points.iter().map(|p| other_from_this * p);
        let Some(first) = points.next() else {
            return record;
        };
        let (low, high) = points.fold((first, first), |(low, high), p| (low.inf(&p), high.sup(&p)));
        Self {
            extent: (high - low).into(),
            ..record
        }
    }

    /// This record in another frame. Its extent stays along the axes of the old frame: only
    /// [`NoveltyRecord::new_in_frame`] has the points to measure it again.
    pub fn in_frame(&self, other_from_this: &Pose) -> Self {
        let rotation = other_from_this.rotation.to_rotation_matrix();
        let covariance =
            rotation.matrix() * matrix(&self.covariance) * rotation.matrix().transpose();
        let shape = |s: &ShapeRecord| s.in_frame(other_from_this);
        Self {
            centre: transformed(other_from_this, self.centre),
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
    /// The record of `shape`, in the frame of its novelty.
    pub fn new(shape: &Shape) -> Self {
        let alternative = |a: &crate::shape::Alternative| AlternativeRecord {
            class: class_name(a.class).to_owned(),
            probability: a.probability,
        };
        Self {
            class: class_name(shape.class).to_owned(),
            method: method_name(shape.method).to_owned(),
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
        let rotation = other_from_this.rotation.to_rotation_matrix();
        Self {
            centre: transformed(other_from_this, self.centre),
            centre_sd: rotated_sd(rotation.matrix(), self.centre_sd),
            rotation: rows(&(rotation.matrix() * matrix(&self.rotation))),
            ..self.clone()
        }
    }
}

/// Standard deviations along the rotated axes; those along the old axes count as independent.
fn rotated_sd(rotation: &Matrix3<f64>, sd: [f64; 3]) -> [f64; 3] {
    let variances = Matrix3::from_diagonal(&Vector3::from(sd.map(|s| s * s)));
    let rotated = rotation * variances * rotation.transpose();
    [0, 1, 2].map(|axis| rotated[(axis, axis)].max(0.0).sqrt())
}

fn transformed(pose: &Pose, p: [f64; 3]) -> [f64; 3] {
    (pose * Point3::from(p)).coords.into()
}

fn rows(m: &Matrix3<f64>) -> [[f64; 3]; 3] {
    std::array::from_fn(|r| std::array::from_fn(|c| m[(r, c)]))
}

fn matrix(rows: &[[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|r, c| rows[r][c])
}

/// Name of a shape class in reports.
pub fn class_name(class: Class) -> &'static str {
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

fn method_name(method: Method) -> &'static str {
    match method {
        Method::Ransac => "ransac",
        Method::Covariance => "covariance",
    }
}

#[cfg(test)]
mod tests {
    use super::{NoveltyRecord, rotated_sd};
    use crate::geometry::RollPitchYaw;
    use crate::mixture::{Gaussian, Mixture};
    use crate::novelty::{Novelty, NoveltyKind, Surroundings};
    use nalgebra::{Matrix3, Point3, Vector3};

    fn novelty(points: Vec<Point3<f64>>) -> Novelty {
        Novelty {
            components: vec![3],
            needed_for_alarm: true,
            kind: NoveltyKind::Appeared,
            moved_from: None,
            point_indices: vec![1, 2, 3],
            points,
            moments: Gaussian {
                mean: Point3::new(1.0, 2.0, 3.0),
                covariance: Matrix3::from_diagonal(&Vector3::new(1.0, 2.0, 3.0)),
            },
            mixture: Mixture::default(),
            extent_m: [1.0, 2.0, 3.0],
            surroundings: Surroundings::default(),
            mass: 0.1,
            contribution: 0.2,
            support: 300.0,
        }
    }

    #[test]
    fn extent_and_standard_deviations_are_along_the_axes_of_the_frame() {
        let quarter = RollPitchYaw {
            roll_rad: 0.0,
            pitch_rad: 0.0,
            yaw_rad: std::f64::consts::FRAC_PI_2,
        }
        .with_translation([4.0, 5.0, 6.0]);
        let points = vec![Point3::origin(), Point3::new(3.0, 1.0, 2.0)];
        let record = NoveltyRecord::new_in_frame(&novelty(points), None, &quarter);
        for (got, expected) in record.extent.into_iter().zip([1.0, 3.0, 2.0]) {
            assert!((got - expected).abs() < 1e-12);
        }
        let rotated = rotated_sd(
            quarter.rotation.to_rotation_matrix().matrix(),
            [0.1, 0.2, 0.3],
        );
        for (got, expected) in rotated.into_iter().zip([0.2, 0.1, 0.3]) {
            assert!((got - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn a_number_that_is_not_finite_is_null_and_reads_back() {
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
    fn a_frame_and_its_inverse_give_the_same_record() {
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
