//! Right-handed frames about a given axis.

use nalgebra::{Matrix3, Rotation3, Unit, Vector3};

/// Some unit vector perpendicular to `axis`.
pub(in crate::shape) fn perpendicular(axis: &Unit<Vector3<f64>>) -> Unit<Vector3<f64>> {
    let (ax, ay, az) = (axis.x.abs(), axis.y.abs(), axis.z.abs());
    let other = if ax <= ay && ax <= az {
        Vector3::x()
    } else if ay <= az {
        Vector3::y()
    } else {
        Vector3::z()
    };
    Unit::new_normalize(axis.cross(&other))
}

/// `axis` turned about two of its perpendiculars, by these angles in radians.
pub(in crate::shape) fn tilted(axis: &Unit<Vector3<f64>>, by: [f64; 2]) -> Unit<Vector3<f64>> {
    let e1 = perpendicular(axis);
    let e2 = axis.cross(&e1);
    let turn = Rotation3::new(e1.as_ref() * by[0] + e2 * by[1]);
    Unit::new_normalize(turn * axis.as_ref())
}

/// The right-handed rotation whose third column is `third` and whose first is the part of `hint` perpendicular to it (any
/// perpendicular where `hint` has none).
pub(in crate::shape) fn rotation_with_third(
    third: &Unit<Vector3<f64>>,
    hint: &Vector3<f64>,
) -> Matrix3<f64> {
    let across = hint - third.as_ref() * third.dot(hint);
    let first = Unit::try_new(across, 1e-9 * hint.norm().max(1e-300))
        .unwrap_or_else(|| perpendicular(third));
    let second = third.cross(&first);
    Matrix3::from_columns(&[first.into_inner(), second, third.into_inner()])
}

#[cfg(test)]
mod tests {
    use super::rotation_with_third;
    use nalgebra::{Unit, Vector3};

    #[test]
    fn frames_are_rotations_even_without_a_hint() {
        for (axis, hint) in [
            (Vector3::new(0.2, -0.4, 0.9), Vector3::new(1.0, 0.0, 0.0)),
            (Vector3::new(0.0, 0.0, 1.0), Vector3::new(0.0, 0.0, 5.0)),
            (Vector3::new(1.0, 1.0, 1.0), Vector3::zeros()),
        ] {
            let axis = Unit::new_normalize(axis);
            let r = rotation_with_third(&axis, &hint);
            assert!((r.transpose() * r - nalgebra::Matrix3::identity()).norm() < 1e-12);
            assert!((r.determinant() - 1.0).abs() < 1e-12);
            assert!((r.column(2) - axis.as_ref()).norm() < 1e-15);
        }
    }
}
