//! The sphere.

use super::perpendicular;
use super::quadrature::{Patch, circle, interval};
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

    /// Patches that `sensor` can see; none when it stands inside.
    pub(super) fn visible(&self, sensor: &Point3<f64>, each: &mut impl FnMut(Patch)) {
        let to_sensor = sensor - self.centre;
        let distance = to_sensor.norm();
        if distance > self.radius_m {
            // From the horizon (cosine r / D) to the point below the sensor.
            let axis = Unit::new_unchecked(to_sensor / distance);
            self.belt(&axis, self.radius_m / distance, each);
        }
    }

    /// Patches of the whole surface.
    pub(super) fn whole(&self, each: &mut impl FnMut(Patch)) {
        self.belt(&Vector3::z_axis(), -1.0, each);
    }

    fn belt(&self, axis: &Unit<Vector3<f64>>, from_cos: f64, each: &mut impl FnMut(Patch)) {
        let e1 = perpendicular(axis);
        let e2 = axis.cross(&e1);
        for (cos, weight) in interval(from_cos, 1.0) {
            let sin = (1.0 - cos * cos).max(0.0).sqrt();
            for (c, s, step) in circle(6) {
                let normal = axis.as_ref() * cos + e1.as_ref() * (sin * c) + e2 * (sin * s);
                each(Patch {
                    at: self.centre + normal * self.radius_m,
                    normal,
                    area: self.radius_m * self.radius_m * weight * step,
                });
            }
        }
    }

    /// Spheres whose far-view moments are the given ones (Sigma = r^2/4 across the view and
    /// r^2/18 along it, centre at mean + 2r/3 v).
    pub(super) fn starts(
        mean: &Point3<f64>,
        covariance: &Matrix3<f64>,
        view: &Unit<Vector3<f64>>,
    ) -> Vec<Self> {
        let along = view.dot(&(covariance * view.as_ref())).max(0.0);
        let across = ((covariance.trace() - along) / 2.0).max(0.0);
        let mut radii = vec![2.0 * across.sqrt(), (18.0 * along).sqrt()];
        // The two estimates agree on a ball; one start is enough then.
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

    /// This sphere moved by parameters: centre in units of `scale_m`, one bounded size.
    pub(super) fn moved(&self, x: &[f64], scale_m: f64) -> Option<Self> {
        let [cx, cy, cz, size] = *x else { return None };
        Some(Self {
            centre: self.centre + Vector3::new(cx, cy, cz) * scale_m,
            radius_m: BOUNDS.sphere_diameter_m.moved(2.0 * self.radius_m, size) / 2.0,
        })
    }
}
