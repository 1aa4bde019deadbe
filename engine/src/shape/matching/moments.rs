//! Moments of a primitive's surface, by quadrature.

use crate::mixture::Gaussian;
use crate::shape::constants::MIN_AZIMUTH_COS;
use crate::shape::primitive::{Primitive, SurfaceElement};
use crate::shape::settings::{BeamDensity, SurfaceModel};
use nalgebra::{Matrix3, Point3, Vector3};

/// Mean and covariance of the points that `sensor` (metres, same frame) sees of `primitive`, without noise. A surface
/// element has the weight `cos(i) / rho^2 dA` times the density of the sweep. `None` where nothing is visible: the sensor
/// is inside, or in a rectangle's plane.
pub fn surface_moments(
    primitive: &Primitive,
    sensor: &Point3<f64>,
    model: SurfaceModel,
    density: &BeamDensity,
) -> Option<Gaussian> {
    let centre = primitive.centre();
    // Weights in units of the distance, so that those of far objects do not underflow.
    let distance_2 = (sensor - centre).norm_squared().max(1e-12);
    let (mut total, mut first) = (0.0, Vector3::zeros());
    let mut second = Matrix3::zeros();
    let mut add = |element: SurfaceElement, weight: f64| {
        let d = element.position - centre;
        total += weight;
        first += d * weight;
        second += d * d.transpose() * weight;
    };
    match model {
        SurfaceModel::Ideal => {
            primitive.for_each_ideal(&mut |element| add(element, element.area_m2))
        }
        SurfaceModel::Visible => primitive.for_each_visible(sensor, &mut |element| {
            let weight = beam_weight(&element, sensor, density);
            if weight > 0.0 {
                add(element, weight * distance_2);
            }
        }),
    }
    if !(total.is_finite() && total > 0.0) {
        return None;
    }
    let mean = first / total;
    Some(Gaussian {
        mean: centre + mean,
        covariance: second / total - mean * mean.transpose(),
    })
}

/// Weight of a surface element: the solid angle that it fills (zero from behind), times the density of the sweep; its
/// area where points are uniform per area.
pub(super) fn beam_weight(
    element: &SurfaceElement,
    sensor: &Point3<f64>,
    density: &BeamDensity,
) -> f64 {
    let beam = element.position - sensor;
    let rho_2 = beam.norm_squared();
    let rho = rho_2.sqrt();
    let cos_incidence = -element.normal.dot(&beam) / rho;
    if cos_incidence <= 0.0 {
        return 0.0;
    }
    match density {
        BeamDensity::Area => element.area_m2,
        BeamDensity::SolidAngle => element.area_m2 * cos_incidence / rho_2,
        BeamDensity::TiltSweep { axis } => {
            let sin_azimuth = beam.dot(axis) / rho;
            let cos_azimuth = (1.0 - sin_azimuth * sin_azimuth).max(0.0).sqrt();
            element.area_m2 * cos_incidence / (rho_2 * cos_azimuth.max(MIN_AZIMUTH_COS))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::surface_moments;
    use crate::mixture::Gaussian;
    use crate::shape::primitive::{Cylinder, Plane, Primitive, Sphere};
    use crate::shape::settings::{BeamDensity, SurfaceModel};
    use nalgebra::{Matrix3, Point3, Rotation3, Unit, Vector3};
    use std::f64::consts::PI;

    /// Far view: distance over radius.
    const FAR: f64 = 1e4;

    fn seen(primitive: Primitive) -> Gaussian {
        let density = BeamDensity::SolidAngle;
        surface_moments(
            &primitive,
            &Point3::origin(),
            SurfaceModel::Visible,
            &density,
        )
        .expect("seen from outside")
    }

    fn outer(v: &Vector3<f64>) -> Matrix3<f64> {
        v * v.transpose()
    }

    #[test]
    fn far_sphere_has_its_closed_form() {
        let (r, v) = (0.3, Vector3::new(0.6, -0.64, 0.48).normalize());
        let centre = Point3::from(v * r * FAR);
        let m = seen(Primitive::Sphere(Sphere {
            centre,
            radius_m: r,
        }));
        let expected =
            (Matrix3::identity() - outer(&v)) * (r * r / 4.0) + outer(&v) * (r * r / 18.0);
        assert!((m.covariance - expected).norm() < 1e-3 * expected.norm());
        assert!((m.mean + v * (2.0 * r / 3.0) - centre).norm() < 1e-3 * r);
    }

    #[test]
    fn far_cylinder_across_the_view_has_its_closed_form() {
        let (r, h) = (0.2, 1.1);
        let v = Vector3::new(0.8, 0.6, 0.0);
        let (w, a) = (v, Vector3::z());
        let u = a.cross(&w);
        let centre = Point3::from(v * FAR);
        let m = seen(Primitive::Cylinder(Cylinder {
            centre,
            axis: Vector3::z_axis(),
            radius_m: r,
            length_m: h,
        }));
        let expected = outer(&a) * (h * h / 12.0)
            + outer(&u) * (r * r / 3.0)
            + outer(&w) * ((2.0 / 3.0 - PI * PI / 16.0) * r * r);
        assert!((m.covariance - expected).norm() < 1e-3 * expected.norm());
        assert!((m.mean + w * (PI * r / 4.0) - centre).norm() < 1e-3 * r);
    }

    #[test]
    fn far_plane_has_its_closed_form_at_any_slant() {
        let rotation = Rotation3::from_euler_angles(0.3, -0.5, 1.0);
        let m = seen(Primitive::Plane(Plane {
            centre: Point3::new(FAR, 0.0, 0.0),
            rotation,
            sides_m: [1.2, 0.5],
        }));
        let body = rotation.transpose() * m.covariance * rotation;
        let expected = Matrix3::from_diagonal(&Vector3::new(1.44 / 12.0, 0.25 / 12.0, 0.0));
        assert!((body - expected).norm() < 1e-3 * expected.norm());
    }

    #[test]
    fn a_near_sphere_seems_a_fifth_smaller_across_the_view() {
        // docs/shapes.md section 4: at D/r = 3 the radius from the variance across the view is 21 % low.
        let m = seen(Primitive::Sphere(Sphere {
            centre: Point3::new(0.9, 0.0, 0.0),
            radius_m: 0.3,
        }));
        let radius = 2.0 * m.covariance[(1, 1)].sqrt();
        assert!((radius / 0.3 - 0.79).abs() < 0.01, "{radius}");
    }

    #[test]
    fn moments_agree_with_rays_cast_in_a_tilt_sweep() {
        // Count the beams of a dense tilt sweep that hit the sphere.
        let sphere = Sphere {
            centre: Point3::new(0.6, 1.4, 0.3),
            radius_m: 0.35,
        };
        let steps = 1500;
        let mut hits = Vec::new();
        for row in 0..steps {
            let tilt = -1.3 + 1.7 * f64::from(row) / f64::from(steps);
            for column in 0..steps {
                let azimuth = 0.5 + 1.1 * f64::from(column) / f64::from(steps);
                let (x, y) = (azimuth.cos(), azimuth.sin());
                let d = Vector3::new(x * tilt.cos(), y, -x * tilt.sin());
                let b = d.dot(&sphere.centre.coords);
                let c = sphere.centre.coords.norm_squared() - sphere.radius_m.powi(2);
                if b * b > c {
                    hits.push(Point3::from(d * (b - (b * b - c).sqrt())));
                }
            }
        }
        let cast = Gaussian::from_points(&hits).expect("hits");
        let density = BeamDensity::TiltSweep {
            axis: Vector3::y_axis(),
        };
        let model = SurfaceModel::Visible;
        let m = surface_moments(
            &Primitive::Sphere(sphere),
            &Point3::origin(),
            model,
            &density,
        )
        .expect("seen from outside");
        assert!(
            (m.mean - cast.mean).norm() < 1e-3,
            "{} {}",
            m.mean,
            cast.mean
        );
        assert!((m.covariance - cast.covariance).norm() < 0.01 * cast.covariance.norm());
        let plain = seen(Primitive::Sphere(sphere));
        assert!(
            (plain.mean - cast.mean).norm() > 3e-3,
            "the density of the sweep makes no difference"
        );
    }

    #[test]
    fn cap_of_a_cylinder_below_the_sensor_is_a_disc() {
        let m = seen(Primitive::Cylinder(Cylinder {
            centre: Point3::new(0.0, 0.0, -FAR),
            axis: Unit::new_normalize(Vector3::z()),
            radius_m: 0.4,
            length_m: 1.0,
        }));
        assert!(
            (m.covariance[(0, 0)] - 0.04).abs() < 1e-4,
            "{}",
            m.covariance
        );
        assert!((m.mean.z + FAR - 0.5).abs() < 1e-3);
    }

    #[test]
    fn nothing_is_seen_from_inside() {
        let sphere = Primitive::Sphere(Sphere {
            centre: Point3::origin(),
            radius_m: 1.0,
        });
        let (sensor, model) = (Point3::new(0.1, 0.0, 0.0), SurfaceModel::Visible);
        assert!(surface_moments(&sphere, &sensor, model, &BeamDensity::SolidAngle).is_none());
        let whole = surface_moments(&sphere, &sensor, SurfaceModel::Ideal, &BeamDensity::Area)
            .expect("the whole surface");
        assert!((whole.covariance - Matrix3::identity() / 3.0).norm() < 1e-12);
    }
}
