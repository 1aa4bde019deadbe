//! Points of the surroundings that belong to the shape, though they prove no change: the foot of a box on the floor, the
//! strip of a door beside its hinge. They are on its surface, and the other view had no such surface there.

use crate::geometry::PointGrid;
use crate::mixture::Gaussian;
use crate::novelty::Surroundings;
use crate::shape::constants::{
    MIN_FORMER_POINTS, MIN_ON_SURFACE, MIN_ON_SURFACE_SHARE, MIN_RISE_SLOPE, MOMENT_FLOOR_M,
    NEIGHBOURHOOD_BANDS, OUTLIER_SIGMAS,
};
use crate::shape::model::{Class, Shape};
use nalgebra::{Point3, Vector3};

/// Points of the surroundings that belong to `shape`, whose own `points` are within `band_m` of its surface.
pub(in crate::shape) fn extend_along_surface(
    shape: &Shape,
    points: &[Point3<f64>],
    surroundings: &Surroundings,
    sensor: &Point3<f64>,
    band_m: f64,
) -> Vec<Point3<f64>> {
    let on_surface = |p: &Point3<f64>| contains(shape, p, sensor, band_m);
    if !surroundings.own.iter().any(on_surface) {
        return Vec::new();
    }
    let radius_m = (surroundings.reach_m / 2.0).max(NEIGHBOURHOOD_BANDS * band_m);
    let own: Vec<Point3<f64>> = points.iter().chain(&surroundings.own).copied().collect();
    let flags = |all: &[Point3<f64>]| -> Vec<bool> { all.iter().map(on_surface).collect() };
    let (own_on, other_on) = (flags(&own), flags(&surroundings.other));
    let own_grid = PointGrid::new(&own, radius_m);
    let other_grid = PointGrid::new(&surroundings.other, radius_m);
    let mostly_on = |grid: &PointGrid, all_on: &[bool], p: &Point3<f64>| {
        let (mut on, mut count) = (0, 0);
        grid.for_each_within(p, radius_m, |i, _| {
            count += 1;
            on += usize::from(all_on[i]);
        });
        on >= MIN_ON_SURFACE && on as f64 >= MIN_ON_SURFACE_SHARE * f64::from(count)
    };
    let former_plane = |p: &Point3<f64>| {
        FormerPlane::around(
            p,
            &other_grid,
            &surroundings.other,
            surroundings.reach_m,
            band_m,
        )
    };
    // Rows of a floor may be on the surface by chance; what stands on the floor rises from it.
    let has_points_above = |p: &Point3<f64>, plane: &FormerPlane| {
        let mut above = 0;
        own_grid.for_each_within(p, radius_m, |i, _| {
            above += usize::from(own_on[i] && plane.rises_over(p, &own[i]));
        });
        above >= MIN_ON_SURFACE
    };
    let belongs = |p: &&Point3<f64>| {
        on_surface(p)
            && mostly_on(&own_grid, &own_on, p)
            && !mostly_on(&other_grid, &other_on, p)
            && former_plane(p).is_none_or(|plane| {
                plane.height_m(p).abs() > plane.reach_m || has_points_above(p, &plane)
            })
    };
    surroundings.own.iter().filter(belongs).copied().collect()
}

/// A flat surface of the other view.
struct FormerPlane {
    mean: Point3<f64>,
    normal: Vector3<f64>,
    /// Greatest distance of its own points, metres.
    reach_m: f64,
}

impl FormerPlane {
    /// Through those of `points` within `radius_m` of `p`; `None` where these are few, in a line, or not flat.
    fn around(
        p: &Point3<f64>,
        grid: &PointGrid,
        points: &[Point3<f64>],
        radius_m: f64,
        band_m: f64,
    ) -> Option<Self> {
        let mut around = Vec::new();
        grid.for_each_within(p, radius_m, |i, _| around.push(points[i]));
        if around.len() < MIN_FORMER_POINTS {
            return None;
        }
        let moments = Gaussian::from_points(&around)?;
        let eigen = moments.covariance.symmetric_eigen();
        let flat = eigen.eigenvalues.imin();
        let mut sds_m: [f64; 3] = eigen.eigenvalues.map(|v| v.max(0.0).sqrt()).into();
        sds_m.sort_by(f64::total_cmp);
        let [thickness_m, width_m, _] = sds_m;
        let reach_m = OUTLIER_SIGMAS * thickness_m.max(MOMENT_FLOOR_M);
        (width_m > band_m && reach_m <= band_m).then(|| Self {
            mean: moments.mean,
            normal: eigen.eigenvectors.column(flat).into_owned(),
            reach_m,
        })
    }

    fn height_m(&self, p: &Point3<f64>) -> f64 {
        (p - self.mean).dot(&self.normal)
    }

    /// Whether `q` is off the plane and steeply above `p`.
    fn rises_over(&self, p: &Point3<f64>, q: &Point3<f64>) -> bool {
        let height_m = self.height_m(q).abs();
        let step = q - p;
        let across_m = (step - self.normal * step.dot(&self.normal)).norm();
        height_m > self.reach_m && height_m >= MIN_RISE_SLOPE * across_m
    }
}

/// Whether `p` is within `band_m` of the surface of `shape`, extended beyond its edges. Closed surfaces (sphere,
/// superquadric) are not extended.
fn contains(shape: &Shape, p: &Point3<f64>, sensor: &Point3<f64>, band_m: f64) -> bool {
    let to_local = shape.rotation.transpose();
    let local = to_local * (p - shape.centre);
    let half = Vector3::from(shape.size_m) / 2.0;
    match shape.class {
        Class::Plane => local.z.abs() <= band_m,
        Class::Cylinder => (local.xy().norm() - half.x).abs() <= band_m,
        Class::Cone => {
            // The radius is zero at the apex; distances are perpendicular to the surface.
            let radius_m = half.x * (half.z - local.z) / (2.0 * half.z);
            let slant = (half.x / (2.0 * half.z)).atan().cos();
            radius_m >= 0.0 && ((local.xy().norm() - radius_m) * slant).abs() <= band_m
        }
        Class::Box => {
            let local_sensor = to_local * (sensor - shape.centre);
            (0..3).any(|k| {
                let face = half[k] * local_sensor[k].signum();
                let seen = local_sensor[k].abs() > half[k];
                // Extended in one direction at a time, not beyond the corners.
                let inside = |j: usize| local[j].abs() <= half[j] + band_m;
                let [a, b] = [(k + 1) % 3, (k + 2) % 3];
                seen && (local[k] - face).abs() <= band_m && (inside(a) || inside(b))
            })
        }
        Class::Sphere | Class::Superquadric | Class::Ambiguous => false,
    }
}

#[cfg(test)]
mod tests {
    use super::extend_along_surface;
    use crate::novelty::Surroundings;
    use crate::shape::{Class, Method, Shape};
    use nalgebra::{Matrix3, Point3};

    const BAND_M: f64 = 0.02;

    fn shape(class: Class, centre: [f64; 3], rotation: Matrix3<f64>, size_m: [f64; 3]) -> Shape {
        Shape {
            class,
            method: Method::Covariance,
            probability: 1.0,
            alternatives: Vec::new(),
            centre: centre.into(),
            centre_sd_m: [0.0; 3],
            rotation,
            size_m,
            size_sd_m: [0.0; 3],
            exponents: None,
            residual_m: 0.0,
            inliers: 0,
        }
    }

    /// Points 2 cm apart on x = `x`, y within `y`, z within `z` (centimetres).
    fn upright(x: f64, y: [i32; 2], z: [i32; 2]) -> Vec<Point3<f64>> {
        let lines = (y[0]..=y[1]).step_by(2);
        let all = lines.flat_map(|y| (z[0]..=z[1]).step_by(2).map(move |z| (y, z)));
        all.map(|(y, z)| Point3::new(x, f64::from(y) / 100.0, f64::from(z) / 100.0))
            .collect()
    }

    /// A floor about x = 2.
    fn floor() -> Vec<Point3<f64>> {
        let lines = (-60..=60).step_by(3);
        let all = lines.flat_map(|y| (150..=230).step_by(3).map(move |x| (x, y)));
        all.map(|(x, y)| Point3::new(f64::from(x) / 100.0, f64::from(y) / 100.0, 0.0))
            .collect()
    }

    fn extended(
        shape: &Shape,
        points: &[Point3<f64>],
        surroundings: &Surroundings,
    ) -> Vec<Point3<f64>> {
        extend_along_surface(
            shape,
            points,
            surroundings,
            &Point3::new(0.0, 0.0, 0.9),
            BAND_M,
        )
    }

    #[test]
    fn a_box_gets_its_foot_back_and_no_floor() {
        // The evidence of its front face ends 8 cm above the floor.
        let points = upright(2.0, [-20, 20], [8, 50]);
        let size = [0.42, 0.42, 0.4];
        let axes = Matrix3::new(0.0, 0.0, 1.0, 0.0, 1.0, 0.0, -1.0, 0.0, 0.0);
        let found = shape(Class::Box, [2.2, 0.0, 0.29], axes, size);
        let foot = upright(2.0, [-20, 20], [2, 6]);
        let surroundings = Surroundings {
            reach_m: 0.16,
            // The floor behind its face is out of sight.
            own: foot
                .iter()
                .copied()
                .chain(floor().into_iter().filter(|p| p.x < 2.0))
                .collect(),
            other: floor(),
        };
        let more = extended(&found, &points, &surroundings);
        assert!(
            more.iter()
                .all(|p| p.y.abs() <= 0.2 + BAND_M && (p.x - 2.0).abs() <= BAND_M)
        );
        let of_foot = more.iter().filter(|p| p.z > 0.0).count();
        assert!(
            of_foot * 10 >= foot.len() * 8,
            "{of_foot} of {}",
            foot.len()
        );
    }

    #[test]
    fn a_cylinder_and_a_cone_get_their_feet_back() {
        let ring = |radius_m: f64, z: i32| -> Vec<Point3<f64>> {
            let turns = (-8..=8).map(|k| std::f64::consts::PI + f64::from(k) * 0.15);
            turns
                .map(|a| {
                    let (sin, cos) = a.sin_cos();
                    Point3::new(2.0 + radius_m * cos, radius_m * sin, f64::from(z) / 100.0)
                })
                .collect()
        };
        let cylinder = |z: i32| ring(0.15, z);
        let cone = |z: i32| ring(0.15 * (0.6 - f64::from(z) / 100.0) / 0.6, z);
        let sides = |of: &dyn Fn(i32) -> Vec<Point3<f64>>, from: i32, to: i32| {
            (from..to).step_by(2).flat_map(of).collect::<Vec<_>>()
        };
        let whole = [0.3, 0.3, 0.6];
        let middle = [2.0, 0.0, 0.3];
        for (class, of) in [
            (
                Class::Cylinder,
                &cylinder as &dyn Fn(i32) -> Vec<Point3<f64>>,
            ),
            (Class::Cone, &cone),
        ] {
            let found = shape(class, middle, Matrix3::identity(), whole);
            let foot = sides(of, 2, 8);
            let surroundings = Surroundings {
                reach_m: 0.16,
                own: foot.clone(),
                other: floor(),
            };
            let more = extended(&found, &sides(of, 8, 58), &surroundings);
            // Close to the floor, the few of its points around may be on the surface by chance.
            assert!(
                more.len() * 10 >= foot.len() * 9,
                "{class:?}: {}",
                more.len()
            );
        }
    }

    #[test]
    fn a_closed_door_ends_where_the_wall_was() {
        let axes = Matrix3::new(0.0, 0.0, -1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0);
        let door = shape(Class::Plane, [2.0, 0.0, 1.0], axes, [2.0, 0.9, 0.0]);
        let points = upright(2.0, [-44, 44], [0, 200]);
        let beside = upright(2.0, [46, 60], [0, 200]);
        let mut surroundings = Surroundings {
            reach_m: 0.16,
            other: beside.clone(),
            own: beside,
        };
        // Only next to the door, where nothing was, may a point count as the door's.
        let more = extended(&door, &points, &surroundings);
        assert!(more.iter().all(|p| p.y < 0.5), "{}", more.len());
        // The door leaf stood there and crossed the plane: what is in the plane now is new.
        surroundings.other = (0..=10)
            .flat_map(|k| {
                let along = f64::from(k) * 0.02;
                (0..100).map(move |z| Point3::new(2.0 - along, 0.52, f64::from(z) * 0.02))
            })
            .collect();
        assert_eq!(
            extended(&door, &points, &surroundings).len(),
            surroundings.own.len()
        );
    }

    #[test]
    fn a_row_of_the_floor_along_a_plate_is_not_added() {
        // Its face ends 4 cm above the floor; the row of the floor beside it is in its plane, the former rows were not.
        let axes = Matrix3::new(0.0, 0.0, -1.0, 1.0, 0.0, 0.0, 0.0, -1.0, 0.0);
        let plate = shape(Class::Plane, [2.0, 0.0, 0.27], axes, [0.4, 0.46, 0.0]);
        let points = upright(2.0, [-20, 20], [4, 50]);
        let foot = upright(2.0, [-20, 20], [0, 2]);
        let row = upright(2.0, [22, 34], [0, 0]);
        let rows_before = |xs: &[f64]| -> Vec<Point3<f64>> {
            let rows = xs.iter().flat_map(|x| upright(*x, [-60, 60], [0, 0]));
            rows.collect()
        };
        let surroundings = Surroundings {
            reach_m: 0.16,
            own: foot.iter().chain(&row).copied().collect(),
            other: rows_before(&[1.86, 1.95, 2.05, 2.14]),
        };
        let more = extended(&plate, &points, &surroundings);
        assert!(more.iter().all(|p| p.y < 0.24), "{more:?}");
        assert!(more.len() + 3 >= foot.len(), "{}", more.len());
    }

    #[test]
    fn a_sphere_is_not_extended() {
        let ball = shape(
            Class::Sphere,
            [2.0, 0.0, 0.3],
            Matrix3::identity(),
            [0.6; 3],
        );
        let surroundings = Surroundings {
            reach_m: 0.16,
            own: floor(),
            other: floor(),
        };
        assert!(extended(&ball, &floor(), &surroundings).is_empty());
    }
}
