//! What a flat front hides. A plane explains the points of one face as well as a box whose sides lie out of sight
//! behind it; how deep such a box may be is all that the look can tell.

use super::constants::{BOARD_SHARE, BOUNDS};
use super::faces::beams_on;
use super::matching::Observed;
use super::primitive::{Cuboid, Plane, Primitive, interval};
use super::settings::SurfaceModel;

/// The axis of the front in the boxes below.
const FRONT: usize = 2;

/// Share of the depths of a box with `front` as its face at which no point of another face would be expected: the
/// probability of none there, over depths as even in their logarithm as the bounds of a class are. Depths that make a
/// board of it, told as plane, are none. Zero where the front is larger than a box may be, and where the sensor
/// stands among the points or looks along the front.
pub(super) fn hidden_share(observed: &Observed, front: &Plane) -> f64 {
    let range = BOUNDS.box_side_m;
    let [first, second] = front.sides_m;
    let (short, long) = (first.min(second), first.max(second));
    // The thinnest of three sides against the second.
    let least = range.least.max(BOARD_SHARE * short).ln();
    let most = range.most.min(short / BOARD_SHARE).ln();
    if observed.surface == SurfaceModel::Ideal || long > range.most || least >= most {
        return 0.0;
    }
    let hidden = interval(least, most).map(|(log_m, weight)| {
        let beams = beams_on(
            observed,
            &Primitive::Cuboid(behind(observed, front, log_m.exp())),
        );
        let beside: f64 = beams.iter().sum::<f64>() - beams[FRONT];
        if beams[FRONT] > 0.0 {
            weight * (-observed.independent * beside / beams[FRONT]).exp()
        } else {
            0.0
        }
    });
    hidden.sum::<f64>() / (range.most / range.least).ln()
}

/// The box of this depth behind `front` as the sensor sees it.
fn behind(observed: &Observed, front: &Plane, depth_m: f64) -> Cuboid {
    let normal = front.normal();
    let towards = normal.dot(&(observed.sensor - front.centre)).signum();
    let [first, second] = front.sides_m;
    Cuboid {
        centre: front.centre - normal * (towards * depth_m / 2.0),
        rotation: front.rotation,
        sides_m: [first, second, depth_m],
    }
}

#[cfg(test)]
mod tests {
    use super::hidden_share;
    use crate::mixture::Mixture;
    use crate::novelty::Rim;
    use crate::shape::constants::BOUNDS;
    use crate::shape::matching::Observed;
    use crate::shape::primitive::{Plane, Primitive};
    use crate::shape::scenes::look;
    use crate::shape::settings::{BeamDensity, SurfaceModel};
    use crate::shape::{Class, Shape, ShapeSettings, retrieve};
    use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    /// A board of 0.6 m by 0.4 m at the origin whose normal is turned by `slant_rad` from a sensor 2 m before it.
    fn share(slant_rad: f64, surface: SurfaceModel) -> f64 {
        let observed = Observed::new(
            &Matrix3::from_diagonal(&Vector3::new(0.0, 0.03, 0.013)),
            100.0,
            0.01,
            Point3::new(-2.0, 0.0, 0.0),
            Vec::new(),
            surface,
            BeamDensity::SolidAngle,
        );
        let facing = Matrix3::from_columns(&[Vector3::y(), Vector3::z(), Vector3::x()]);
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), slant_rad);
        hidden_share(
            &observed,
            &Plane {
                centre: Point3::origin(),
                rotation: turn * Rotation3::from_matrix_unchecked(facing),
                sides_m: [0.6, 0.4],
            },
        )
    }

    /// A board 2 m ahead whose normal is turned by `slant_rad`, as told by so many points of which this share is independent.
    fn told(slant_rad: f64, points: usize, independent_share: f64) -> Shape {
        let facing = Matrix3::from_columns(&[Vector3::y(), Vector3::z(), Vector3::x()]);
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), slant_rad);
        let board = Primitive::Plane(Plane {
            centre: Point3::new(2.0, 0.0, 0.0),
            rotation: turn * Rotation3::from_matrix_unchecked(facing),
            sides_m: [0.6, 0.4],
        });
        let sensor = Point3::origin();
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let points = look(&board, &sensor, points, 0.005, &mut rng);
        let (rim, mixture) = (Rim::default(), Mixture::default());
        let settings = ShapeSettings {
            independent_share,
            ..ShapeSettings::default()
        };
        let found = retrieve(&points, &rim, &mixture, &sensor, &settings, 1);
        found.expect("a shape").best
    }

    #[test]
    fn a_box_is_listed_behind_a_front_seen_squarely_alone() {
        let (squarely, slanted) = (told(0.0, 150, 1.0), told(0.8, 150, 1.0));
        let boxes = |shape: &Shape| -> Vec<f64> {
            let listed = shape.alternatives.iter();
            let boxes = listed.filter(|a| a.class == Class::Box);
            boxes.map(|a| a.probability).collect()
        };
        assert_eq!(
            (squarely.class, slanted.class),
            (Class::Plane, Class::Plane)
        );
        let [behind] = boxes(&squarely)[..] else {
            panic!("{:?}", squarely.alternatives)
        };
        assert!((0.03..0.2).contains(&behind), "{behind}");
        assert!(boxes(&slanted).is_empty(), "{:?}", slanted.alternatives);
        let all = squarely.alternatives.iter().chain(&slanted.alternatives);
        assert!(all.clone().all(|a| a.probability >= 0.01));
        // With few points of a sweep it is likelier, and the plane is told all the same.
        let few = told(0.0, 60, 0.36);
        let [likelier] = boxes(&few)[..] else {
            panic!("{:?}", few.alternatives)
        };
        assert!(behind < likelier && likelier < 0.3, "{likelier}");
        assert_eq!(few.class, Class::Plane);
    }

    #[test]
    fn a_front_seen_squarely_hides_every_box_and_a_slanted_one_hardly_any() {
        let range = BOUNDS.box_side_m;
        let boards = (0.0625 * 0.4_f64).max(range.least);
        let all = (range.most / boards).ln() / (range.most / range.least).ln();
        let squarely = share(0.0, SurfaceModel::Visible);
        assert!((squarely - all).abs() < 1e-9, "{squarely} {all}");
        let shares = [0.2, 0.4, 0.8].map(|slant| share(slant, SurfaceModel::Visible));
        assert!(squarely > shares[0] && shares[0] > shares[1] && shares[1] > shares[2]);
        // At 46 degrees a side of 3 cm takes its twentieth of the beams.
        assert!(shares[2] < 0.05, "{shares:?}");
        assert!(share(0.0, SurfaceModel::Ideal).abs() < 1e-12);
    }
}
