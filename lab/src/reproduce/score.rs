//! Scores of the engine's answers against the truth.

use super::constants::SIGMAS_95;
use super::scene_pair::{NoveltyTruth, ScenePair};
use crate::timing::Timed;
use nalgebra::{Matrix3, Rotation3, Vector3};
use patrold_engine::inspect::Inspection;
use patrold_engine::novelty::NoveltyKind;
use patrold_engine::shape::{Class, Shape};

/// The score of one scene.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneScore {
    /// Name of the scene.
    pub name: String,
    /// Whether an object truly appeared.
    pub has_object: bool,
    /// Reported shapes, right or wrong, `ambiguous` left out.
    pub shapes: usize,
    /// The object was reported with its class.
    pub right: bool,
    /// The object was reported as ambiguous.
    pub ambiguous: bool,
    /// Reported shapes that do not exist: of another class, or at another place.
    pub wrong: usize,
    /// The class reported of the object.
    pub class: Option<Class>,
    /// Size minus true size, metres, where the class is right and the size counts.
    pub size_error_m: Option<[Option<f64>; 3]>,
    /// Its absolute value as a share of the true size, where that is not zero.
    pub size_share: Option<[Option<f64>; 3]>,
    /// Rotation about the axes of the shape, radians, where the class is right and the axis counts.
    pub rotation_error_rad: Option<[Option<f64>; 3]>,
    /// Sizes within their stated 95 % interval, and sizes with an interval.
    pub covered: [usize; 2],
    /// From the current view to the answer, milliseconds.
    pub chain_ms: f64,
    /// Preparation of the reference, milliseconds.
    pub reference_ms: f64,
    /// Bytes of the reference as the store keeps it: its mixture, and its view.
    pub bytes: [usize; 2],
}

/// Compares an answer with the truth.
pub fn score(scene: &ScenePair, answer: &Timed<Inspection>) -> SceneScore {
    let detection = &answer.answer.detection;
    let listed = detection.novelties.iter().zip(&answer.answer.retrievals);
    // At a vacated place a disappearance is true, too.
    let counted = listed.filter(|(n, _)| !(scene.vacated && n.kind == NoveltyKind::Disappeared));
    let reported: Vec<&Shape> = counted
        .filter_map(|(_, r)| r.as_ref())
        .map(|r| &r.best)
        .collect();
    let own = scene.truth.as_ref().and_then(|truth| {
        let max_distance = truth.size_m.iter().fold(0.0_f64, |a, s| a.max(*s));
        let distance = |s: &Shape| (s.centre - truth.centre).norm();
        let near = reported
            .iter()
            .enumerate()
            .filter(|(_, s)| distance(s) < max_distance);
        near.min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)))
            .map(|(i, s)| (i, *s, truth))
    });
    let definite = |s: &&&Shape| s.class != Class::Ambiguous;
    let right = own.filter(|(_, s, truth)| s.class == truth.class);
    let wrong = reported
        .iter()
        .enumerate()
        .filter(|(i, s)| definite(s) && right.is_none_or(|(own, _, _)| own != *i))
        .count();
    SceneScore {
        name: scene.name.clone(),
        has_object: scene.truth.is_some(),
        shapes: reported.iter().filter(definite).count(),
        right: right.is_some(),
        ambiguous: own.is_some_and(|(_, s, _)| s.class == Class::Ambiguous),
        wrong,
        class: own.map(|(_, s, _)| s.class),
        size_error_m: right.map(|(_, s, truth)| {
            SizePairs::new(truth, s).map(|size_m, true_m| Some(size_m - true_m))
        }),
        size_share: right.map(|(_, s, truth)| {
            SizePairs::new(truth, s)
                .map(|size_m, true_m| (true_m > 0.0).then(|| (size_m - true_m).abs() / true_m))
        }),
        rotation_error_rad: right.map(|(_, s, truth)| rotation_error_rad(truth, &s.rotation)),
        covered: right.map_or([0; 2], |(_, s, truth)| covered_sizes(truth, s)),
        chain_ms: answer.answer_ms,
        reference_ms: answer.reference_ms,
        bytes: answer.stored_bytes,
    }
}

/// Which reported size belongs to which true one.
struct SizePairs<'a> {
    /// Indices of the reported and of the true size.
    indices: [[usize; 2]; 3],
    truth: &'a NoveltyTruth,
    shape: &'a Shape,
}

impl<'a> SizePairs<'a> {
    /// Equal exponents of a superquadric leave open which axis is the z of its equation: its sizes are compared in their
    /// order.
    fn new(truth: &'a NoveltyTruth, shape: &'a Shape) -> Self {
        let order = |size_m: &[f64; 3]| {
            let mut order = [0, 1, 2];
            if truth.class == Class::Superquadric {
                order.sort_by(|&a, &b| size_m[b].total_cmp(&size_m[a]));
            }
            order
        };
        let (reported, expected) = (order(&shape.size_m), order(&truth.size_m));
        Self {
            indices: [0, 1, 2].map(|k| [reported[k], expected[k]]),
            truth,
            shape,
        }
    }

    /// `f` of the reported and the true size, where the size counts.
    fn map(&self, f: impl Fn(f64, f64) -> Option<f64>) -> [Option<f64>; 3] {
        self.indices.map(|[reported, expected]| {
            let sized = self.truth.sized[expected];
            sized.then(|| f(self.shape.size_m[reported], self.truth.size_m[expected]))?
        })
    }
}

fn covered_sizes(truth: &NoveltyTruth, shape: &Shape) -> [usize; 2] {
    let counted = (0..3).filter(|k| truth.sized[*k] && truth.size_m[*k] > 0.0);
    // A sphere, a cylinder and a cone have one diameter each.
    let counted = counted.filter(|k| match truth.class {
        Class::Sphere => *k == 0,
        Class::Cylinder | Class::Cone => *k != 1,
        _ => true,
    });
    counted.fold([0; 2], |[within, all], k| {
        let [reported, expected] = SizePairs::new(truth, shape).indices[k];
        let error = (shape.size_m[reported] - truth.size_m[expected]).abs();
        let inside = error <= SIGMAS_95 * shape.size_sd_m[reported];
        [within + usize::from(inside), all + 1]
    })
}

/// The rotation vector of `R_true^T R_est` about the axes of the shape, the shortest of those that a symmetry makes equal;
/// `None` for axes about which the shape looks the same. (z-x-z angles would be singular for an upright cylinder.)
fn rotation_error_rad(truth: &NoveltyTruth, rotation: &Matrix3<f64>) -> [Option<f64>; 3] {
    // Equal sides leave open which axis is which.
    if matches!(
        truth.class,
        Class::Sphere | Class::Box | Class::Superquadric
    ) {
        return [None; 3];
    }
    let own = truth.rotation.transpose() * rotation;
    if !truth.turned {
        // The tilt of the third axis, of either sign.
        let axis = own.column(2) * if own[(2, 2)] < 0.0 { -1.0 } else { 1.0 };
        let tilt = Vector3::z().cross(&axis);
        let (sin, angle) = (tilt.norm(), tilt.norm().atan2(axis.z));
        let scale = if sin > 1e-12 { angle / sin } else { 1.0 };
        return [Some(tilt.x * scale), Some(tilt.y * scale), None];
    }
    // Half turns about its axes leave a rectangle as it is.
    let flips = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
    let vectors = flips.map(|[a, b]| {
        let flip = Matrix3::from_diagonal(&Vector3::new(a, b, a * b));
        Rotation3::from_matrix_unchecked(own * flip).scaled_axis()
    });
    let nearest = vectors
        .into_iter()
        .min_by(|a, b| a.norm().total_cmp(&b.norm()))
        .unwrap_or_default();
    [Some(nearest.x), Some(nearest.y), Some(nearest.z)]
}

#[cfg(test)]
mod tests {
    use super::rotation_error_rad;
    use crate::reproduce::NoveltyTruth;
    use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
    use patrold_engine::shape::Class;

    fn truth(class: Class, turned: bool) -> NoveltyTruth {
        NoveltyTruth {
            class,
            centre: Point3::origin(),
            rotation: Rotation3::from_euler_angles(0.3, -0.2, 1.1).into_inner(),
            size_m: [1.0, 0.5, 0.0],
            sized: [true; 3],
            turned,
        }
    }

    fn rotated(truth: &NoveltyTruth, by: Vector3<f64>) -> Matrix3<f64> {
        truth.rotation * Rotation3::new(by).matrix()
    }

    fn counted(error: Option<f64>) -> f64 {
        error.expect("an axis that counts")
    }

    #[test]
    fn errors_are_about_own_axes_and_symmetries_are_no_errors() {
        let plane = truth(Class::Plane, true);
        let by = Vector3::new(0.02, -0.03, 0.05);
        for flip in [[1.0, 1.0, 1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]] {
            let flipped = rotated(&plane, by) * Matrix3::from_diagonal(&Vector3::from(flip));
            let error = Vector3::from(rotation_error_rad(&plane, &flipped).map(counted));
            assert!((error - by).norm() < 1e-12, "{error}");
        }
        let bar = truth(Class::Cylinder, false);
        let spun = rotated(&bar, Vector3::new(0.04, 0.01, 0.0))
            * Rotation3::from_euler_angles(0.0, std::f64::consts::PI, 2.0).matrix();
        let [x, y, z] = rotation_error_rad(&bar, &spun);
        assert!((counted(x) - 0.04).abs() < 1e-9 && (counted(y) - 0.01).abs() < 1e-9);
        assert!(z.is_none());
        assert_eq!(
            rotation_error_rad(&truth(Class::Sphere, false), &spun),
            [None; 3]
        );
    }
}
