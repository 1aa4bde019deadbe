//! Boxes behind a flat front. A plane explains the points of one face as well as a box whose sides are out of sight
//! behind it; the view only limits its depth.

use super::faces::beams_per_face;
use crate::shape::constants::{BOUNDS, PLATE_THICKNESS_SHARE};
use crate::shape::matching::fit::Observation;
use crate::shape::primitive::{Cuboid, Plane, Primitive, gauss_legendre};
use crate::shape::settings::SurfaceModel;

/// Axis of the front in [`box_behind`].
const FRONT_AXIS: usize = 2;

/// Share of the depths of a box with `front` as its face at which no point of another face is expected: the probability
/// of no such point, averaged over depths uniform in their logarithm between the bounds. Depths that make it a plate do
/// not count. Zero where the front is larger than a box may be, where the sensor is among the points, or in the plane of
/// the front.
pub(in crate::shape::matching) fn hidden_depth_share(observed: &Observation, front: &Plane) -> f64 {
    let range = BOUNDS.box_side_m;
    let [first, second] = front.sides_m;
    let (short, long) = (first.min(second), first.max(second));
    // Ratio of the third side to the second.
    let min_log = range.min.max(PLATE_THICKNESS_SHARE * short).ln();
    let max_log = range.max.min(short / PLATE_THICKNESS_SHARE).ln();
    if observed.surface == SurfaceModel::Ideal || long > range.max || min_log >= max_log {
        return 0.0;
    }
    let hidden = gauss_legendre(min_log, max_log).map(|(log_m, weight)| {
        let beams = beams_per_face(
            observed,
            &Primitive::Cuboid(box_behind(observed, front, log_m.exp())),
        );
        let side_beams: f64 = beams.iter().sum::<f64>() - beams[FRONT_AXIS];
        if beams[FRONT_AXIS] > 0.0 {
            weight * (-observed.independent_points * side_beams / beams[FRONT_AXIS]).exp()
        } else {
            0.0
        }
    });
    hidden.sum::<f64>() / (range.max / range.min).ln()
}

/// The box of this depth behind `front` as the sensor sees it.
fn box_behind(observed: &Observation, front: &Plane, depth_m: f64) -> Cuboid {
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
    use super::hidden_depth_share;
    use crate::mixture::Mixture;
    use crate::novelty::Surroundings;
    use crate::shape::constants::BOUNDS;
    use crate::shape::matching::fit::Observation;
    use crate::shape::primitive::{Plane, Primitive};
    use crate::shape::settings::{BeamDensity, SurfaceModel};
    use crate::shape::tests::scenes::simulate_view;
    use crate::shape::{Class, Shape, ShapeSettings, retrieve};
    use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    /// Of a plate of 0.6 m by 0.4 m at the origin whose normal is turned by `slant_rad` from a sensor 2 m before it.
    fn depth_share(slant_rad: f64, surface: SurfaceModel) -> f64 {
        let observed = Observation::new(
            &Matrix3::from_diagonal(&Vector3::new(0.0, 0.03, 0.013)),
            100.0,
            0.01,
            Point3::new(-2.0, 0.0, 0.0),
            Vec::new(),
            surface,
            BeamDensity::SolidAngle,
        );
        let facing = Matrix3::from_columns(&[Vector3::y(), Vector3::z(), Vector3::x()]);
        let rotation = Rotation3::from_axis_angle(&Vector3::z_axis(), slant_rad);
        hidden_depth_share(
            &observed,
            &Plane {
                centre: Point3::origin(),
                rotation: rotation * Rotation3::from_matrix_unchecked(facing),
                sides_m: [0.6, 0.4],
            },
        )
    }

    /// Retrieved from simulated points on such a plate 2 m ahead.
    fn shape_of_plate(slant_rad: f64, points: usize, independent_share: f64) -> Shape {
        let facing = Matrix3::from_columns(&[Vector3::y(), Vector3::z(), Vector3::x()]);
        let rotation = Rotation3::from_axis_angle(&Vector3::z_axis(), slant_rad);
        let plate = Primitive::Plane(Plane {
            centre: Point3::new(2.0, 0.0, 0.0),
            rotation: rotation * Rotation3::from_matrix_unchecked(facing),
            sides_m: [0.6, 0.4],
        });
        let sensor = Point3::origin();
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let points = simulate_view(&plate, &sensor, points, 0.005, &mut rng);
        let (surroundings, mixture) = (Surroundings::default(), Mixture::default());
        let settings = ShapeSettings {
            independent_share,
            ..ShapeSettings::default()
        };
        let found = retrieve(&points, &surroundings, &mixture, &sensor, &settings, 1);
        found.expect("a shape").best
    }

    #[test]
    fn a_box_is_an_alternative_only_behind_a_front_seen_squarely() {
        let (squarely, slanted) = (shape_of_plate(0.0, 150, 1.0), shape_of_plate(0.8, 150, 1.0));
        let boxes = |shape: &Shape| -> Vec<f64> {
            let listed = shape.alternatives.iter();
            let boxes = listed.filter(|a| a.class == Class::Box);
            boxes.map(|a| a.probability).collect()
        };
        assert_eq!(
            (squarely.class, slanted.class),
            (Class::Plane, Class::Plane)
        );
        let [box_behind] = boxes(&squarely)[..] else {
            panic!("{:?}", squarely.alternatives)
        };
        assert!((0.03..0.2).contains(&box_behind), "{box_behind}");
        assert!(boxes(&slanted).is_empty(), "{:?}", slanted.alternatives);
        let all = squarely.alternatives.iter().chain(&slanted.alternatives);
        assert!(all.clone().all(|a| a.probability >= 0.01));
        // With few points of a sweep it is likelier, and the shape is still a plane.
        let few = shape_of_plate(0.0, 60, 0.36);
        let [likelier] = boxes(&few)[..] else {
            panic!("{:?}", few.alternatives)
        };
        assert!(box_behind < likelier && likelier < 0.3, "{likelier}");
        assert_eq!(few.class, Class::Plane);
    }

    #[test]
    fn a_front_seen_squarely_hides_every_depth_and_a_slanted_one_hardly_any() {
        let range = BOUNDS.box_side_m;
        let min_thickness_m = (0.0625 * 0.4_f64).max(range.min);
        let all = (range.max / min_thickness_m).ln() / (range.max / range.min).ln();
        let squarely = depth_share(0.0, SurfaceModel::Visible);
        assert!((squarely - all).abs() < 1e-9, "{squarely} {all}");
        let shares = [0.2, 0.4, 0.8].map(|slant| depth_share(slant, SurfaceModel::Visible));
        assert!(squarely > shares[0] && shares[0] > shares[1] && shares[1] > shares[2]);
        // At 46 degrees a side of 3 cm takes a twentieth of the beams.
        assert!(shares[2] < 0.05, "{shares:?}");
        assert!(depth_share(0.0, SurfaceModel::Ideal).abs() < 1e-12);
    }
}
