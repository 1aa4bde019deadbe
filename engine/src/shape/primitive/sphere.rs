//! The sphere.

use super::perpendicular;
use super::quadrature::{SurfaceElement, circle_steps, gauss_legendre};
use crate::shape::constants::BOUNDS;
use nalgebra::{Matrix3, Point3, Unit, Vector3};

/// A sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    /// Centre, metres.
    pub centre: Point3<f64>,
    /// Radius, metres.
    pub radius_m: f64,
}

impl Sphere {
    /// Signed distance of `p` from the surface, positive outside, metres.
    pub fn distance_m(&self, p: &Point3<f64>) -> f64 {
        (p - self.centre).norm() - self.radius_m
    }

    /// Outward unit normal of the surface next to `p`; `None` at the centre.
    pub fn normal_at(&self, p: &Point3<f64>) -> Option<Vector3<f64>> {
        Unit::try_new(p - self.centre, 1e-12).map(Unit::into_inner)
    }

    /// Elements that `sensor` sees; none when it is inside.
    pub(super) fn for_each_visible(
        &self,
        sensor: &Point3<f64>,
        visit: &mut impl FnMut(SurfaceElement),
    ) {
        let to_sensor = sensor - self.centre;
        let distance = to_sensor.norm();
        if distance > self.radius_m {
            // From the horizon (cosine r / D) to the point below the sensor.
            let axis = Unit::new_unchecked(to_sensor / distance);
            self.zone(&axis, self.radius_m / distance, visit);
        }
    }

    pub(super) fn for_each_ideal(&self, visit: &mut impl FnMut(SurfaceElement)) {
        self.zone(&Vector3::z_axis(), -1.0, visit);
    }

    /// Elements whose direction from the centre has at least the cosine `from_cos` to `axis`.
    fn zone(
        &self,
        axis: &Unit<Vector3<f64>>,
        from_cos: f64,
        visit: &mut impl FnMut(SurfaceElement),
    ) {
        let e1 = perpendicular(axis);
        let e2 = axis.cross(&e1);
        for (cos, weight) in gauss_legendre(from_cos, 1.0) {
            let sin = (1.0 - cos * cos).max(0.0).sqrt();
            for (c, s, step) in circle_steps(6) {
                let normal = axis.as_ref() * cos + e1.as_ref() * (sin * c) + e2 * (sin * s);
                visit(SurfaceElement {
                    position: self.centre + normal * self.radius_m,
                    normal,
                    area_m2: self.radius_m * self.radius_m * weight * step,
                });
            }
        }
    }

    /// Spheres with these far-view moments (docs/shapes.md section 4), across and along the view.
    pub(super) fn initial_guesses(
        mean: &Point3<f64>,
        covariance: &Matrix3<f64>,
        view: &Unit<Vector3<f64>>,
    ) -> Vec<Self> {
        let along = view.dot(&(covariance * view.as_ref())).max(0.0);
        let across = ((covariance.trace() - along) / 2.0).max(0.0);
        let mut radii = vec![2.0 * across.sqrt(), (18.0 * along).sqrt()];
        // On a sphere the two estimates agree; one start is enough then.
        if (radii[0] / radii[1].max(1e-12)).ln().abs() < 0.2 {
            radii.truncate(1);
        }
        radii
            .into_iter()
            .map(|r| {
                let radius_m = BOUNDS.sphere_diameter_m.clamp(2.0 * r) / 2.0;
                Self {
                    centre: mean + view.as_ref() * (2.0 / 3.0 * radius_m),
                    radius_m,
                }
            })
            .collect()
    }

    /// Changed by `x`: the centre in units of `scale_m`, one bounded size.
    pub(super) fn perturbed(&self, x: &[f64], scale_m: f64) -> Option<Self> {
        let [cx, cy, cz, size] = *x else { return None };
        Some(Self {
            centre: self.centre + Vector3::new(cx, cy, cz) * scale_m,
            radius_m: BOUNDS
                .sphere_diameter_m
                .perturbed(2.0 * self.radius_m, size)
                / 2.0,
        })
    }
}
