//! The cylinder.

use super::quadrature::{Patch, circle, interval};
use super::{perpendicular, rotation_with_third, turned};
use crate::shape::constants::{BOUNDS, CAP_IN_SIGHT_SIN};
use nalgebra::{Matrix3, Point3, Unit, Vector3};

/// A cylinder of finite length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cylinder {
    /// Middle of the axis, metres.
    pub centre: Point3<f64>,
    /// Direction of the axis; its sign means nothing.
    pub axis: Unit<Vector3<f64>>,
    /// Radius, metres.
    pub radius_m: f64,
    /// Full length, metres.
    pub length_m: f64,
}

impl Cylinder {
    /// Height of `p` along the axis over the middle, and its vector away from the axis.
    fn split(&self, p: &Point3<f64>) -> (f64, Vector3<f64>) {
        let d = p - self.centre;
        let height = d.dot(&self.axis);
        (height, d - self.axis.as_ref() * height)
    }

    /// Signed distance of `p` from the endless mantle, positive outside, metres.
    pub fn distance_m(&self, p: &Point3<f64>) -> f64 {
        self.split(p).1.norm() - self.radius_m
    }

    /// Outward unit normal of the mantle next to `p`; `None` on the axis.
    pub fn normal_at(&self, p: &Point3<f64>) -> Option<Vector3<f64>> {
        Unit::try_new(self.split(p).1, 1e-12).map(Unit::into_inner)
    }

    /// Signed distance of `p` from what `sensor` sees: the mantle, or the cap that faces it where
    /// that is nearer. The mantle is endless, so that noise at the ends does not stretch it.
    pub(super) fn visible_distance_m(&self, p: &Point3<f64>, sensor: &Point3<f64>) -> f64 {
        self.seen(p, sensor).1
    }

    /// 0 where `p` belongs to the mantle, 1 where it belongs to the cap that `sensor` sees.
    pub(super) fn seen_face(&self, p: &Point3<f64>, sensor: &Point3<f64>) -> usize {
        self.seen(p, sensor).0
    }

    fn seen(&self, p: &Point3<f64>, sensor: &Point3<f64>) -> (usize, f64) {
        let (height, away) = self.split(p);
        let mantle = away.norm() - self.radius_m;
        let (sensor_height, sensor_away) = self.split(sensor);
        let half = self.length_m / 2.0;
        let over = sensor_height.abs() - half;
        if over > 0.0 {
            let cap = height * sensor_height.signum() - half;
            if sensor_away.norm() <= self.radius_m {
                // The cap alone is seen, and it ends at its rim.
                let rim = mantle.max(0.0);
                return (
                    1,
                    cap.hypot(rim) * if rim > 0.0 { 1.0 } else { cap.signum() },
                );
            }
            // A cap seen at a grazing angle takes points only gradually: the distance must not
            // jump where it comes into sight.
            let distance = (sensor - self.centre).norm();
            let cap = cap / (over / (CAP_IN_SIGHT_SIN * distance)).clamp(1e-6, 1.0);
            if mantle < 0.0 && cap.abs() < -mantle {
                return (1, cap);
            }
        }
        (0, mantle)
    }

    /// Patches that `sensor` can see: the near side of the mantle and the cap that faces it; none
    /// when it stands inside.
    pub(super) fn visible(&self, sensor: &Point3<f64>, each: &mut impl FnMut(Patch)) {
        let (height, away) = self.split(sensor);
        let distance = away.norm();
        if distance > self.radius_m {
            let half_angle = (self.radius_m / distance).acos();
            self.mantle(&Unit::new_unchecked(away / distance), half_angle, each);
        }
        if height.abs() > self.length_m / 2.0 {
            self.cap(height.signum(), each);
        }
    }

    /// Patches of the whole mantle (an ideal cylinder has no caps).
    pub(super) fn whole(&self, each: &mut impl FnMut(Patch)) {
        self.mantle(&perpendicular(&self.axis), std::f64::consts::PI, each);
    }

    fn mantle(&self, towards: &Unit<Vector3<f64>>, half_angle: f64, each: &mut impl FnMut(Patch)) {
        let side = self.axis.cross(towards);
        let half = self.length_m / 2.0;
        for (angle, angle_weight) in interval(-half_angle, half_angle) {
            let (sin, cos) = angle.sin_cos();
            let normal = towards.as_ref() * cos + side * sin;
            for (height, height_weight) in interval(-half, half) {
                each(Patch {
                    at: self.centre + normal * self.radius_m + self.axis.as_ref() * height,
                    normal,
                    area: self.radius_m * angle_weight * height_weight,
                });
            }
        }
    }

    fn cap(&self, sign: f64, each: &mut impl FnMut(Patch)) {
        let e1 = perpendicular(&self.axis);
        let e2 = self.axis.cross(&e1);
        let normal = self.axis.as_ref() * sign;
        let middle = self.centre + normal * (self.length_m / 2.0);
        for (radius, weight) in interval(0.0, self.radius_m) {
            for (c, s, step) in circle(6) {
                each(Patch {
                    at: middle + e1.as_ref() * (radius * c) + e2 * (radius * s),
                    normal,
                    area: radius * weight * step,
                });
            }
        }
    }

    /// Cylinders along each of `axes` whose far-view moments are the given ones (h^2/12 along the
    /// axis, r^2/3 across it and the view, centre at mean + pi r/4 w).
    pub(super) fn starts(
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

    /// This cylinder moved by parameters: centre in units of `scale_m`, two turns of the axis in
    /// radians, two bounded sizes.
    pub(super) fn moved(&self, x: &[f64], scale_m: f64) -> Option<Self> {
        let [cx, cy, cz, turn_1, turn_2, width, length] = *x else {
            return None;
        };
        Some(Self {
            centre: self.centre + Vector3::new(cx, cy, cz) * scale_m,
            axis: turned(&self.axis, [turn_1, turn_2]),
            radius_m: BOUNDS.cylinder_diameter_m.moved(2.0 * self.radius_m, width) / 2.0,
            length_m: BOUNDS.cylinder_length_m.moved(self.length_m, length),
        })
    }

    /// Axis third, with its greatest coordinate positive; first towards the sensor.
    pub(in crate::shape) fn rotation(&self, sensor: &Point3<f64>) -> Matrix3<f64> {
        let axis = if self.axis[self.axis.iamax()] < 0.0 {
            -self.axis
        } else {
            self.axis
        };
        rotation_with_third(&axis, &(sensor - self.centre))
    }
}
