//! Method B: which class's visible moments are the novelty's (Algorithm 2, one novelty at a time).

use super::constants::{
    BIASED_NOISE, BOARD_SHARE, HOPEFUL, LEAST_AXIS_VIEW_RAD, LEAST_FURTHER_POINTS,
    LEAST_LENGTH_SHARE, LEAST_NOISE_SHARE, LEAST_SEEN_NOISE, LEAST_SUPERQUADRIC_POINTS,
    MEDIAN_SCATTER, MOST_FITTED_POINTS, MOST_JUDGED, MOST_WITNESSES, OUTLIER_SIGMAS,
    PROMISING_COST, ROUGHNESS_SHARE, ROUNDS_OF_ALIKE, RULED_OUT_COST, SAME_ANSWER_M,
    UNEXPLAINED_SIGMAS, UNLIKELY_PENALTY,
};
use super::faces::{shows_one_face, tally_cost};
use super::hidden::hidden_share;
use super::matching::{Matched, Observed, Witness, matched};
use super::model::{Alternative, Class};
use super::primitive::{Plane, Primitive};
use super::remains::{more_than_strays, noise_among_neighbours_m, within, without_pattern};
use super::settings::{BeamDensity, ShapeSettings, SurfaceModel};
use super::starts::{alike, edged_starts, superquadric_starts};
use crate::mixture::Gaussian;
use nalgebra::{Isometry3, Matrix3, Point3, Unit, Vector3};

/// The most probable answer.
#[derive(Debug, Clone)]
pub(super) struct Candidate {
    pub primitive: Primitive,
    pub centre_sd_m: [f64; 3],
    pub size_sd_m: [f64; 3],
    /// Posterior among the classes.
    pub probability: f64,
    /// The same among what was fitted: a box that a front may hide is no rival that more points would tell apart.
    pub among_fitted: f64,
}

/// What the classes make of points with these moments: the most probable answer, and every class by falling
/// probability. `noise_m` is the standard deviation of a point. `None` if nothing could be fitted.
pub(super) fn candidates(
    points: &[Point3<f64>],
    moments: &Gaussian,
    sensor: &Point3<f64>,
    noise_m: f64,
    settings: &ShapeSettings,
) -> Option<(Candidate, Vec<Alternative>)> {
    let observed = observed(points, moments, sensor, noise_m, settings);
    let eigen = symmetric_axes(&moments.covariance);
    let view = Unit::try_new(-observed.sensor.coords, 1e-9).unwrap_or_else(Vector3::x_axis);
    let noiseless = moments.covariance - Matrix3::identity() * (noise_m * noise_m);
    let starts = Primitive::starts(&Point3::origin(), &noiseless, &view, &eigen);

    let mut fits: Vec<Vec<Matched>> = starts
        .into_iter()
        .map(|class| {
            let fits = class.into_iter();
            promising(fits.filter_map(|s| matched(&observed, s, None)).collect())
        })
        .collect();
    if settings.points_judge {
        fits = judged(&observed, fits, &view, &eigen);
    }
    let mut scored: Vec<(f64, Matched)> = fits
        .into_iter()
        .filter_map(|class| {
            let told = class.into_iter().filter(|f| !is_board(&f.primitive));
            let scored = told.map(|f| (score(&observed, &f, &view), f));
            scored.min_by(|a, b| a.0.total_cmp(&b.0))
        })
        .collect();
    scored.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut classes: Vec<(f64, Class)> = scored
        .iter()
        .map(|(score, fit)| (*score, fit.primitive.class()))
        .collect();
    if settings.points_judge && observed.points.len() >= LEAST_FURTHER_POINTS {
        with_hidden_box(&observed, &scored, &mut classes);
    }
    let (least, best) = scored.first()?;
    let odds = |score: f64| ((least - score) / 2.0).exp();
    let fitted: f64 = scored.iter().map(|(score, _)| odds(*score)).sum();
    let total: f64 = classes.iter().map(|(score, _)| odds(*score)).sum();
    let (centre_sd_m, size_sd_m) = best.spreads(&observed);
    let back = Isometry3::from_parts(moments.mean.coords.into(), Default::default());
    let best = Candidate {
        primitive: best.primitive.transformed(&back),
        centre_sd_m,
        size_sd_m,
        probability: 1.0 / total,
        among_fitted: 1.0 / fitted,
    };
    let alternatives = classes.into_iter().map(|(score, class)| Alternative {
        class,
        probability: odds(score) / total,
    });
    Some((best, alternatives.collect()))
}

/// Counts the box that the plane may be the front of, if it is likelier than the one that was fitted: as good a
/// fit, one parameter more, and only as far as its depth is hidden.
fn with_hidden_box(
    observed: &Observed,
    scored: &[(f64, Matched)],
    classes: &mut Vec<(f64, Class)>,
) {
    let plane = scored.iter().find_map(|(score, fit)| match fit.primitive {
        Primitive::Plane(plane) => Some((score, plane)),
        _ => None,
    });
    // What is no plane is no front either.
    let limit_m = BIASED_NOISE * expected_m(observed);
    let is_flat =
        |plane: &Plane| typical_distance_m(observed, &Primitive::Plane(*plane)) <= limit_m;
    let plane = plane.filter(|(_, plane)| is_flat(plane));
    let Some((score, plane)) = plane else { return };
    let hidden = score + observed.count.ln() - 2.0 * hidden_share(observed, &plane).ln();
    match classes.iter_mut().find(|(_, class)| *class == Class::Box) {
        Some((fitted, _)) => *fitted = fitted.min(hidden),
        None => classes.push((hidden, Class::Box)),
    }
    classes.sort_by(|a, b| a.0.total_cmp(&b.0));
}

/// What of a surface the points show: all of the ideal one where the sensor stands among them.
pub(super) fn shown(
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

/// Coordinates about the mean.
fn observed(
    points: &[Point3<f64>],
    moments: &Gaussian,
    sensor: &Point3<f64>,
    noise_m: f64,
    settings: &ShapeSettings,
) -> Observed {
    let (surface, density) = shown(points, sensor, settings);
    let stride = points.len().div_ceil(MOST_FITTED_POINTS).max(1);
    Observed::new(
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

/// The fits that points or likelihood of form may yet prefer, the cheapest first.
fn promising(mut fits: Vec<Matched>) -> Vec<Matched> {
    fits.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let least = fits.first().map_or(0.0, |f| f.cost);
    fits.retain(|f| f.cost <= least + PROMISING_COST);
    // Several starts that ended in one place are one answer.
    fits.dedup_by(|later, kept| {
        let apart = (later.primitive.centre() - kept.primitive.centre()).norm();
        (later.cost - kept.cost).abs() < 1e-3 * (1.0 + kept.cost) && apart < SAME_ANSWER_M
    });
    fits
}

/// Matches again with the points as witnesses, and asks further classes where these leave points
/// unexplained. Where even the best surface lies farther from them than the noise, that distance is
/// taken as their spread, so that a rough thing stays uncertain.
fn judged(
    observed: &Observed,
    fits: Vec<Vec<Matched>>,
    view: &Unit<Vector3<f64>>,
    axes: &[Unit<Vector3<f64>>],
) -> Vec<Vec<Matched>> {
    let expected = expected_m(observed);
    let first = witness(observed, expected);
    // Where the moments alone rule a class out, its points need not be asked.
    let cheapest = |class: &[Matched]| {
        let costs = class.iter().map(|fit| fit.cost);
        costs.fold(f64::INFINITY, f64::min)
    };
    let least = fits
        .iter()
        .map(|class| cheapest(class))
        .fold(f64::INFINITY, f64::min);
    let ruled_out = |class: &[Matched]| cheapest(class) > least + RULED_OUT_COST;
    let fits: Vec<Vec<Matched>> = fits.into_iter().filter(|class| !ruled_out(class)).collect();
    let best_of = |mut class: Vec<Matched>| {
        class.retain(|fit| !is_board(&fit.primitive));
        class.sort_by(|a, b| score(observed, a, view).total_cmp(&score(observed, b, view)));
        class.truncate(MOST_JUDGED);
        class
    };
    let mut fits: Vec<Vec<Matched>> = again(observed, first, fits)
        .into_iter()
        .map(best_of)
        .collect();
    let enough = observed.points.len() >= LEAST_FURTHER_POINTS;
    let explains = |primitive: &Primitive| {
        within(observed, primitive, observed.noise_m)
            && !more_than_strays(observed, primitive, observed.noise_m)
            && without_pattern(observed, primitive, axes)
            && unlikely(observed, primitive, view) == 0.0
    };
    let asked = enough && !most_likely(observed, &fits, view).is_some_and(explains);
    if asked {
        let starts = edged_starts(observed, axes, expected);
        fits.extend(starts.map(|class| best_of(drawn_in(observed, class, first))));
    }
    // A superquadric follows any pattern, and a laser's own bias is one: it is asked where most points
    // lie farther off than their neighbours' noise, or than noise and a bias of its size.
    let enough = asked && observed.points.len() >= LEAST_SUPERQUADRIC_POINTS;
    let scatter = MEDIAN_SCATTER / (observed.points.len() as f64).sqrt();
    let explains = |primitive: &Primitive| {
        let own = noise_among_neighbours_m(&observed.points);
        let limit = (own.max(expected) * (1.0 + scatter)).min(BIASED_NOISE * expected);
        typical_distance_m(observed, primitive) <= limit
    };
    let near = |primitive: &Primitive, times: f64| {
        typical_distance_m(observed, primitive) <= times * BIASED_NOISE * expected
    };
    if enough && !most_likely(observed, &fits, view).is_some_and(explains) {
        let fitted: Vec<Primitive> = fits.iter().flatten().map(|fit| fit.primitive).collect();
        let starts = superquadric_starts(observed, axes, &fitted, expected);
        let mut found = best_of(drawn_in(observed, starts, first));
        for _ in 0..ROUNDS_OF_ALIKE {
            let others = found.iter().filter_map(|fit| match fit.primitive {
                Primitive::Superquadric(s) if near(&fit.primitive, HOPEFUL) => Some(alike(&s)),
                _ => None,
            });
            let others = drawn_in(observed, others.flatten().collect(), first);
            found = best_of(found.into_iter().chain(others).collect());
        }
        let told = (1.0 + UNEXPLAINED_SIGMAS * scatter).min(BIASED_NOISE);
        found.retain(|fit| near(&fit.primitive, told / BIASED_NOISE));
        fits.push(found);
    }
    // What no class explains (a person) is no box either, only because that came closest.
    let simple = [Class::Sphere, Class::Cylinder, Class::Plane];
    for class in &mut fits {
        class.retain(|fit| simple.contains(&fit.primitive.class()) || near(&fit.primitive, 1.0));
    }
    let least = fits
        .iter()
        .flatten()
        .map(|fit| typical_distance_m(observed, &fit.primitive))
        .fold(f64::INFINITY, f64::min);
    // Points that lie closer than expected are better witnesses than expected, if there are enough to tell.
    let tells = observed.points.len() >= LEAST_SEEN_NOISE || least > expected;
    let least = least.max(expected * LEAST_NOISE_SHARE);
    if least.is_finite() && tells {
        again(observed, witness(observed, least), fits)
    } else {
        fits
    }
}

/// Every fit matched again with this witness.
fn again(observed: &Observed, witness: Witness, fits: Vec<Vec<Matched>>) -> Vec<Vec<Matched>> {
    let class = |class: Vec<Matched>| {
        let fits = class.into_iter();
        fits.filter_map(|fit| matched(observed, fit.primitive, Some(witness)))
            .collect()
    };
    fits.into_iter().map(class).collect()
}

/// Fits from rough starts: first with a witness as rough as the start, then with the true one.
fn drawn_in(observed: &Observed, starts: Vec<Primitive>, witness: Witness) -> Vec<Matched> {
    let rough = |start: &Primitive| Witness {
        sd_m: typical_distance_m(observed, start).max(witness.sd_m),
        ..witness
    };
    let fits = starts.into_iter().filter_map(|start| {
        let near = matched(observed, start, Some(rough(&start)))?;
        matched(observed, near.primitive, Some(witness))
    });
    fits.collect()
}

/// Standard deviation of a point of a thing that is of its class: noise and roughness, metres.
fn expected_m(observed: &Observed) -> f64 {
    observed.noise_m.hypot(ROUGHNESS_SHARE * observed.scale_m)
}

fn witness(observed: &Observed, sd_m: f64) -> Witness {
    Witness {
        sd_m,
        count: observed.count.min(MOST_WITNESSES),
    }
}

/// The best of all fits.
fn most_likely<'a>(
    observed: &Observed,
    fits: &'a [Vec<Matched>],
    view: &Unit<Vector3<f64>>,
) -> Option<&'a Primitive> {
    let scored = fits
        .iter()
        .flatten()
        .map(|fit| (score(observed, fit, view), fit));
    let best = scored.min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(&best.1.primitive)
}

/// Standard deviation of the points about the surface by their median distance, and for the freedom
/// that the fit took.
fn typical_distance_m(observed: &Observed, primitive: &Primitive) -> f64 {
    let mut distances: Vec<f64> = observed
        .points
        .iter()
        .map(|p| observed.distance_m(primitive, p).abs())
        .collect();
    distances.sort_by(f64::total_cmp);
    let median = distances.get(distances.len() / 2).copied();
    let n = distances.len() as f64;
    let free = (n - primitive.parameters() as f64).max(1.0);
    median.unwrap_or(f64::INFINITY) / 0.6745 * (n / free).sqrt()
}

/// (n/2) d_FM^2 + mean term + points + tally of the faces + k ln n, and what the class finds unlikely.
fn score(observed: &Observed, fit: &Matched, view: &Unit<Vector3<f64>>) -> f64 {
    let k = fit.primitive.parameters() as f64;
    let tally = tally_cost(observed, &fit.primitive);
    fit.cost + k * observed.count.ln() + tally + unlikely(observed, &fit.primitive, view)
}

/// What a class finds unlikely in this form of itself.
fn unlikely(observed: &Observed, primitive: &Primitive, view: &Unit<Vector3<f64>>) -> f64 {
    match primitive {
        Primitive::Cylinder(c) => {
            let along_view = c.axis.dot(view).abs() > LEAST_AXIS_VIEW_RAD.cos();
            if c.length_m < LEAST_LENGTH_SHARE * 2.0 * c.radius_m || along_view {
                UNLIKELY_PENALTY
            } else {
                0.0
            }
        }
        Primitive::Cuboid(b) => {
            // Noise as told or as seen about the box itself, whichever is more.
            let reach_m = || {
                OUTLIER_SIGMAS * expected_m(observed).max(typical_distance_m(observed, primitive))
            };
            if shows_one_face(observed, b, reach_m()) {
                UNLIKELY_PENALTY
            } else {
                0.0
            }
        }
        _ => 0.0,
    }
}

/// A box that is told as plane, however well it takes what lies beside the plane.
fn is_board(primitive: &Primitive) -> bool {
    let [_, second, third] = primitive.size_m();
    matches!(primitive, Primitive::Cuboid(_)) && third < BOARD_SHARE * second
}

/// Eigenvectors by falling eigenvalue.
fn symmetric_axes(covariance: &Matrix3<f64>) -> Vec<Unit<Vector3<f64>>> {
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
    use crate::novelty::Rim;
    use crate::shape::primitive::{Plane, Primitive};
    use crate::shape::scenes::look;
    use crate::shape::{Class, ShapeSettings, retrieve};
    use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    /// A door and a strip of its frame: a thin box would take both.
    #[test]
    fn a_board_stays_a_plane_where_a_strip_lies_just_behind_it() {
        let facing = Matrix3::from_columns(&[Vector3::y(), Vector3::z(), Vector3::x()]);
        let door = Primitive::Plane(Plane {
            centre: Point3::new(2.0, 0.0, 0.0),
            rotation: Rotation3::from_matrix_unchecked(facing),
            sides_m: [1.0, 0.8],
        });
        let sensor = Point3::origin();
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut points = look(&door, &sensor, 150, 0.004, &mut rng);
        points.extend((0..14).map(|k| Point3::new(2.04, 0.505, -0.35 + 0.05 * f64::from(k))));
        let (rim, mixture) = (Rim::default(), Mixture::default());
        let settings = ShapeSettings::default();
        let found = retrieve(&points, &rim, &mixture, &sensor, &settings, 1);
        let best = found.expect("a shape").best;
        assert_eq!(best.class, Class::Plane, "{best:?}");
    }
}
