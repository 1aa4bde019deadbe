//! The cylinder.

use super::quadrature::{SurfaceElement, circle_steps, gauss_legendre};
use super::{perpendicular, rotation_with_third, tilted};
use crate::shape::constants::{BOUNDS, FULL_VIEW_ELEVATION_SIN};
use nalgebra::{Matrix3, Point3, Unit, Vector3};

/// A cylinder of finite length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cylinder {
    /// Middle of the axis.
    pub centre: Point3<f64>,
    /// Direction of the axis, of either sign.
    pub axis: Unit<Vector3<f64>>,
    /// Radius, metres.
    pub radius_m: f64,
    /// Full length, metres.
    pub length_m: f64,
}

impl Cylinder {
    /// Height of `p` along the axis above the middle, and its vector from the axis.
    fn axial_and_radial(&self, p: &Point3<f64>) -> (f64, Vector3<f64>) {
        let d = p - self.centre;
        let height = d.dot(&self.axis);
        (height, d - self.axis.as_ref() * height)
    }

    /// Signed distance of `p` from the unbounded lateral surface, positive outside, metres.
    pub fn distance_m(&self, p: &Point3<f64>) -> f64 {
        self.axial_and_radial(p).1.norm() - self.radius_m
    }

    /// Outward unit normal of the lateral surface next to `p`; `None` on the axis.
    pub fn normal_at(&self, p: &Point3<f64>) -> Option<Vector3<f64>> {
        Unit::try_new(self.axial_and_radial(p).1, 1e-12).map(Unit::into_inner)
    }

    /// Signed distance of `p` from what `sensor` sees: the lateral surface, or the cap that faces it where that is nearer.
    /// The lateral surface is unbounded, so that noise at the ends does not stretch it.
    pub(super) fn visible_distance_m(&self, p: &Point3<f64>, sensor: &Point3<f64>) -> f64 {
        self.nearest_visible_face(p, sensor).1
    }

    /// 0 where `p` belongs to the lateral surface, 1 where it belongs to the visible cap.
    pub(super) fn visible_face(&self, p: &Point3<f64>, sensor: &Point3<f64>) -> usize {
        self.nearest_visible_face(p, sensor).0
    }

    fn nearest_visible_face(&self, p: &Point3<f64>, sensor: &Point3<f64>) -> (usize, f64) {
        let (height, away) = self.axial_and_radial(p);
        let lateral = away.norm() - self.radius_m;
        let (sensor_height, sensor_away) = self.axial_and_radial(sensor);
        let half = self.length_m / 2.0;
        let over = sensor_height.abs() - half;
        if over > 0.0 {
            let cap = height * sensor_height.signum() - half;
            if sensor_away.norm() <= self.radius_m {
                // Only the cap is visible, and it ends at its rim.
                let rim = lateral.max(0.0);
                return (
                    1,
                    cap.hypot(rim) * if rim > 0.0 { 1.0 } else { cap.signum() },
                );
            }
            // A cap seen at a grazing angle takes points only gradually: the distance must not jump where the cap comes
            // into sight.
            let distance = (sensor - self.centre).norm();
            let cap = cap / (over / (FULL_VIEW_ELEVATION_SIN * distance)).clamp(1e-6, 1.0);
            if lateral < 0.0 && cap.abs() < -lateral {
                return (1, cap);
            }
        }
        (0, lateral)
    }

    /// Elements that `sensor` sees: the near side of the lateral surface and the cap that faces it; none when it is inside.
    pub(super) fn for_each_visible(
        &self,
        sensor: &Point3<f64>,
        visit: &mut impl FnMut(SurfaceElement),
    ) {
        let (height, away) = self.axial_and_radial(sensor);
        let distance = away.norm();
        if distance > self.radius_m {
            let half_angle = (self.radius_m / distance).acos();
            self.for_each_lateral(&Unit::new_unchecked(away / distance), half_angle, visit);
        }
        if height.abs() > self.length_m / 2.0 {
            self.for_each_of_cap(height.signum(), visit);
        }
    }

    /// Elements of the whole lateral surface; an ideal cylinder has no caps.
    pub(super) fn for_each_ideal(&self, visit: &mut impl FnMut(SurfaceElement)) {
        self.for_each_lateral(&perpendicular(&self.axis), std::f64::consts::PI, visit);
    }

    fn for_each_lateral(
        &self,
        towards: &Unit<Vector3<f64>>,
        half_angle: f64,
        visit: &mut impl FnMut(SurfaceElement),
    ) {
        let side = self.axis.cross(towards);
        let half = self.length_m / 2.0;
        for (angle, angle_weight) in gauss_legendre(-half_angle, half_angle) {
            let (sin, cos) = angle.sin_cos();
            let normal = towards.as_ref() * cos + side * sin;
            for (height, height_weight) in gauss_legendre(-half, half) {
                visit(SurfaceElement {
                    position: self.centre + normal * self.radius_m + self.axis.as_ref() * height,
                    normal,
                    area_m2: self.radius_m * angle_weight * height_weight,
                });
            }
        }
    }

    fn for_each_of_cap(&self, sign: f64, visit: &mut impl FnMut(SurfaceElement)) {
        let e1 = perpendicular(&self.axis);
        let e2 = self.axis.cross(&e1);
        let normal = self.axis.as_ref() * sign;
        let middle = self.centre + normal * (self.length_m / 2.0);
        for (radius, weight) in gauss_legendre(0.0, self.radius_m) {
            for (c, s, step) in circle_steps(6) {
                visit(SurfaceElement {
                    position: middle + e1.as_ref() * (radius * c) + e2 * (radius * s),
                    normal,
                    area_m2: radius * weight * step,
                });
            }
        }
    }

    /// Cylinders along each of `axes` with these far-view moments (docs/shapes.md section 4).
    pub(super) fn initial_guesses(
        mean: &Point3<f64>,
        covariance: &Matrix3<f64>,
        view: &Unit<Vector3<f64>>,
        axes: &[Unit<Vector3<f64>>],
    ) -> Vec<Self> {
        let variance = |a: &Vector3<f64>| a.dot(&(covariance * a)).max(0.0);
        axes.iter()
            .map(|axis| {
                let frame = rotation_with_third(axis, view);
                let (w, u) = (frame.column(0).into_owned(), frame.column(1).into_owned());
                let diameter = 2.0 * (3.0 * variance(&u)).sqrt();
                let radius_m = BOUNDS.cylinder_diameter_m.clamp(diameter) / 2.0;
                Self {
                    centre: mean + w * (std::f64::consts::FRAC_PI_4 * radius_m),
                    axis: *axis,
                    radius_m,
                    length_m: BOUNDS
                        .cylinder_length_m
                        .clamp((12.0 * variance(axis)).sqrt()),
                }
            })
            .collect()
    }

    /// Changed by `x`: the centre in units of `scale_m`, two rotations of the axis in radians, two bounded sizes.
    pub(super) fn perturbed(&self, x: &[f64], scale_m: f64) -> Option<Self> {
        let [cx, cy, cz, angle_1, angle_2, width, length] = *x else {
            return None;
        };
        Some(Self {
            centre: self.centre + Vector3::new(cx, cy, cz) * scale_m,
            axis: tilted(&self.axis, [angle_1, angle_2]),
            radius_m: BOUNDS
                .cylinder_diameter_m
                .perturbed(2.0 * self.radius_m, width)
                / 2.0,
            length_m: BOUNDS.cylinder_length_m.perturbed(self.length_m, length),
        })
    }

    /// Axis third, with its greatest coordinate positive; first towards the sensor.
    pub(in crate::shape) fn canonical_rotation(&self, sensor: &Point3<f64>) -> Matrix3<f64> {
        let axis = if self.axis[self.axis.iamax()] < 0.0 {
            -self.axis
        } else {
            self.axis
        };
        rotation_with_third(&axis, &(sensor - self.centre))
    }
}
