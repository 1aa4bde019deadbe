//! The rectangular box.

use super::quadrature::{SurfaceElement, gauss_legendre};
use super::rotation_with_third;
use crate::shape::constants::BOUNDS;
use nalgebra::{Matrix3, Point3, Rotation3, Unit, Vector3};

/// A rectangular box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cuboid {
    /// Middle, metres.
    pub centre: Point3<f64>,
    /// Columns: along the first, second and third side.
    pub rotation: Rotation3<f64>,
    /// Full lengths of the sides, metres.
    pub sides_m: [f64; 3],
}

impl Cuboid {
    fn local(&self, p: &Point3<f64>) -> Vector3<f64> {
        self.rotation.inverse() * (p - self.centre)
    }

    /// Axis and sign of the face whose plane `p` is farthest outside of (or least inside), and its signed distance from that
    /// plane.
    fn face(&self, p: &Point3<f64>) -> (usize, f64, f64) {
        let local = self.local(p);
        (0..3)
            .map(|k| {
                let over = local[k].abs() - self.sides_m[k] / 2.0;
                (k, local[k].signum(), over)
            })
            .max_by(|a, b| a.2.total_cmp(&b.2))
            .unwrap_or((0, 1.0, 0.0))
    }

    /// Signed distance of `p` from the unbounded planes of the faces, positive outside, metres: exact inside and above a
    /// face, less than the distance beyond an edge.
    pub fn distance_m(&self, p: &Point3<f64>) -> f64 {
        self.face(p).2
    }

    /// Outward unit normal of the face next to `p`.
    pub fn normal_at(&self, p: &Point3<f64>) -> Vector3<f64> {
        let (k, sign, _) = self.face(p);
        self.rotation.matrix().column(k) * sign
    }

    /// Signed distance of `p` from the plane of the face across `axis` that faces `sensor`.
    pub(in crate::shape) fn face_distance_m(
        &self,
        p: &Point3<f64>,
        axis: usize,
        sensor: &Point3<f64>,
    ) -> f64 {
        let (local, from) = (self.local(p), self.local(sensor));
        local[axis] * from[axis].signum() - self.sides_m[axis] / 2.0
    }

    /// Axis of the visible face whose plane `p` is farthest outside of, and its signed distance from that plane; `None` when
    /// `sensor` is inside.
    fn nearest_visible_face(&self, p: &Point3<f64>, sensor: &Point3<f64>) -> Option<(usize, f64)> {
        let (local, from) = (self.local(p), self.local(sensor));
        (0..3)
            .filter(|&k| from[k].abs() > self.sides_m[k] / 2.0)
            .map(|k| (k, local[k] * from[k].signum() - self.sides_m[k] / 2.0))
            .max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Signed distance of `p` from the faces that `sensor` sees, unbounded, so that noise at an edge does not stretch them.
    pub(super) fn visible_distance_m(&self, p: &Point3<f64>, sensor: &Point3<f64>) -> f64 {
        let nearest = self.nearest_visible_face(p, sensor);
        nearest.map_or_else(|| self.distance_m(p), |(_, distance)| distance)
    }

    /// Axis of the visible face that `p` belongs to.
    pub(super) fn visible_face(&self, p: &Point3<f64>, sensor: &Point3<f64>) -> usize {
        let nearest = self.nearest_visible_face(p, sensor);
        nearest.map_or_else(|| self.face(p).0, |(axis, _)| axis)
    }

    /// Elements of the one, two or three faces that `sensor` sees; none when it is inside.
    pub(super) fn for_each_visible(
        &self,
        sensor: &Point3<f64>,
        visit: &mut impl FnMut(SurfaceElement),
    ) {
        let from = self.local(sensor);
        for k in 0..3 {
            if from[k].abs() > self.sides_m[k] / 2.0 {
                self.for_each_of_face(k, from[k].signum(), visit);
            }
        }
    }

    /// Elements of all six faces.
    pub(super) fn for_each_ideal(&self, visit: &mut impl FnMut(SurfaceElement)) {
        for k in 0..3 {
            self.for_each_of_face(k, -1.0, visit);
            self.for_each_of_face(k, 1.0, visit);
        }
    }

    fn for_each_of_face(&self, k: usize, sign: f64, visit: &mut impl FnMut(SurfaceElement)) {
        let [i, j] = [(k + 1) % 3, (k + 2) % 3];
        let m = self.rotation.matrix();
        let normal = m.column(k) * sign;
        let middle = self.centre + normal * (self.sides_m[k] / 2.0);
        let [a, b] = [self.sides_m[i] / 2.0, self.sides_m[j] / 2.0];
        for (x, x_weight) in gauss_legendre(-a, a) {
            for (y, y_weight) in gauss_legendre(-b, b) {
                visit(SurfaceElement {
                    position: middle + m.column(i) * x + m.column(j) * y,
                    normal,
                    area_m2: x_weight * y_weight,
                });
            }
        }
    }

    /// Changed by `x`: the centre in units of `scale_m`, a rotation vector in radians, three bounded sizes.
    pub(super) fn perturbed(&self, x: &[f64], scale_m: f64) -> Option<Self> {
        let [cx, cy, cz, rx, ry, rz, a, b, c] = *x else {
            return None;
        };
        let range = BOUNDS.box_side_m;
        let [first, second, third] = self.sides_m;
        Some(Self {
            centre: self.centre + Vector3::new(cx, cy, cz) * scale_m,
            rotation: Rotation3::new(Vector3::new(rx, ry, rz)) * self.rotation,
            sides_m: [
                range.perturbed(first, a),
                range.perturbed(second, b),
                range.perturbed(third, c),
            ],
        })
    }

    /// Numbers of the axes, longest side first.
    fn order(&self) -> [usize; 3] {
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| self.sides_m[b].total_cmp(&self.sides_m[a]));
        order
    }

    /// Full lengths, longest first, metres.
    pub(super) fn size_m(&self) -> [f64; 3] {
        self.order().map(|k| self.sides_m[k])
    }

    /// Longest side first, shortest third; the greatest coordinate of third and first is positive.
    pub(super) fn canonical_rotation(&self) -> Matrix3<f64> {
        let upright = |k: usize| {
            let axis: Vector3<f64> = self.rotation.matrix().column(k).into_owned();
            axis * axis[axis.iamax()].signum()
        };
        let [first, _, third] = self.order();
        rotation_with_third(&Unit::new_normalize(upright(third)), &upright(first))
    }
}

#[cfg(test)]
mod tests {
    use super::Cuboid;
    use nalgebra::{Point3, Rotation3, Vector3};

    fn example_box() -> Cuboid {
        Cuboid {
            centre: Point3::new(2.0, 0.0, 0.0),
            rotation: Rotation3::from_euler_angles(0.0, 0.0, 0.0),
            sides_m: [0.4, 0.6, 0.2],
        }
    }

    #[test]
    fn a_face_is_visible_where_the_sensor_is_beyond_its_plane() {
        for (sensor, faces) in [
            (Point3::new(0.0, 0.0, 0.0), 1),
            (Point3::new(0.0, 1.0, 0.0), 2),
            (Point3::new(0.0, 1.0, 1.0), 3),
            (Point3::new(2.1, 0.0, 0.0), 0),
        ] {
            let (mut area_m2, mut elements) = (0.0, 0);
            example_box().for_each_visible(&sensor, &mut |p| {
                area_m2 += p.area_m2;
                elements += 1;
                assert!(p.normal.dot(&(sensor - p.position)) > 0.0);
            });
            assert_eq!(elements, 25 * faces);
            let expected = [0.0, 0.12, 0.12 + 0.08, 0.12 + 0.08 + 0.24][faces];
            assert!((area_m2 - expected).abs() < 1e-12, "{sensor}: {area_m2}");
        }
    }

    #[test]
    fn distances_are_those_of_the_visible_faces() {
        let b = example_box();
        let sensor = Point3::new(0.0, 1.0, 0.0);
        let on = [Point3::new(1.8, 0.1, 0.05), Point3::new(2.1, 0.3, -0.05)];
        for p in on {
            assert!(b.visible_distance_m(&p, &sensor).abs() < 1e-12);
        }
        // A point of the hidden far face is far behind the visible ones.
        let far = Point3::new(2.2, 0.0, 0.0);
        assert!((b.visible_distance_m(&far, &sensor) + 0.3).abs() < 1e-12);
        assert!(b.distance_m(&far).abs() < 1e-12);
        assert!((b.normal_at(&far) - Vector3::x()).norm() < 1e-12);
        assert!((b.distance_m(&b.centre) + 0.1).abs() < 1e-12);
    }

    #[test]
    fn sides_are_sorted_longest_first_in_a_rotation() {
        let b = example_box();
        assert_eq!(b.size_m(), [0.6, 0.4, 0.2]);
        let r = b.canonical_rotation();
        assert!((r.determinant() - 1.0).abs() < 1e-12);
        assert!((r.column(0) - Vector3::y()).norm() < 1e-12);
        assert!((r.column(2) - Vector3::z()).norm() < 1e-12);
    }
}
