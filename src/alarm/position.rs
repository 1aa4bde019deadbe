//! Where a thing is and how big, as a guard looks for it: from the waypoint, over the floor, standing upright.

use super::constants::{FLAT_MIN_RATIO, FLOOR_BAND_M, FLOOR_MIN_SHARE, FLOOR_MIN_UPRIGHT};
use nalgebra::{Matrix3, SymmetricEigen, Vector2};
use patrold_engine::mixture::{Gaussian, Mixture};
use patrold_engine::report::{NoveltyRecord, ShapeRecord};
use serde::Serialize;

/// Position and size of a thing, for a guard.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct GuardPosition {
    /// Horizontal distance from the waypoint's base to the centre, metres.
    pub distance_m: f64,
    /// Direction seen from the waypoint: 0 is ahead, to the left positive, degrees.
    pub bearing_deg: f64,
    /// Lowest point over the floor, metres; `None` where the reference shows no floor.
    pub above_floor_m: Option<f64>,
    /// Upright height, metres.
    pub height_m: f64,
    /// Longer side of its outline from above, metres.
    pub width_m: f64,
    /// Shorter side of its outline from above, metres.
    pub depth_m: f64,
}

impl GuardPosition {
    /// `floor_m` is the height of the floor in the frame of the novelty.
    pub fn new(novelty: &NoveltyRecord, floor_m: Option<f64>) -> Self {
        let (centre, [height_m, width_m, depth_m]) = match &novelty.shape {
            Some(shape) => (shape.centre, upright_size(shape)),
            None => {
                let [x, y, z] = novelty.extent;
                (novelty.centre, [z, x.max(y), x.min(y)])
            }
        };
        let [x, y, z] = centre;
        Self {
            distance_m: x.hypot(y),
            bearing_deg: y.atan2(x).to_degrees(),
            above_floor_m: floor_m.map(|floor| z - 0.5 * height_m - floor),
            height_m,
            width_m,
            depth_m,
        }
    }
}

/// Height, width and depth of the upright box around a shape.
fn upright_size(shape: &ShapeRecord) -> [f64; 3] {
    let rotation = Matrix3::from_fn(|row, column| shape.rotation[row][column]);
    let axis = rotation.column(2);
    let [a, _, c] = shape.size;
    let (up, level) = (axis.z.abs(), axis.z.mul_add(-axis.z, 1.0).max(0.0).sqrt());
    match shape.class.as_str() {
        "sphere" => [a, a, a],
        // Round about the third axis: across its plane the diameter shows whole.
        "cylinder" | "cone" => {
            let along = level * c + up * a;
            [up * c + level * a, along.max(a), along.min(a)]
        }
        _ => {
            let sides = [0, 1, 2].map(|i| shape.size[i] * rotation.column(i));
            let height = sides.iter().map(|side| side.z.abs()).sum();
            let flat = sides.map(|side| Vector2::new(side.x, side.y));
            let [width, depth] = least_rectangle(&flat);
            [height, width, depth]
        }
    }
}

/// Sides of the least rectangle around a box seen from above; one side of it lies along a side of the box.
fn least_rectangle(sides: &[Vector2<f64>; 3]) -> [f64; 2] {
    let along = |direction: &Vector2<f64>| {
        let across = Vector2::new(-direction.y, direction.x);
        [*direction, across].map(|d| sides.iter().map(|side| side.dot(&d).abs()).sum::<f64>())
    };
    let rectangles = sides
        .iter()
        .filter_map(|side| Some(along(&side.try_normalize(1e-9)?)));
    let least = rectangles.min_by(|a, b| (a[0] * a[1]).total_cmp(&(b[0] * b[1])));
    let [a, b] = least.unwrap_or_default();
    [a.max(b), a.min(b)]
}

/// Height of the floor that a reference shows, in its frame: the lowest level surface of some size.
pub fn floor_height_m(reference: &Mixture) -> Option<f64> {
    let weighted = reference.components.iter().zip(&reference.weights);
    let mut level: Vec<(f64, f64)> = weighted
        .filter(|(component, _)| is_level(component))
        .map(|(component, weight)| (component.mean.z, *weight))
        .collect();
    level.sort_by(|a, b| a.0.total_cmp(&b.0));
    let all: f64 = level.iter().map(|(_, weight)| weight).sum();
    level.iter().enumerate().find_map(|(first, (z, _))| {
        let band = level[first..]
            .iter()
            .take_while(|(other, _)| other - z <= FLOOR_BAND_M);
        let (mass, moment) = band.fold((0.0, 0.0), |(mass, moment), (z, weight)| {
            (mass + weight, moment + weight * z)
        });
        (mass > 0.0 && mass >= FLOOR_MIN_SHARE * all).then(|| moment / mass)
    })
}

fn is_level(component: &Gaussian) -> bool {
    let axes = SymmetricEigen::new(component.covariance);
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| axes.eigenvalues[*a].total_cmp(&axes.eigenvalues[*b]));
    let sd = order.map(|i| axes.eigenvalues[i].max(0.0).sqrt());
    let normal = axes.eigenvectors.column(order[0]);
    sd[1] >= FLAT_MIN_RATIO * sd[0] && normal.z.abs() >= FLOOR_MIN_UPRIGHT
}

#[cfg(test)]
mod tests {
    use super::{GuardPosition, floor_height_m};
    use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
    use patrold_engine::mixture::{Gaussian, Mixture};
    use patrold_engine::report::{MethodsRecord, NoveltyRecord, ShapeRecord};
    use proptest::prelude::*;

    fn shape(class: &str, size: [f64; 3], rotation: Rotation3<f64>, at: [f64; 3]) -> NoveltyRecord {
        let matrix = rotation.matrix();
        let rows = [0, 1, 2].map(|i| [matrix[(i, 0)], matrix[(i, 1)], matrix[(i, 2)]]);
        NoveltyRecord {
            kind: "appeared".to_owned(),
            moved_from: None,
            // Its visible side is nearer than its centre.
            centre: [9.0, 9.0, 9.0],
            covariance: rows,
            pose_sd: None,
            extent: [0.2, 0.5, 1.0],
            points: 100,
            mass: 0.01,
            contribution: 0.01,
            support: 300.0,
            components: Vec::new(),
            needed_for_alarm: true,
            shape: Some(ShapeRecord {
                class: class.to_owned(),
                method: "covariance".to_owned(),
                probability: 1.0,
                alternatives: Vec::new(),
                centre: at,
                centre_sd: [0.0; 3],
                rotation: rows,
                size,
                size_sd: [0.0; 3],
                exponents: None,
                residual_m: 0.0,
                inliers: 100,
            }),
            shapes: MethodsRecord::default(),
            parts: Vec::new(),
        }
    }

    fn turned(roll: f64, pitch: f64, yaw: f64) -> Rotation3<f64> {
        Rotation3::from_euler_angles(roll, pitch, yaw)
    }

    fn close(got: [f64; 3], expected: [f64; 3]) -> bool {
        got.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-9)
    }

    fn size(at: &GuardPosition) -> [f64; 3] {
        [at.height_m, at.width_m, at.depth_m]
    }

    #[test]
    fn a_box_on_the_floor_behind_to_the_left() {
        let novelty = shape(
            "box",
            [0.6, 0.4, 0.3],
            turned(0.0, 0.0, 0.7),
            [-3.0, 3.0, -0.25],
        );
        let at = GuardPosition::new(&novelty, Some(-0.4));
        assert!((at.distance_m - 18f64.sqrt()).abs() < 1e-12);
        assert!((at.bearing_deg - 135.0).abs() < 1e-9);
        assert!(close(size(&at), [0.3, 0.6, 0.4]), "{at:?}");
        assert!(at.above_floor_m.is_some_and(|height| height.abs() < 1e-9));
        assert_eq!(GuardPosition::new(&novelty, None).above_floor_m, None);
    }

    #[test]
    fn a_lying_cylinder_is_as_wide_as_it_is_long() {
        let quarter = std::f64::consts::FRAC_PI_2;
        let lying = shape(
            "cylinder",
            [0.4, 0.4, 1.7],
            turned(quarter, 0.0, 0.3),
            [2.0, 0.0, 0.0],
        );
        let standing = shape(
            "cylinder",
            [0.4, 0.4, 1.7],
            turned(0.0, 0.0, 0.3),
            [2.0, 0.0, 0.0],
        );
        assert!(close(
            size(&GuardPosition::new(&lying, None)),
            [0.4, 1.7, 0.4]
        ));
        assert!(close(
            size(&GuardPosition::new(&standing, None)),
            [1.7, 0.4, 0.4]
        ));
    }

    #[test]
    fn without_a_shape_the_extent_of_the_points_is_given() {
        let mut novelty = shape("box", [1.0; 3], turned(0.0, 0.0, 0.0), [1.0, 0.0, 0.0]);
        novelty.shape = None;
        let at = GuardPosition::new(&novelty, None);
        assert!(close(size(&at), [1.0, 0.5, 0.2]), "{at:?}");
        assert!((at.bearing_deg - 45.0).abs() < 1e-9, "its points' mean");
    }

    proptest! {
        /// Turning the robot changes the bearing alone.
        #[test]
        fn size_and_distance_do_not_depend_on_yaw(
            yaw in -3.0..3.0f64, roll in -1.5..1.5f64, pitch in -1.5..1.5f64,
            sides in prop::array::uniform3(0.05..2.0f64), class in 0usize..4,
        ) {
            let class = ["box", "plane", "cylinder", "sphere"][class];
            let at = Vector3::new(2.0, 1.0, 0.3);
            let straight = shape(class, sides, turned(roll, pitch, 0.0), at.into());
            let by_yaw = turned(0.0, 0.0, yaw);
            let rotated = shape(class, sides, by_yaw * turned(roll, pitch, 0.0), (by_yaw * at).into());
            let [a, b] = [&straight, &rotated].map(|n| GuardPosition::new(n, Some(-1.0)));
            prop_assert!(size(&a).iter().zip(size(&b)).all(|(x, y)| (x - y).abs() < 1e-9));
            prop_assert!((a.distance_m - b.distance_m).abs() < 1e-9);
            let turn = (b.bearing_deg - a.bearing_deg - yaw.to_degrees()).rem_euclid(360.0);
            prop_assert!(turn.min(360.0 - turn) < 1e-6, "{turn}");
            prop_assert!(a.width_m >= a.depth_m);
        }
    }

    fn patch(z: f64, normal: Vector3<f64>) -> Gaussian {
        let across = Matrix3::identity() - normal * normal.transpose();
        Gaussian {
            mean: Point3::new(2.0, 0.0, z),
            covariance: 0.09 * across + 1e-4 * Matrix3::identity(),
        }
    }

    fn mixture(parts: &[(f64, Gaussian)]) -> Mixture {
        Mixture {
            weights: parts.iter().map(|(weight, _)| *weight).collect(),
            components: parts.iter().map(|(_, component)| *component).collect(),
        }
    }

    #[test]
    fn the_floor_is_the_lowest_level_surface_of_some_size() {
        let (up, wall) = (Vector3::z(), Vector3::x());
        let seen = mixture(&[
            (0.01, patch(-2.0, up)), // a hole
            (0.25, patch(-0.41, up)),
            (0.25, patch(-0.39, up)),
            (0.20, patch(0.35, up)), // a table
            (0.29, patch(-0.9, wall)),
        ]);
        let floor = floor_height_m(&seen).expect("a floor");
        assert!((floor + 0.4).abs() < 1e-9, "{floor}");
        assert_eq!(floor_height_m(&mixture(&[(1.0, patch(-0.4, wall))])), None);
    }
}
