//! Whether a view can be what a sensor saw from where it is said to have stood, in metres.

use super::NoveltyError;
use super::bounding_box::BoundingBox;
use super::constants::{
    HIDDEN_DEPTH_SHARE, LAYER_NEIGHBOURS, MAX_HIDDEN_SHARE, MAX_SPREAD_M, MIN_OUTSIDE_SHARE,
    PLAUSIBILITY_SAMPLES,
};
use crate::geometry::View;
use nalgebra::{Point3, Vector3};

/// The box between the first and the last hundredth of `points` along each axis: outliers do not move it.
fn middle_box(points: &[Point3<f64>]) -> BoundingBox {
    let quantile = |axis: usize, share: f64| {
        let mut along: Vec<f64> = points.iter().map(|p| p[axis]).collect();
        let at = (share * along.len() as f64) as usize;
        let at = at.min(along.len().saturating_sub(1));
        *along.select_nth_unstable_by(at, f64::total_cmp).1
    };
    let corner = |share| Point3::from([0, 1, 2].map(|axis| quantile(axis, share)));
    BoundingBox::new([corner(0.01), corner(0.99)])
}

/// Refuses a view, called `name`, that can be no sensor's in metres. `view` has at least one point, all finite.
///
/// # Errors
/// The points spread over kilometres, or the sensor would have looked through most of them.
pub(super) fn check_plausible(view: &View, name: &'static str) -> Result<(), NoveltyError> {
    let step = view.points.len().div_ceil(PLAUSIBILITY_SAMPLES).max(1);
    let sample: Vec<Point3<f64>> = view.points.iter().step_by(step).copied().collect();
    let middle = middle_box(&sample);
    let spread_m = middle.diagonal_m();
    if spread_m > MAX_SPREAD_M {
        return Err(NoveltyError::Spread { name, spread_m });
    }
    let outside_m = middle.gap_m(&BoundingBox::new([view.origin]));
    if outside_m > MIN_OUTSIDE_SHARE * spread_m
        && hidden_share(&sample, &view.origin, HIDDEN_DEPTH_SHARE * spread_m) > MAX_HIDDEN_SHARE
    {
        return Err(NoveltyError::Origin {
            name,
            origin: view.origin.into(),
            outside_m,
            middle: middle.centre().into(),
        });
    }
    Ok(())
}

/// Share of the points whose nearest neighbours by direction are nearer or farther than they by more than `depth_m` in all: a
/// sensor sees one surface in each direction.
fn hidden_share(points: &[Point3<f64>], origin: &Point3<f64>, depth_m: f64) -> f64 {
    let rays: Vec<(Vector3<f64>, f64)> = points
        .iter()
        .filter_map(|p| {
            let offset = p - origin;
            Some((offset.try_normalize(1e-9)?, offset.norm()))
        })
        .collect();
    let is_hidden = |(direction, range_m): &&(Vector3<f64>, f64)| {
        // The nearest of all is the ray itself.
        let mut nearest = [(f64::INFINITY, *range_m); LAYER_NEIGHBOURS];
        for (d, r) in &rays {
            let apart = (d - direction).norm_squared();
            if apart < nearest[LAYER_NEIGHBOURS - 1].0 {
                nearest[LAYER_NEIGHBOURS - 1] = (apart, *r);
                nearest.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
            }
        }
        let ranges = nearest.map(|(_, r)| r);
        let far_m = ranges.into_iter().fold(f64::NEG_INFINITY, f64::max);
        far_m - ranges.into_iter().fold(f64::INFINITY, f64::min) > depth_m
    };
    let hidden = rays.iter().filter(is_hidden).count();
    hidden as f64 / (rays.len() as f64).max(1.0)
}

#[cfg(test)]
mod tests {
    use super::check_plausible;
    use crate::geometry::View;
    use crate::novelty::NoveltyError;
    use nalgebra::{Point3, Vector3};

    /// Walls, floor and ceiling of a room of 5 x 4 x 2.5 m as a sensor at its middle sees them, in units of `unit_m`.
    fn room(unit_m: f64) -> Vec<Point3<f64>> {
        let half = Vector3::new(2.5, 2.0, 1.25);
        let beams = (-180..180).flat_map(|az| (-14..=14).map(move |el| (az, 6 * el)));
        beams
            .map(|(az, el)| {
                let (sin, cos) = f64::from(az).to_radians().sin_cos();
                let (up, flat) = f64::from(el).to_radians().sin_cos();
                let d = Vector3::new(flat * cos, flat * sin, up);
                let range = (0..3).map(|k| half[k] / d[k].abs().max(1e-9));
                Point3::from(d * range.fold(f64::INFINITY, f64::min) / unit_m)
            })
            .collect()
    }

    fn check(points: Vec<Point3<f64>>, origin: [f64; 3]) -> Result<(), NoveltyError> {
        let view = View::from_points(points, Point3::from(origin));
        check_plausible(&view, "current")
    }

    #[test]
    fn a_sensor_that_would_look_through_walls_is_refused() {
        for origin in [[20.0, 3.0, 0.0], [-400.0, 0.0, 0.0], [1e5, 5e6, 300.0]] {
            let error = check(room(1.0), origin).expect_err("outside");
            assert!(
                matches!(
                    error,
                    NoveltyError::Origin {
                        name: "current",
                        ..
                    }
                ),
                "{error}"
            );
        }
        for origin in [[0.0; 3], [2.0, 1.5, 1.0], [2.7, 0.0, 0.0]] {
            check(room(1.0), origin).expect("inside, or just outside");
        }
        // A sensor that sees one wall from afar looks through nothing.
        let wall: Vec<_> = room(1.0).into_iter().filter(|p| p.x > 2.49).collect();
        check(wall, [-20.0, 0.0, 0.0]).expect("one surface");
    }

    #[test]
    fn a_room_of_kilometres_is_refused_and_one_far_point_is_not() {
        let error = check(room(0.001), [0.0; 3]).expect_err("millimetres");
        assert!(
            error.to_string().contains("are these millimetres"),
            "{error}"
        );
        let mut points = room(1.0);
        points.push(Point3::new(1e9, 0.0, 0.0));
        check(points, [0.0; 3]).expect("one outlier");
    }
}
