//! Method B: the class whose visible moments are the novelty's (paper Algorithm 2, one novelty at a time).

use super::estimate::PrimitiveEstimate;
use super::evidence::hidden_box::hidden_depth_share;
use super::fit::{MatchedPrimitive, Observation, match_primitive};
use super::refine::refine;
use super::score::{expected_sd_m, is_plate, score, typical_distance_m};
use crate::mixture::Gaussian;
use crate::shape::constants::{
    BIASED_NOISE_RATIO, MAX_FITTED_POINTS, MIN_POINTS_BOX_CONE, PROMISING_COST, SAME_CENTRE_M,
};
use crate::shape::model::{Alternative, Class};
use crate::shape::primitive::{Plane, Primitive};
use crate::shape::settings::{BeamDensity, ShapeSettings, SurfaceModel};
use nalgebra::{Isometry3, Matrix3, Point3, Unit, Vector3};

/// The most probable primitive for points with these moments, and every class by falling probability. `noise_m` is the
/// standard deviation of a point. `None` if nothing could be fitted.
pub(in crate::shape) fn match_classes(
    points: &[Point3<f64>],
    moments: &Gaussian,
    sensor: &Point3<f64>,
    noise_m: f64,
    settings: &ShapeSettings,
) -> Option<(PrimitiveEstimate, Vec<Alternative>)> {
    let observed = observation(points, moments, sensor, noise_m, settings);
    let axes = principal_axes(&moments.covariance);
    let view = Unit::try_new(-observed.sensor.coords, 1e-9).unwrap_or_else(Vector3::x_axis);
    let noiseless = moments.covariance - Matrix3::identity() * (noise_m * noise_m);
    let starts = Primitive::initial_guesses(&Point3::origin(), &noiseless, &view, &axes);

    let mut fits: Vec<Vec<MatchedPrimitive>> = starts
        .into_iter()
        .map(|class| {
            let fits = class.into_iter();
            promising(
                fits.filter_map(|start| match_primitive(&observed, start, None))
                    .collect(),
            )
        })
        .collect();
    if settings.use_point_distances {
        fits = refine(&observed, fits, &view, &axes);
    }
    let mut scored: Vec<(f64, MatchedPrimitive)> = fits
        .into_iter()
        .filter_map(|class| {
            let fits = class.into_iter().filter(|fit| !is_plate(&fit.primitive));
            let scored = fits.map(|fit| (score(&observed, &fit, &view), fit));
            scored.min_by(|a, b| a.0.total_cmp(&b.0))
        })
        .collect();
    scored.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut classes: Vec<(f64, Class)> = scored
        .iter()
        .map(|(score, fit)| (*score, fit.primitive.class()))
        .collect();
    if settings.use_point_distances && observed.points.len() >= MIN_POINTS_BOX_CONE {
        add_hidden_box(&observed, &scored, &mut classes);
    }
    let (least, best) = scored.first()?;
    let odds = |score: f64| ((least - score) / 2.0).exp();
    let fitted: f64 = scored.iter().map(|(score, _)| odds(*score)).sum();
    let total: f64 = classes.iter().map(|(score, _)| odds(*score)).sum();
    let (centre_sd_m, size_sd_m) = best.standard_deviations(&observed);
    let from_mean = Isometry3::from_parts(moments.mean.coords.into(), Default::default());
    let best = PrimitiveEstimate {
        primitive: best.primitive.transformed(&from_mean),
        centre_sd_m,
        size_sd_m,
        probability: 1.0 / total,
        probability_among_fitted: 1.0 / fitted,
    };
    let alternatives = classes.into_iter().map(|(score, class)| Alternative {
        class,
        probability: odds(score) / total,
    });
    Some((best, alternatives.collect()))
}

/// Adds the box whose front the plane may be, if it is likelier than the box that was fitted: as good a fit, one
/// parameter more, and only for depths that the front hides.
fn add_hidden_box(
    observed: &Observation,
    scored: &[(f64, MatchedPrimitive)],
    classes: &mut Vec<(f64, Class)>,
) {
    let plane = scored.iter().find_map(|(score, fit)| match fit.primitive {
        Primitive::Plane(plane) => Some((score, plane)),
        _ => None,
    });
    // What is no plane is no front either.
    let limit_m = BIASED_NOISE_RATIO * expected_sd_m(observed);
    let is_flat =
        |plane: &Plane| typical_distance_m(observed, &Primitive::Plane(*plane)) <= limit_m;
    let plane = plane.filter(|(_, plane)| is_flat(plane));
    let Some((score, plane)) = plane else { return };
    let hidden =
        score + observed.effective_points.ln() - 2.0 * hidden_depth_share(observed, &plane).ln();
    match classes.iter_mut().find(|(_, class)| *class == Class::Box) {
        Some((fitted, _)) => *fitted = fitted.min(hidden),
        None => classes.push((hidden, Class::Box)),
    }
    classes.sort_by(|a, b| a.0.total_cmp(&b.0));
}

/// The surface model and density of the settings, or those of a whole surface where the sensor is among the points.
pub(in crate::shape) fn surface_model_for(
    points: &[Point3<f64>],
    sensor: &Point3<f64>,
    settings: &ShapeSettings,
) -> (SurfaceModel, BeamDensity) {
    let among = (0..3).all(|k| {
        points.iter().any(|p| p[k] <= sensor[k]) && points.iter().any(|p| p[k] >= sensor[k])
    });
    if among {
        (SurfaceModel::Ideal, BeamDensity::Area)
    } else {
        (settings.surface, settings.density)
    }
}

fn observation(
    points: &[Point3<f64>],
    moments: &Gaussian,
    sensor: &Point3<f64>,
    noise_m: f64,
    settings: &ShapeSettings,
) -> Observation {
    let (surface, density) = surface_model_for(points, sensor, settings);
    let stride = points.len().div_ceil(MAX_FITTED_POINTS).max(1);
    Observation::new(
        &moments.covariance,
        (points.len() as f64 * settings.independent_share.min(1.0)).max(1.0),
        noise_m,
        Point3::from(sensor - moments.mean),
        points
            .iter()
            .step_by(stride)
            .map(|p| Point3::from(p - moments.mean))
            .collect(),
        surface,
        density,
    )
}

/// The fits of one class that may still become its best, cheapest first.
fn promising(mut fits: Vec<MatchedPrimitive>) -> Vec<MatchedPrimitive> {
    fits.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let least = fits.first().map_or(0.0, |f| f.cost);
    fits.retain(|f| f.cost <= least + PROMISING_COST);
    // Several starts may end in the same fit.
    fits.dedup_by(|later, kept| {
        let apart = (later.primitive.centre() - kept.primitive.centre()).norm();
        (later.cost - kept.cost).abs() < 1e-3 * (1.0 + kept.cost) && apart < SAME_CENTRE_M
    });
    fits
}

/// Eigenvectors by falling eigenvalue.
fn principal_axes(covariance: &Matrix3<f64>) -> Vec<Unit<Vector3<f64>>> {
    let eigen = covariance.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    order
        .iter()
        .map(|&k| Unit::new_normalize(eigen.eigenvectors.column(k).into_owned()))
        .collect()
}

#[cfg(test)]
mod tests {
    use crate::mixture::Mixture;
    use crate::novelty::Surroundings;
    use crate::shape::primitive::{Plane, Primitive};
    use crate::shape::tests::scenes::simulate_view;
    use crate::shape::{Class, ShapeSettings, retrieve};
    use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    /// A door and a strip of its frame: a thin box would take both.
    #[test]
    fn a_plate_stays_a_plane_where_a_strip_is_just_behind_it() {
        let facing = Matrix3::from_columns(&[Vector3::y(), Vector3::z(), Vector3::x()]);
        let door = Primitive::Plane(Plane {
            centre: Point3::new(2.0, 0.0, 0.0),
            rotation: Rotation3::from_matrix_unchecked(facing),
            sides_m: [1.0, 0.8],
        });
        let sensor = Point3::origin();
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut points = simulate_view(&door, &sensor, 150, 0.004, &mut rng);
        points.extend((0..14).map(|k| Point3::new(2.04, 0.505, -0.35 + 0.05 * f64::from(k))));
        let (surroundings, mixture) = (Surroundings::default(), Mixture::default());
        let settings = ShapeSettings::default();
        let found = retrieve(&points, &surroundings, &mixture, &sensor, &settings, 1);
        let best = found.expect("a shape").best;
        assert_eq!(best.class, Class::Plane, "{best:?}");
    }
}
