//! The errors of paper section IV.B as printed, in numbers (docs/shapes.md section 9).

use crate::shape::{
    BeamDensity, Cylinder, Plane, Primitive, Sphere, SurfaceModel, surface_moments,
};
use nalgebra::{Matrix3, Point3, Rotation3, SymmetricEigen, Vector3};

/// Paper Eq. 10.
fn foerstner_moonen(a: &Matrix3<f64>, b: &Matrix3<f64>) -> f64 {
    let root = SymmetricEigen::new(*a);
    let whiten = root.eigenvectors
        * Matrix3::from_diagonal(&root.eigenvalues.map(|l| 1.0 / l.sqrt()))
        * root.eigenvectors.transpose();
    let between = (whiten * b * whiten).symmetric_eigenvalues();
    between.map(|l| l.ln().powi(2)).sum().sqrt()
}

/// The ideal shapes of paper section IV.B with one metre of diameter and length, the plane a millimetre thick.
fn ideal() -> [Matrix3<f64>; 3] {
    let centre = Point3::origin();
    let shapes = [
        Primitive::Sphere(Sphere {
            centre,
            radius_m: 0.5,
        }),
        Primitive::Cylinder(Cylinder {
            centre,
            axis: Vector3::z_axis(),
            radius_m: 0.5,
            length_m: 1.0,
        }),
        Primitive::Plane(Plane {
            centre,
            rotation: Rotation3::identity(),
            sides_m: [1.0, 1.0],
        }),
    ];
    shapes.map(|shape| {
        let whole = surface_moments(&shape, &centre, SurfaceModel::Ideal, &BeamDensity::Area);
        whole.expect("a surface").covariance + Matrix3::identity() * 1e-6
    })
}

#[test]
fn with_free_scaling_every_class_fits_anything() {
    // A ball of 30 cm seen from one side, with 1 cm of noise.
    let ball = Primitive::Sphere(Sphere {
        centre: Point3::new(2.0, 0.3, -0.2),
        radius_m: 0.3,
    });
    let (origin, density) = (Point3::origin(), BeamDensity::SolidAngle);
    let seen = surface_moments(&ball, &origin, SurfaceModel::Visible, &density).expect("in sight");
    let observed = seen.covariance + Matrix3::identity() * 1e-4;
    let eigen = SymmetricEigen::new(observed);
    let distances = ideal().map(|shape| {
        // Paper Eq. 11 with R the eigenvectors and L_i the square roots of the ratios of the eigenvalues.
        let scale = Matrix3::from_diagonal(&Vector3::from_fn(|k, _| {
            (eigen.eigenvalues[k] / shape[(k, k)]).sqrt()
        }));
        let transform = eigen.eigenvectors * scale;
        foerstner_moonen(&observed, &(transform * shape * transform.transpose()))
    });
    eprintln!("d of Eq. 10 with free L: sphere, cylinder, plane {distances:.1?}");
    assert!(distances.iter().all(|d| *d < 1e-9), "{distances:?}");
    // With one scale for all three, as for a sphere, the distance is large: the visible side is flatter than wide.
    let [sphere, _, _] = ideal();
    let scale = (observed.determinant() / sphere.determinant()).powf(1.0 / 3.0);
    let constrained = foerstner_moonen(&observed, &(sphere * scale));
    eprintln!("a ball against the whole ideal sphere, one scale: {constrained:.2}");
    assert!(constrained > 0.5);
}

#[test]
fn the_printed_rotation_is_no_rotation() {
    let (psi, theta, phi) = (0.3_f64, 0.5_f64, 0.7_f64);
    let ((ss, cs), (st, ct), (sp, cp)) = (psi.sin_cos(), theta.sin_cos(), phi.sin_cos());
    // Paper Eq. 12, letter by letter.
    let printed = Matrix3::new(
        cs * cp - ct * sp * ss,
        cs * sp + ct * sp * ss,
        ss * st,
        -ss * cp - ct * sp * cs,
        -ss * sp + ct * cp * cs,
        ct * ss,
        -st * sp,
        -st * cp,
        ct,
    );
    let repaired = Matrix3::new(
        cs * cp - ct * sp * ss,
        cs * sp + ct * cp * ss,
        ss * st,
        -ss * cp - ct * sp * cs,
        -ss * sp + ct * cp * cs,
        cs * st,
        st * sp,
        -st * cp,
        ct,
    );
    let off = |r: &Matrix3<f64>| (r.transpose() * r - Matrix3::identity()).norm();
    eprintln!(
        "|R^T R - 1|: printed {:.2}, repaired {:.1e}; det {:.2}",
        off(&printed),
        off(&repaired),
        printed.determinant()
    );
    assert!(off(&printed) > 0.5);
    assert!(off(&repaired) < 1e-12 && (repaired.determinant() - 1.0).abs() < 1e-12);
    // z-x-z: spin, nutation, precession.
    let about = |axis: Vector3<f64>, angle: f64| Rotation3::new(axis * angle).into_inner();
    let zxz = about(Vector3::z(), phi) * about(Vector3::x(), theta) * about(Vector3::z(), psi);
    assert!((zxz.transpose() - repaired).norm() < 1e-12);
}
