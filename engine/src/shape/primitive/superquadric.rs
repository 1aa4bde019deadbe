//! The superquadric ellipsoid: one family from the box over the ellipsoid to the octahedron.

use super::quadrature::{SurfaceElement, circle_steps, gauss_legendre_8};
use super::rotation_with_third;
use crate::shape::constants::{BOUNDS, NEWTON_STEPS, NEWTON_TOLERANCE_M};
use nalgebra::{Matrix3, Point3, Rotation3, Unit, Vector3};

/// (|x/a|^(2/e2) + |y/b|^(2/e2))^(e2/e1) + |z/c|^(2/e1) = 1 with a, b, c half of the sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Superquadric {
    /// Middle, metres.
    pub centre: Point3<f64>,
    /// Columns: x, y and z of the equation.
    pub rotation: Rotation3<f64>,
    /// Full lengths along those axes, metres.
    pub sides_m: [f64; 3],
    /// e1 (along z) and e2 (across): 0 is square, 1 round, 2 a rhombus.
    pub exponents: [f64; 2],
}

impl Superquadric {
    /// `p` in units of the half sides.
    fn scaled(&self, p: &Point3<f64>) -> Vector3<f64> {
        let local = self.rotation.inverse() * (p - self.centre);
        Vector3::from_fn(|k, _| 2.0 * local[k] / self.sides_m[k])
    }

    /// The gauge (see [`gauge_at`](Self::gauge_at)) of a vector in units of the half sides, and its gradient.
    fn gauge(&self, u: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let [e1, e2] = self.exponents;
        // Of degree one: the greatest coordinate is factored out, so that no power overflows.
        let most = u.amax();
        if most < f64::MIN_POSITIVE {
            return (0.0, Vector3::zeros());
        }
        let v = u.map(|x| (x.abs() / most).max(1e-12));
        let (px, py) = (v.x.powf(2.0 / e2), v.y.powf(2.0 / e2));
        let across = px + py;
        let (pa, pz) = (across.powf(e2 / e1), v.z.powf(2.0 / e1));
        let sum = pa + pz;
        let gauge = sum.powf(e1 / 2.0);
        let outer = gauge / sum;
        let shared = outer * pa / across;
        let gradient = Vector3::new(
            shared * px / v.x * u.x.signum(),
            shared * py / v.y * u.y.signum(),
            outer * pz / v.z * u.z.signum(),
        );
        (gauge * most, gradient)
    }

    /// Left side of the equation at `p` to the power e1/2: 1 on the surface, linear along every ray from the centre.
    pub(in crate::shape) fn gauge_at(&self, p: &Point3<f64>) -> f64 {
        self.gauge(&self.scaled(p)).0
    }

    /// Radial distance of `p`: signed distance from the surface along the ray from the centre, positive outside, metres; the
    /// true distance is shorter where the surface is oblique.
    pub fn distance_m(&self, p: &Point3<f64>) -> f64 {
        let gauge = self.gauge_at(p);
        if gauge < 1e-9 {
            return -self.sides_m.iter().fold(f64::INFINITY, |a, &b| a.min(b)) / 2.0;
        }
        (p - self.centre).norm() * (1.0 - 1.0 / gauge)
    }

    /// Distance of `p` from the side that `sensor` sees, to first order of the equation (gauge over gradient), metres. A point
    /// at the hidden side is as deep as the body is thick there: in a thin body, noise behind the front must not count as
    /// on the back.
    pub(super) fn visible_distance_m(&self, p: &Point3<f64>, sensor: &Point3<f64>) -> f64 {
        let (gauge, slope) = self.slope(p);
        let nearest = self.first_order_m(p, gauge, &slope);
        let towards = sensor - p;
        if slope.dot(&towards) >= 0.0 {
            return nearest;
        }
        let far = towards.norm();
        let step = towards / far;
        // The gauge is convex along a line: Newton from outside never passes the front.
        let mut along = far.min(self.sides_m.iter().sum());
        for _ in 0..NEWTON_STEPS {
            let (gauge, slope) = self.slope(&(p + step * along));
            let by_along = slope.dot(&step);
            if by_along <= 0.0 {
                // The line misses the body.
                return nearest;
            }
            let back = (gauge - 1.0) / by_along;
            along -= back;
            if back.abs() < NEWTON_TOLERANCE_M {
                return -along.max(0.0) * by_along / slope.norm();
            }
        }
        nearest
    }

    /// The gauge at `p` and its gradient per metre, in the frame of the points.
    fn slope(&self, p: &Point3<f64>) -> (f64, Vector3<f64>) {
        let (gauge, gradient) = self.gauge(&self.scaled(p));
        let local = Vector3::from_fn(|k, _| 2.0 * gradient[k] / self.sides_m[k]);
        (gauge, self.rotation * local)
    }

    /// Gauge over gradient, or the radial distance where that is less.
    fn first_order_m(&self, p: &Point3<f64>, gauge: f64, slope: &Vector3<f64>) -> f64 {
        let radial = self.distance_m(p);
        let direct = (gauge - 1.0) / slope.norm();
        if direct.is_finite() && direct.abs() < radial.abs() {
            direct
        } else {
            radial
        }
    }

    /// Outward unit normal of the surface next to `p`; `None` at the centre.
    pub fn normal_at(&self, p: &Point3<f64>) -> Option<Vector3<f64>> {
        Unit::try_new(self.slope(p).1, 1e-12).map(Unit::into_inner)
    }

    /// Elements that face `sensor`.
    pub(super) fn for_each_visible(
        &self,
        sensor: &Point3<f64>,
        visit: &mut impl FnMut(SurfaceElement),
    ) {
        self.for_each_ideal(&mut |element| {
            if element.normal.dot(&(sensor - element.position)) > 0.0 {
                visit(element);
            }
        });
    }

    /// Elements of the whole surface, evenly spread in directions of the scaled frame.
    pub(super) fn for_each_ideal(&self, visit: &mut impl FnMut(SurfaceElement)) {
        let half = self.sides_m.map(|s| s / 2.0);
        let volume: f64 = half.iter().product();
        for (z, z_weight) in gauss_legendre_8() {
            let across = (1.0 - z * z).sqrt();
            for (c, s, step) in circle_steps(16) {
                let u = Vector3::new(across * c, across * s, z);
                let (gauge, gradient) = self.gauge(&u);
                let r = 1.0 / gauge;
                // Star-shaped surface: r^2 dOmega along the ray is r^2 / (n u) of area along n; scaling transforms it by
                // the cofactors of the scaling.
                let weight = r * r * z_weight * step / gradient.dot(&u);
                let area = Vector3::from_fn(|k, _| gradient[k] * weight * volume / half[k]);
                let area_m2 = area.norm();
                if !(area_m2 > 0.0 && area_m2.is_finite()) {
                    continue;
                }
                let position = Vector3::from_fn(|k, _| u[k] * r * half[k]);
                visit(SurfaceElement {
                    position: self.centre + self.rotation * position,
                    normal: self.rotation * (area / area_m2),
                    area_m2,
                });
            }
        }
    }

    /// Changed by `x`: the centre in units of `scale_m`, a rotation vector in radians, three bounded sizes, two bounded
    /// exponents.
    pub(super) fn perturbed(&self, x: &[f64], scale_m: f64) -> Option<Self> {
        let [cx, cy, cz, rx, ry, rz, a, b, c, e1, e2] = *x else {
            return None;
        };
        let (side, exponent) = (BOUNDS.superquadric_side_m, BOUNDS.exponent);
        let [first, second, third] = self.sides_m;
        Some(Self {
            centre: self.centre + Vector3::new(cx, cy, cz) * scale_m,
            rotation: Rotation3::new(Vector3::new(rx, ry, rz)) * self.rotation,
            sides_m: [
                side.perturbed(first, a),
                side.perturbed(second, b),
                side.perturbed(third, c),
            ],
            exponents: [
                exponent.perturbed(self.exponents[0], e1),
                exponent.perturbed(self.exponents[1], e2),
            ],
        })
    }

    /// With the longer of the two sides across z first; the surface is the same.
    pub(super) fn longer_first(&self) -> Self {
        let [a, b, c] = self.sides_m;
        if a >= b {
            return *self;
        }
        let m = self.rotation.matrix();
        Self {
            rotation: Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[
                m.column(1).into_owned(),
                -m.column(0).into_owned(),
                m.column(2).into_owned(),
            ])),
            sides_m: [b, a, c],
            ..*self
        }
    }

    /// The equation's z third, x first; the greatest coordinate of both is positive.
    pub(super) fn canonical_rotation(&self) -> Matrix3<f64> {
        let own = self.longer_first();
        let upright = |k: usize| {
            let axis: Vector3<f64> = own.rotation.matrix().column(k).into_owned();
            axis * axis[axis.iamax()].signum()
        };
        rotation_with_third(&Unit::new_normalize(upright(2)), &upright(0))
    }
}

#[cfg(test)]
mod tests {
    use super::Superquadric;
    use nalgebra::{Point3, Rotation3, Vector3};
    use std::f64::consts::PI;

    fn with(sides_m: [f64; 3], exponents: [f64; 2]) -> Superquadric {
        Superquadric {
            centre: Point3::new(2.0, 0.3, -0.1),
            rotation: Rotation3::from_euler_angles(0.3, -0.2, 0.7),
            sides_m,
            exponents,
        }
    }

    fn area(s: &Superquadric) -> f64 {
        let mut area = 0.0;
        s.for_each_ideal(&mut |p| area += p.area_m2);
        area
    }

    #[test]
    fn known_surfaces_have_their_areas() {
        let ball = with([0.6; 3], [1.0, 1.0]);
        assert!((area(&ball) - PI * 0.36).abs() < 1e-6, "{}", area(&ball));
        // Prolate spheroid, half axes .2 .2 .3: 2 pi a^2 (1 + c / (a e) asin e).
        let e = (1.0f64 - 4.0 / 9.0).sqrt();
        let expected = 2.0 * PI * 0.04 * (1.0 + 1.5 / e * e.asin());
        let long = with([0.4, 0.4, 0.6], [1.0, 1.0]);
        assert!(
            (area(&long) / expected - 1.0).abs() < 1e-3,
            "{}",
            area(&long)
        );
        // Nearly the octahedron: 4 sqrt 3 (half axis)^2.
        let eight = with([1.0; 3], [1.999, 1.999]);
        assert!(
            (area(&eight) / 3f64.sqrt() - 1.0).abs() < 0.05,
            "{}",
            area(&eight)
        );
        let block = with([1.0; 3], [0.1, 0.1]);
        assert!((area(&block) / 6.0 - 1.0).abs() < 0.06, "{}", area(&block));
    }

    #[test]
    fn points_on_the_surface_are_at_distance_zero_and_normals_point_outwards() {
        for exponents in [[1.0, 1.0], [0.3, 0.8], [1.6, 0.5], [0.1, 0.1]] {
            let s = with([0.4, 0.7, 0.5], exponents);
            s.for_each_ideal(&mut |p| {
                assert!(s.distance_m(&p.position).abs() < 1e-9);
                let normal = s.normal_at(&p.position).expect("off the centre");
                assert!((normal - p.normal).norm() < 1e-6, "{normal} {p:?}");
                assert!(normal.dot(&(p.position - s.centre)) > 0.0);
                let sensor = p.position + normal;
                let out = s.visible_distance_m(&(p.position + normal * 1e-4), &sensor);
                assert!(out > 0.0 && out < 2e-4, "{out}");
            });
            assert!(s.distance_m(&s.centre) < 0.0);
        }
    }

    #[test]
    fn a_distance_from_a_ball_is_exact() {
        let ball = with([0.6; 3], [1.0, 1.0]);
        let p = ball.centre + Vector3::new(0.3, 0.4, 0.0);
        assert!((ball.distance_m(&p) - 0.2).abs() < 1e-12);
        assert!((ball.visible_distance_m(&p, &(p + Vector3::x())) - 0.2).abs() < 1e-12);
    }

    #[test]
    fn a_point_on_the_hidden_side_is_as_deep_as_the_body() {
        let ball = with([0.6; 3], [1.0, 1.0]);
        let sensor = ball.centre + Vector3::new(2.0, 0.0, 0.0);
        let back = ball.centre - Vector3::new(0.3, 0.0, 0.0);
        assert!((ball.visible_distance_m(&back, &sensor) + 0.6).abs() < 1e-6);
        // Beside the body, on its far half, nothing is in front.
        let beside = ball.centre + Vector3::new(-0.1, 0.35, 0.0);
        assert!(ball.visible_distance_m(&beside, &sensor) > 0.05);
    }
}
