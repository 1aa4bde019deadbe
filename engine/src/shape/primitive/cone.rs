//! The cone.

use super::quadrature::{SurfaceElement, circle_steps, gauss_legendre};
use super::{perpendicular, rotation_with_third, tilted};
use crate::shape::constants::{BOUNDS, FULL_VIEW_ELEVATION_SIN};
use nalgebra::{Matrix3, Point3, Unit, Vector3};

/// A right circular cone that ends in its apex.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// Half-way between base and apex.
    pub centre: Point3<f64>,
    /// Direction from the base to the apex.
    pub axis: Unit<Vector3<f64>>,
    /// Radius of the base, metres.
    pub radius_m: f64,
    /// From base to apex, metres.
    pub height_m: f64,
}

impl Cone {
    pub(in crate::shape) fn apex(&self) -> Point3<f64> {
        self.centre + self.axis.as_ref() * (self.height_m / 2.0)
    }

    /// Middle of the base.
    fn base(&self) -> Point3<f64> {
        self.centre - self.axis.as_ref() * (self.height_m / 2.0)
    }

    /// Length from the base's rim to the apex, metres.
    fn slant_m(&self) -> f64 {
        self.radius_m.hypot(self.height_m)
    }

    /// Depth of `p` below the apex along the axis, and its vector from the axis.
    fn axial_and_radial(&self, p: &Point3<f64>) -> (f64, Vector3<f64>) {
        let d = p - self.apex();
        let height = d.dot(&self.axis);
        (-height, d - self.axis.as_ref() * height)
    }

    /// Signed distance of `p` from the lateral surface, unbounded below the base, positive outside, metres.
    pub fn distance_m(&self, p: &Point3<f64>) -> f64 {
        let (depth, away) = self.axial_and_radial(p);
        let (sin, cos) = (
            self.radius_m / self.slant_m(),
            self.height_m / self.slant_m(),
        );
        let from_axis = away.norm();
        if depth * cos + from_axis * sin < 0.0 {
            return depth.hypot(from_axis);
        }
        from_axis * cos - depth * sin
    }

    /// Outward unit normal of the lateral surface next to `p`; `None` on the axis.
    pub fn normal_at(&self, p: &Point3<f64>) -> Option<Vector3<f64>> {
        let away = Unit::try_new(self.axial_and_radial(p).1, 1e-12)?;
        let normal = away.as_ref() * self.height_m + self.axis.as_ref() * self.radius_m;
        Some(normal / self.slant_m())
    }

    /// Signed distance of `p` from what `sensor` sees: the lateral surface, or the base that faces it where that is nearer.
    pub(super) fn visible_distance_m(&self, p: &Point3<f64>, sensor: &Point3<f64>) -> f64 {
        self.nearest_visible_face(p, sensor).1
    }

    /// 0 where `p` belongs to the lateral surface, 1 where it belongs to the visible base.
    pub(super) fn visible_face(&self, p: &Point3<f64>, sensor: &Point3<f64>) -> usize {
        self.nearest_visible_face(p, sensor).0
    }

    fn nearest_visible_face(&self, p: &Point3<f64>, sensor: &Point3<f64>) -> (usize, f64) {
        let lateral = self.distance_m(p);
        let (sensor_depth, sensor_away) = self.axial_and_radial(sensor);
        let over = sensor_depth - self.height_m;
        if over <= 0.0 {
            return (0, lateral);
        }
        let (depth, away) = self.axial_and_radial(p);
        let base = depth - self.height_m;
        if sensor_away.norm() * self.height_m <= sensor_depth * self.radius_m {
            // Only the base is visible, and it ends at its rim.
            let rim = (away.norm() - self.radius_m).max(0.0);
            return (
                1,
                base.hypot(rim) * if rim > 0.0 { 1.0 } else { base.signum() },
            );
        }
        // A base seen at a grazing angle takes points only gradually, as a cylinder's cap does.
        let distance = (sensor - self.centre).norm();
        let base = base / (over / (FULL_VIEW_ELEVATION_SIN * distance)).clamp(1e-6, 1.0);
        if lateral < 0.0 && base.abs() < -lateral {
            (1, base)
        } else {
            (0, lateral)
        }
    }

    /// Elements that `sensor` sees: its side of the lateral surface (all of it from above the apex) and the base that faces
    /// it.
    pub(super) fn for_each_visible(
        &self,
        sensor: &Point3<f64>,
        visit: &mut impl FnMut(SurfaceElement),
    ) {
        let (depth, away) = self.axial_and_radial(sensor);
        let distance = away.norm();
        // A generator at the angle phi from the sensor faces it where cos(phi) exceeds this.
        let limit = depth * self.radius_m / (distance * self.height_m).max(1e-12);
        if limit < 1.0 {
            let towards = Unit::try_new(away, 1e-12).unwrap_or_else(|| perpendicular(&self.axis));
            self.for_each_lateral(&towards, limit.max(-1.0).acos(), visit);
        }
        if depth > self.height_m {
            let e1 = perpendicular(&self.axis);
            let e2 = self.axis.cross(&e1);
            let (middle, normal) = (self.base(), -self.axis.into_inner());
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
    }

    /// Elements of the whole lateral surface; an ideal cone has no base.
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
        let (apex, slant_m) = (self.apex(), self.slant_m());
        let (sin, cos) = (self.radius_m / slant_m, self.height_m / slant_m);
        // Up to the whole circumference is visible: each half of it has nodes of its own.
        let halves = gauss_legendre(-half_angle, 0.0).chain(gauss_legendre(0.0, half_angle));
        for (angle, angle_weight) in halves {
            let (s, c) = angle.sin_cos();
            let outward = towards.as_ref() * c + side * s;
            let normal = outward * cos + self.axis.as_ref() * sin;
            let down = outward * sin - self.axis.as_ref() * cos;
            for (along, weight) in gauss_legendre(0.0, slant_m) {
                visit(SurfaceElement {
                    position: apex + down * along,
                    normal,
                    area_m2: along * sin * angle_weight * weight,
                });
            }
        }
    }

    /// Changed by `x`: the centre in units of `scale_m`, two rotations of the axis in radians, two bounded sizes.
    pub(super) fn perturbed(&self, x: &[f64], scale_m: f64) -> Option<Self> {
        let [cx, cy, cz, angle_1, angle_2, width, height] = *x else {
            return None;
        };
        Some(Self {
            centre: self.centre + Vector3::new(cx, cy, cz) * scale_m,
            axis: tilted(&self.axis, [angle_1, angle_2]),
            radius_m: BOUNDS.cone_diameter_m.perturbed(2.0 * self.radius_m, width) / 2.0,
            height_m: BOUNDS.cone_height_m.perturbed(self.height_m, height),
        })
    }

    /// Axis third, towards the apex; first towards the sensor.
    pub(super) fn canonical_rotation(&self, sensor: &Point3<f64>) -> Matrix3<f64> {
        rotation_with_third(&self.axis, &(sensor - self.centre))
    }
}

#[cfg(test)]
mod tests {
    use super::Cone;
    use nalgebra::{Point3, Unit, Vector3};
    use std::f64::consts::PI;

    fn cone() -> Cone {
        Cone {
            centre: Point3::new(2.0, 0.0, 0.2),
            axis: Unit::new_normalize(Vector3::z()),
            radius_m: 0.3,
            height_m: 0.4,
        }
    }

    fn area_m2(sensor: Point3<f64>) -> f64 {
        let mut area_m2 = 0.0;
        cone().for_each_visible(&sensor, &mut |p| {
            assert!(p.normal.dot(&(sensor - p.position)) > -1e-9, "{p:?}");
            area_m2 += p.area_m2;
        });
        area_m2
    }

    #[test]
    fn visible_areas_have_their_closed_form() {
        // Lateral surface pi r s with s = 0.5: half of it from the height of the apex, all of it from straight above;
        // only the base from straight below.
        assert!((area_m2(Point3::new(0.0, 0.0, 0.4)) - PI * 0.15 / 2.0).abs() < 1e-9);
        assert!((area_m2(Point3::new(2.0, 0.0, 3.0)) - PI * 0.15).abs() < 1e-9);
        assert!((area_m2(Point3::new(2.0, 0.0, -3.0)) - PI * 0.09).abs() < 1e-9);
        let mut whole_m2 = 0.0;
        cone().for_each_ideal(&mut |p| whole_m2 += p.area_m2);
        assert!((whole_m2 - PI * 0.15).abs() < 1e-9);
    }

    #[test]
    fn distances_are_those_of_a_hand_made_triangle() {
        let cone = cone();
        // Half-way down the lateral surface, then 0.1 along its normal (0.8, 0.6).
        let on = Point3::new(2.15, 0.0, 0.2);
        assert!(cone.distance_m(&on).abs() < 1e-12);
        let normal = cone.normal_at(&on).expect("off the axis");
        assert!((normal - Vector3::new(0.8, 0.0, 0.6)).norm() < 1e-12);
        assert!((cone.distance_m(&(on + normal * 0.1)) - 0.1).abs() < 1e-12);
        assert!((cone.distance_m(&Point3::new(2.0, 0.0, 0.5)) - 0.1).abs() < 1e-12);
        // On the axis at the middle: 0.2 below the apex, 0.2 * 0.6 inside.
        assert!((cone.distance_m(&cone.centre) + 0.12).abs() < 1e-12);
        let below = Point3::new(2.0, 0.0, -3.0);
        let on_base = Point3::new(2.1, 0.1, 0.0);
        assert!(cone.visible_distance_m(&on_base, &below).abs() < 1e-12);
    }
}
