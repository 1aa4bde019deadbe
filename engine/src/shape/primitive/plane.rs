//! The rectangle, called plane as in the paper and in JSON.

use super::quadrature::{SurfaceElement, gauss_legendre};
use super::rotation_with_third;
use crate::shape::constants::BOUNDS;
use nalgebra::{Matrix3, Point3, Rotation3, Unit, Vector3};

/// A flat rectangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// Middle, metres.
    pub centre: Point3<f64>,
    /// Columns: along the first side, along the second side, normal.
    pub rotation: Rotation3<f64>,
    /// Full lengths of the first and second side, metres.
    pub sides_m: [f64; 2],
}

impl Plane {
    /// Unit normal.
    pub fn normal(&self) -> Vector3<f64> {
        self.rotation.matrix().column(2).into_owned()
    }

    /// Signed distance of `p` from the unbounded plane, positive on the normal's side, metres.
    pub fn distance_m(&self, p: &Point3<f64>) -> f64 {
        (p - self.centre).dot(&self.normal())
    }

    /// Elements that face `sensor`.
    pub(super) fn for_each_visible(
        &self,
        sensor: &Point3<f64>,
        visit: &mut impl FnMut(SurfaceElement),
    ) {
        let side = self.distance_m(sensor);
        self.for_each_facing(if side < 0.0 { -1.0 } else { 1.0 }, visit);
    }

    pub(super) fn for_each_ideal(&self, visit: &mut impl FnMut(SurfaceElement)) {
        self.for_each_facing(1.0, visit);
    }

    fn for_each_facing(&self, sign: f64, visit: &mut impl FnMut(SurfaceElement)) {
        let [a, b] = self.sides_m;
        let m = self.rotation.matrix();
        let normal = m.column(2) * sign;
        for (x, x_weight) in gauss_legendre(-a / 2.0, a / 2.0) {
            for (y, y_weight) in gauss_legendre(-b / 2.0, b / 2.0) {
                visit(SurfaceElement {
                    position: self.centre + m.column(0) * x + m.column(1) * y,
                    normal,
                    area_m2: x_weight * y_weight,
                });
            }
        }
    }

    /// Rectangles with these far-view moments (docs/shapes.md section 4) and each of `axes` as normal but the first, along
    /// which the points spread most.
    pub(super) fn initial_guesses(
        mean: &Point3<f64>,
        covariance: &Matrix3<f64>,
        axes: &[Unit<Vector3<f64>>],
    ) -> Vec<Self> {
        let side = |a: Vector3<f64>| {
            BOUNDS
                .plane_side_m
                .clamp((12.0 * a.dot(&(covariance * a)).max(0.0)).sqrt())
        };
        axes.iter()
            .enumerate()
            .skip(1)
            .map(|(k, normal)| {
                let hint = axes[(k + 1) % axes.len()];
                let frame = rotation_with_third(normal, &hint);
                Self {
                    centre: *mean,
                    rotation: Rotation3::from_matrix_unchecked(frame),
                    sides_m: [
                        side(frame.column(0).into_owned()),
                        side(frame.column(1).into_owned()),
                    ],
                }
            })
            .collect()
    }

    /// Changed by `x`: the centre in units of `scale_m`, a rotation vector in radians, two bounded sizes.
    pub(super) fn perturbed(&self, x: &[f64], scale_m: f64) -> Option<Self> {
        let [cx, cy, cz, rx, ry, rz, a, b] = *x else {
            return None;
        };
        Some(Self {
            centre: self.centre + Vector3::new(cx, cy, cz) * scale_m,
            rotation: Rotation3::new(Vector3::new(rx, ry, rz)) * self.rotation,
            sides_m: [
                BOUNDS.plane_side_m.perturbed(self.sides_m[0], a),
                BOUNDS.plane_side_m.perturbed(self.sides_m[1], b),
            ],
        })
    }

    /// With the longer side first.
    pub(in crate::shape) fn longer_first(&self) -> Self {
        if self.sides_m[0] >= self.sides_m[1] {
            return *self;
        }
        let m = self.rotation.matrix();
        Self {
            rotation: Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[
                m.column(1).into_owned(),
                -m.column(0).into_owned(),
                m.column(2).into_owned(),
            ])),
            sides_m: [self.sides_m[1], self.sides_m[0]],
            ..*self
        }
    }

    /// Normal third, towards the sensor; longer side first, its greatest coordinate positive.
    pub(super) fn canonical_rotation(&self, sensor: &Point3<f64>) -> Matrix3<f64> {
        let plane = self.longer_first();
        let mut normal = plane.normal();
        if plane.distance_m(sensor) < 0.0 {
            normal = -normal;
        }
        let mut first = plane.rotation.matrix().column(0).into_owned();
        if first[first.iamax()] < 0.0 {
            first = -first;
        }
        rotation_with_third(&Unit::new_normalize(normal), &first)
    }
}
