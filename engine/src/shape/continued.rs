//! A shape goes on where its own points prove no change: the foot of a box on the floor, the strip of a door beside its
//! hinge. Such points are its own if they lie on its surface and the surface that they lie on is not one that was there
//! before.

use super::constants::{
    ALONG_SHARE, LEAST_ALONG, LEAST_FORMER, LEAST_RISE, MOMENT_FLOOR_M, NEIGHBOURHOOD_NEARS,
    OUTLIER_SIGMAS,
};
use super::model::{Class, Shape};
use crate::geometry::Grid;
use crate::mixture::Gaussian;
use crate::novelty::Rim;
use nalgebra::{Point3, Vector3};

/// Points of the rim that belong to `shape`, whose own `points` lie within `near_m` of it.
pub(super) fn continued(
    shape: &Shape,
    points: &[Point3<f64>],
    rim: &Rim,
    sensor: &Point3<f64>,
    near_m: f64,
) -> Vec<Point3<f64>> {
    let on = |p: &Point3<f64>| runs_through(shape, p, sensor, near_m);
    if !rim.beside.iter().any(on) {
        return Vec::new();
    }
    let radius_m = (rim.reach_m / 2.0).max(NEIGHBOURHOOD_NEARS * near_m);
    let own: Vec<Point3<f64>> = points.iter().chain(&rim.beside).copied().collect();
    let on_all = |all: &[Point3<f64>]| -> Vec<bool> { all.iter().map(on).collect() };
    let (own_on, before_on) = (on_all(&own), on_all(&rim.before));
    let around = |grid: &Grid, all_on: &[bool], p: &Point3<f64>| {
        let (mut along, mut count) = (0, 0);
        grid.for_each_within(p, radius_m, |i, _| {
            count += 1;
            along += usize::from(all_on[i]);
        });
        (along, count)
    };
    let mostly = |(along, count): (usize, usize)| {
        along >= LEAST_ALONG && along as f64 >= ALONG_SHARE * count as f64
    };
    let now = Grid::new(&own, radius_m);
    let then = Grid::new(&rim.before, radius_m);
    let former = |p: &Point3<f64>| Former::at(p, &then, &rim.before, rim.reach_m, near_m);
    // Rows of a floor run along a thing by chance; what stands on it rises from it.
    let rises = |p: &Point3<f64>, former: &Former| {
        let mut rising = 0;
        now.for_each_within(p, radius_m, |i, _| {
            rising += usize::from(own_on[i] && former.rises(p, &own[i]));
        });
        rising >= LEAST_ALONG
    };
    let belongs = |p: &&Point3<f64>| {
        on(p)
            && mostly(around(&now, &own_on, p))
            && !mostly(around(&then, &before_on, p))
            && former(p).is_none_or(|f| f.over_m(p).abs() > f.reach_m || rises(p, &f))
    };
    rim.beside.iter().filter(belongs).copied().collect()
}

/// The flat surface that was at a place before.
struct Former {
    middle: Point3<f64>,
    normal: Vector3<f64>,
    /// Its own points lie within this of it, metres.
    reach_m: f64,
}

impl Former {
    /// By the points `before` within `radius_m` of `p`; `None` where these are few, in a line, or no flat surface.
    fn at(
        p: &Point3<f64>,
        then: &Grid,
        before: &[Point3<f64>],
        radius_m: f64,
        near_m: f64,
    ) -> Option<Self> {
        let mut around = Vec::new();
        then.for_each_within(p, radius_m, |i, _| around.push(before[i]));
        if around.len() < LEAST_FORMER {
            return None;
        }
        let moments = Gaussian::of_points(&around)?;
        let eigen = moments.covariance.symmetric_eigen();
        let flat = eigen.eigenvalues.imin();
        let mut sds_m: [f64; 3] = eigen.eigenvalues.map(|v| v.max(0.0).sqrt()).into();
        sds_m.sort_by(f64::total_cmp);
        let [thickness_m, width_m, _] = sds_m;
        let reach_m = OUTLIER_SIGMAS * thickness_m.max(MOMENT_FLOOR_M);
        (width_m > near_m && reach_m <= near_m).then(|| Self {
            middle: moments.mean,
            normal: eigen.eigenvectors.column(flat).into_owned(),
            reach_m,
        })
    }

    fn over_m(&self, p: &Point3<f64>) -> f64 {
        (p - self.middle).dot(&self.normal)
    }

    /// Whether `q` stands off it steeply over `p`.
    fn rises(&self, p: &Point3<f64>, q: &Point3<f64>) -> bool {
        let over_m = self.over_m(q).abs();
        let step = q - p;
        let across_m = (step - self.normal * step.dot(&self.normal)).norm();
        over_m > self.reach_m && over_m >= LEAST_RISE * across_m
    }
}

/// Whether the surface of `shape`, drawn out beyond its edges, runs through `p`. One that closes itself (a ball, a
/// superquadric) is not drawn out.
fn runs_through(shape: &Shape, p: &Point3<f64>, sensor: &Point3<f64>, near_m: f64) -> bool {
    let to_own = shape.rotation.transpose();
    let at = to_own * (p - shape.centre);
    let half = Vector3::from(shape.size_m) / 2.0;
    match shape.class {
        Class::Plane => at.z.abs() <= near_m,
        Class::Cylinder => (at.xy().norm() - half.x).abs() <= near_m,
        Class::Cone => {
            // The radius falls to nothing at the apex; distances are taken across the slope.
            let radius_m = half.x * (half.z - at.z) / (2.0 * half.z);
            let slant = (half.x / (2.0 * half.z)).atan().cos();
            radius_m >= 0.0 && ((at.xy().norm() - radius_m) * slant).abs() <= near_m
        }
        Class::Box => {
            let eye = to_own * (sensor - shape.centre);
            (0..3).any(|k| {
                let face = half[k] * eye[k].signum();
                let seen = eye[k].abs() > half[k];
                // Drawn out to one side at a time: beyond its corners a face is no more.
                let inside = |j: usize| at[j].abs() <= half[j] + near_m;
                let [a, b] = [(k + 1) % 3, (k + 2) % 3];
                seen && (at[k] - face).abs() <= near_m && (inside(a) || inside(b))
            })
        }
        Class::Sphere | Class::Superquadric | Class::Ambiguous => false,
    }
}

#[cfg(test)]
mod tests {
    use super::continued;
    use crate::novelty::Rim;
    use crate::shape::{Class, Method, Shape};
    use nalgebra::{Matrix3, Point3};

    const NEAR_M: f64 = 0.02;

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

    /// Places 2 cm apart on x = `x`, y within `y`, z within `z` (centimetres).
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

    fn told(shape: &Shape, points: &[Point3<f64>], rim: &Rim) -> Vec<Point3<f64>> {
        continued(shape, points, rim, &Point3::new(0.0, 0.0, 0.9), NEAR_M)
    }

    #[test]
    fn a_box_gets_its_foot_back_and_no_floor() {
        // Its front face ends 8 cm over the floor, where evidence ends.
        let points = upright(2.0, [-20, 20], [8, 50]);
        let size = [0.42, 0.42, 0.4];
        let axes = Matrix3::new(0.0, 0.0, 1.0, 0.0, 1.0, 0.0, -1.0, 0.0, 0.0);
        let found = shape(Class::Box, [2.2, 0.0, 0.29], axes, size);
        let foot = upright(2.0, [-20, 20], [2, 6]);
        let rim = Rim {
            reach_m: 0.16,
            // Of the floor behind its face nothing is in sight.
            beside: foot
                .iter()
                .copied()
                .chain(floor().into_iter().filter(|p| p.x < 2.0))
                .collect(),
            before: floor(),
        };
        let more = told(&found, &points, &rim);
        assert!(
            more.iter()
                .all(|p| p.y.abs() <= 0.2 + NEAR_M && (p.x - 2.0).abs() <= NEAR_M)
        );
        let of_foot = more.iter().filter(|p| p.z > 0.0).count();
        assert!(
            of_foot * 10 >= foot.len() * 8,
            "{of_foot} of {}",
            foot.len()
        );
    }

    #[test]
    fn a_round_bar_and_a_cone_get_their_feet_back() {
        let ring = |radius_m: f64, z: i32| -> Vec<Point3<f64>> {
            let turns = (-8..=8).map(|k| std::f64::consts::PI + f64::from(k) * 0.15);
            turns
                .map(|a| {
                    let (sin, cos) = a.sin_cos();
                    Point3::new(2.0 + radius_m * cos, radius_m * sin, f64::from(z) / 100.0)
                })
                .collect()
        };
        let bar = |z: i32| ring(0.15, z);
        let cone = |z: i32| ring(0.15 * (0.6 - f64::from(z) / 100.0) / 0.6, z);
        let sides = |of: &dyn Fn(i32) -> Vec<Point3<f64>>, from: i32, to: i32| {
            (from..to).step_by(2).flat_map(of).collect::<Vec<_>>()
        };
        let whole = [0.3, 0.3, 0.6];
        let middle = [2.0, 0.0, 0.3];
        for (class, of) in [
            (Class::Cylinder, &bar as &dyn Fn(i32) -> Vec<Point3<f64>>),
            (Class::Cone, &cone),
        ] {
            let found = shape(class, middle, Matrix3::identity(), whole);
            let foot = sides(of, 2, 8);
            let rim = Rim {
                reach_m: 0.16,
                beside: foot.clone(),
                before: floor(),
            };
            let more = told(&found, &sides(of, 8, 58), &rim);
            // Just over the floor, the few places of it around may by chance lie along.
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
        let mut rim = Rim {
            reach_m: 0.16,
            before: beside.clone(),
            beside,
        };
        // Only next to the door, where nothing was, may a place pass for the door's.
        let more = told(&door, &points, &rim);
        assert!(more.iter().all(|p| p.y < 0.5), "{}", more.len());
        // A leaf stood there and crossed the plane: what is in the plane now is new.
        rim.before = (0..=10)
            .flat_map(|k| {
                let along = f64::from(k) * 0.02;
                (0..100).map(move |z| Point3::new(2.0 - along, 0.52, f64::from(z) * 0.02))
            })
            .collect();
        assert_eq!(told(&door, &points, &rim).len(), rim.beside.len());
    }

    #[test]
    fn a_row_of_the_floor_that_runs_along_a_board_is_none_of_it() {
        // Its face ends 4 cm over the floor; the row of the floor next to it lies in its plane, the former ones did not.
        let axes = Matrix3::new(0.0, 0.0, -1.0, 1.0, 0.0, 0.0, 0.0, -1.0, 0.0);
        let board = shape(Class::Plane, [2.0, 0.0, 0.27], axes, [0.4, 0.46, 0.0]);
        let points = upright(2.0, [-20, 20], [4, 50]);
        let foot = upright(2.0, [-20, 20], [0, 2]);
        let row = upright(2.0, [22, 34], [0, 0]);
        let rows_before = |xs: &[f64]| -> Vec<Point3<f64>> {
            let rows = xs.iter().flat_map(|x| upright(*x, [-60, 60], [0, 0]));
            rows.collect()
        };
        let rim = Rim {
            reach_m: 0.16,
            beside: foot.iter().chain(&row).copied().collect(),
            before: rows_before(&[1.86, 1.95, 2.05, 2.14]),
        };
        let more = told(&board, &points, &rim);
        assert!(more.iter().all(|p| p.y < 0.24), "{more:?}");
        assert!(more.len() + 3 >= foot.len(), "{}", more.len());
    }

    #[test]
    fn a_ball_is_whole_already() {
        let ball = shape(
            Class::Sphere,
            [2.0, 0.0, 0.3],
            Matrix3::identity(),
            [0.6; 3],
        );
        let rim = Rim {
            reach_m: 0.16,
            beside: floor(),
            before: floor(),
        };
        assert!(told(&ball, &floor(), &rim).is_empty());
    }
}
