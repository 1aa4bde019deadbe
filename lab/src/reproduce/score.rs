//! One answer against its truth.

use super::constants::{NUMBERS_PER_COMPONENT, SIGMAS_95};
use super::{Judged, Look, Truth};
use nalgebra::{Matrix3, Rotation3, Vector3};
use patrold_engine::novelty::Kind;
use patrold_engine::shape::{Class, Shape};

/// What came of one scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Mark {
    /// The scene.
    pub name: String,
    /// Whether something truly came.
    pub real: bool,
    /// Shapes told, right or wrong, `ambiguous` left out.
    pub shapes: usize,
    /// The true thing was told with its class.
    pub right: bool,
    /// The true thing was told as ambiguous.
    pub ambiguous: bool,
    /// Shapes told that are not there: another class, or another place.
    pub wrong: usize,
    /// What was told of the true thing.
    pub told: Option<Class>,
    /// Size minus true size, metres, where the class is right and the thing has such a size.
    pub size_error_m: Option<[Option<f64>; 3]>,
    /// The same without sign as shares of the true sizes, for those that are not zero.
    pub size_share: Option<[Option<f64>; 3]>,
    /// Rotation about the shape's own axes, radians, where the class is right and the axis counts.
    pub rotation_error_rad: Option<[Option<f64>; 3]>,
    /// Sizes within their stated 95 % interval, and sizes that have one.
    pub covered: [usize; 2],
    /// The whole chain, milliseconds.
    pub chain_ms: f64,
    /// Making the reference ready, milliseconds.
    pub reference_ms: f64,
    /// Bytes of the mixture and of the cloud that it stands for (f32 coordinates).
    pub bytes: [usize; 2],
}

/// Scores what the engine said of a scene.
pub fn score(look: &Look, judged: &Judged) -> Mark {
    let detection = &judged.inspection.detection;
    let listed = detection
        .novelties
        .iter()
        .zip(&judged.inspection.retrievals);
    // What went where something was moved is true, too.
    let counted = listed.filter(|(n, _)| !(look.vacated && n.kind == Kind::Disappeared));
    let told: Vec<&Shape> = counted
        .filter_map(|(_, r)| r.as_ref())
        .map(|r| &r.best)
        .collect();
    let own = look.truth.as_ref().and_then(|truth| {
        let reach = truth.size_m.iter().fold(0.0_f64, |a, s| a.max(*s));
        let away = |s: &Shape| (s.centre - truth.centre).norm();
        let near = told.iter().enumerate().filter(|(_, s)| away(s) < reach);
        near.min_by(|a, b| away(a.1).total_cmp(&away(b.1)))
            .map(|(i, s)| (i, *s, truth))
    });
    let definite = |s: &&&Shape| s.class != Class::Ambiguous;
    let right = own.filter(|(_, s, truth)| s.class == truth.class);
    let wrong = told
        .iter()
        .enumerate()
        .filter(|(i, s)| definite(s) && right.is_none_or(|(own, _, _)| own != *i))
        .count();
    Mark {
        name: look.name.clone(),
        real: look.truth.is_some(),
        shapes: told.iter().filter(definite).count(),
        right: right.is_some(),
        ambiguous: own.is_some_and(|(_, s, _)| s.class == Class::Ambiguous),
        wrong,
        told: own.map(|(_, s, _)| s.class),
        size_error_m: right
            .map(|(_, s, truth)| Pairs::of(truth, s).sizes(|told_m, true_m| Some(told_m - true_m))),
        size_share: right.map(|(_, s, truth)| {
            Pairs::of(truth, s)
                .sizes(|told_m, true_m| (true_m > 0.0).then(|| (told_m - true_m).abs() / true_m))
        }),
        rotation_error_rad: right.map(|(_, s, truth)| rotation_error_rad(truth, &s.rotation)),
        covered: right.map_or([0; 2], |(_, s, truth)| covered(truth, s)),
        chain_ms: judged.chain_ms,
        reference_ms: judged.reference_ms,
        bytes: [
            detection.components[1] * NUMBERS_PER_COMPONENT * size_of::<f32>(),
            look.current.points.len() * 3 * size_of::<f32>(),
        ],
    }
}

/// Which told size is which true one.
struct Pairs<'a>([[usize; 2]; 3], &'a Truth, &'a Shape);

impl<'a> Pairs<'a> {
    /// Which axis of a superquadric is the equation's z is open where its exponents are alike: its sizes are compared by
    /// their order.
    fn of(truth: &'a Truth, told: &'a Shape) -> Self {
        let order = |size_m: &[f64; 3]| {
            let mut order = [0, 1, 2];
            if truth.class == Class::Superquadric {
                order.sort_by(|&a, &b| size_m[b].total_cmp(&size_m[a]));
            }
            order
        };
        let (ours, theirs) = (order(&told.size_m), order(&truth.size_m));
        Self([0, 1, 2].map(|k| [ours[k], theirs[k]]), truth, told)
    }

    /// Of every size that the thing has: told and true.
    fn sizes(&self, of: impl Fn(f64, f64) -> Option<f64>) -> [Option<f64>; 3] {
        let Self(pairs, truth, told) = self;
        pairs.map(|[ours, theirs]| {
            let sized = truth.sized[theirs];
            sized.then(|| of(told.size_m[ours], truth.size_m[theirs]))?
        })
    }
}

fn covered(truth: &Truth, told: &Shape) -> [usize; 2] {
    let counted = (0..3).filter(|k| truth.sized[*k] && truth.size_m[*k] > 0.0);
    // A ball has one diameter, a bar one, whatever the columns.
    let counted = counted.filter(|k| match truth.class {
        Class::Sphere => *k == 0,
        Class::Cylinder | Class::Cone => *k != 1,
        _ => true,
    });
    counted.fold([0; 2], |[within, all], k| {
        let [told_k, true_k] = Pairs::of(truth, told).0[k];
        let error = (told.size_m[told_k] - truth.size_m[true_k]).abs();
        let inside = error <= SIGMAS_95 * told.size_sd_m[told_k];
        [within + usize::from(inside), all + 1]
    })
}

/// The rotation vector of `R_true^T R_est` about the shape's own axes, by the nearest of the attitudes that a
/// symmetry makes equal; `None` for axes about which the shape looks the same (z-x-z angles would be singular for
/// an upright cylinder).
pub fn rotation_error_rad(truth: &Truth, told: &Matrix3<f64>) -> [Option<f64>; 3] {
    // Sides that are alike leave open which axis is which.
    if matches!(
        truth.class,
        Class::Sphere | Class::Box | Class::Superquadric
    ) {
        return [None; 3];
    }
    let own = truth.rotation.transpose() * told;
    if !truth.turned {
        // Where the third axis went, of either sign.
        let axis = own.column(2) * if own[(2, 2)] < 0.0 { -1.0 } else { 1.0 };
        let way = Vector3::z().cross(&axis);
        let (sin, angle) = (way.norm(), way.norm().atan2(axis.z));
        let scale = if sin > 1e-12 { angle / sin } else { 1.0 };
        return [Some(way.x * scale), Some(way.y * scale), None];
    }
    // Half turns about its own axes leave a rectangle as it is.
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
    use crate::reproduce::Truth;
    use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
    use patrold_engine::shape::Class;

    fn truth(class: Class, turned: bool) -> Truth {
        Truth {
            class,
            centre: Point3::origin(),
            rotation: Rotation3::from_euler_angles(0.3, -0.2, 1.1).into_inner(),
            size_m: [1.0, 0.5, 0.0],
            sized: [true; 3],
            turned,
        }
    }

    fn told(truth: &Truth, by: Vector3<f64>) -> Matrix3<f64> {
        truth.rotation * Rotation3::new(by).matrix()
    }

    fn told_axis(error: Option<f64>) -> f64 {
        error.expect("an axis that counts")
    }

    #[test]
    fn errors_are_told_about_own_axes_and_symmetries_are_no_errors() {
        let plane = truth(Class::Plane, true);
        let by = Vector3::new(0.02, -0.03, 0.05);
        for flip in [[1.0, 1.0, 1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]] {
            let flipped = told(&plane, by) * Matrix3::from_diagonal(&Vector3::from(flip));
            let error = Vector3::from(rotation_error_rad(&plane, &flipped).map(told_axis));
            assert!((error - by).norm() < 1e-12, "{error}");
        }
        let bar = truth(Class::Cylinder, false);
        let spun = told(&bar, Vector3::new(0.04, 0.01, 0.0))
            * Rotation3::from_euler_angles(0.0, std::f64::consts::PI, 2.0).matrix();
        let [x, y, z] = rotation_error_rad(&bar, &spun);
        assert!((told_axis(x) - 0.04).abs() < 1e-9 && (told_axis(y) - 0.01).abs() < 1e-9);
        assert!(z.is_none());
        assert_eq!(
            rotation_error_rad(&truth(Class::Sphere, false), &spun),
            [None; 3]
        );
    }
}
