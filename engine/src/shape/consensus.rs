//! Method A: shapes by random sample consensus of the novelty's points, or of samples on its ellipsoids.

use super::constants::{
    CONSENSUS_EPSILON_SHARE, MAX_CONSENSUS_POINTS, MIN_LISTED_PROBABILITY, MIN_NOISE_M,
    NORMAL_NEIGHBOURS, RESIDUAL_POINTS, ROUGHNESS_SHARE,
};
use super::model::{Alternative, Class, Method, Shape};
use super::primitive::Primitive;
use super::ransac::{
    ClassFit, RansacSettings, detect, estimate_normals, fit_classes, surface_samples,
};
use super::settings::{RansacSource, ShapeSettings};
use crate::mixture::{Gaussian, Mixture};
use nalgebra::{Point3, Vector3};
use std::borrow::Cow;

/// Method A's answer: the class of least cost for the points or samples; probabilities are posteriors. `None` if no class
/// has enough inliers.
pub(super) fn ransac_shape(
    points: &[Point3<f64>],
    mixture: &Mixture,
    sensor: &Point3<f64>,
    noise_m: f64,
    settings: &ShapeSettings,
    seed: u64,
) -> Option<Shape> {
    let fits = match settings.ransac_source {
        RansacSource::Ellipsoids { samples, scale } if !mixture.is_empty() => {
            let (points, normals) = surface_samples(mixture, samples, scale, seed);
            let chosen = settings.ransac.unwrap_or_else(|| {
                let epsilon_m = CONSENSUS_EPSILON_SHARE * spread_m(&points);
                RansacSettings::with_defaults(points.len(), epsilon_m, 1)
            });
            fit_classes(&points, &normals, &chosen, seed)
        }
        _ => {
            let points = subsample(points, MAX_CONSENSUS_POINTS);
            let chosen = settings_for_points(&points, noise_m, settings, 1);
            let normals = estimate_normals(&points, sensor, NORMAL_NEIGHBOURS);
            fit_classes(&points, &normals, &chosen, seed)
        }
    };
    let best = fits.first()?;
    let odds = |fit: &ClassFit| (-(fit.cost - best.cost) / 2.0).exp();
    let total: f64 = fits.iter().map(odds).sum();
    let band_m = 3.0 * noise_m.hypot(ROUGHNESS_SHARE * spread_m(points));
    let primitive = best.detected.primitive;
    let mut shape = to_shape(
        &primitive,
        points.iter(),
        points.len(),
        sensor,
        settings.independent_share,
    );
    shape.probability = 1.0 / total;
    shape.alternatives = [Class::Sphere, Class::Cylinder, Class::Plane]
        .into_iter()
        .filter(|&class| class != primitive.class())
        .map(|class| {
            let same_class = |fit: &&ClassFit| fit.detected.primitive.class() == class;
            Alternative {
                class,
                probability: fits.iter().find(same_class).map_or(0.0, odds) / total,
            }
        })
        .collect();
    shape
        .alternatives
        .retain(|a| a.probability >= MIN_LISTED_PROBABILITY);
    shape
        .alternatives
        .sort_by(|a, b| b.probability.total_cmp(&a.probability));
    shape.inliers = points
        .iter()
        .filter(|p| primitive.visible_distance_m(p, sensor).abs() < band_m)
        .count();
    Some(shape)
}

/// All spheres, cylinders and planes of a cloud, with disjoint points, most points first; their probability is the share of
/// the points. `normals[i]` is the unit normal of `points[i]`; `None` estimates them from the neighbours. Points (metres)
/// that are not finite take no part. Empty if no primitive has enough points.
pub fn detect_shapes(
    points: &[Point3<f64>],
    normals: Option<&[Vector3<f64>]>,
    sensor_origin: &Point3<f64>,
    settings: &ShapeSettings,
    seed: u64,
) -> Vec<Shape> {
    let is_finite_point = |p: &Point3<f64>| p.iter().all(|v| v.is_finite());
    let normals = normals.filter(|n| n.len() == points.len());
    let (finite_points, normals) = if points.iter().all(is_finite_point) {
        (Cow::Borrowed(points), normals.map(Cow::Borrowed))
    } else {
        let is_finite = |i: &usize| is_finite_point(&points[*i]);
        let kept: Vec<usize> = (0..points.len()).filter(is_finite).collect();
        let normals = normals.map(|n| kept.iter().map(|&i| n[i]).collect());
        (kept.iter().map(|&i| points[i]).collect(), normals)
    };
    let subset = subsample(&finite_points, MAX_CONSENSUS_POINTS);
    let range_m = Gaussian::from_points(&subset).map_or(0.0, |g| (g.mean - sensor_origin).norm());
    let noise_m = settings.noise.sigma_m(range_m).max(MIN_NOISE_M);
    let chosen = settings_for_points(&finite_points, noise_m, settings, usize::MAX)
        .with_cells_for(&finite_points);
    let chosen = if normals.is_some() {
        chosen.with_given_normals()
    } else {
        chosen
    };
    let normals = normals.unwrap_or_else(|| {
        estimate_normals(&finite_points, sensor_origin, NORMAL_NEIGHBOURS).into()
    });
    let mut found = detect(&finite_points, &normals, &chosen, seed);
    found.sort_by_key(|d| std::cmp::Reverse(d.inliers.len()));
    found
        .iter()
        .map(|d| {
            let stride = d.inliers.len().div_ceil(RESIDUAL_POINTS).max(1);
            let subset = d.inliers.iter().step_by(stride);
            let mut shape = to_shape(
                &d.primitive,
                subset.filter_map(|&i| finite_points.get(i)),
                d.inliers.len(),
                sensor_origin,
                settings.independent_share,
            );
            shape.probability = d.inliers.len() as f64 / points.len().max(1) as f64;
            shape
        })
        .collect()
}

/// The configured settings, or those for points with this noise.
fn settings_for_points(
    points: &[Point3<f64>],
    noise_m: f64,
    settings: &ShapeSettings,
    max: usize,
) -> RansacSettings {
    settings.ransac.unwrap_or_else(|| {
        let epsilon_m = 3.0 * noise_m.hypot(ROUGHNESS_SHARE * spread_m(points));
        RansacSettings::with_defaults(points.len(), epsilon_m, max)
    })
}

/// All points, or an even selection of at most `max`.
fn subsample(points: &[Point3<f64>], max: usize) -> Vec<Point3<f64>> {
    let stride = points.len().div_ceil(max).max(1);
    points.iter().step_by(stride).copied().collect()
}

/// Standard deviation over all directions, metres.
fn spread_m(points: &[Point3<f64>]) -> f64 {
    Gaussian::from_points(points).map_or(0.0, |g| g.covariance.trace().max(0.0).sqrt())
}

/// The shape of a primitive with this number of inliers; `points` are all of them or an even selection. Its standard
/// deviations are those of a least-squares fit, residual times sqrt(k / n), with the spacing of the points for extents.
fn to_shape<'a>(
    primitive: &Primitive,
    points: impl Iterator<Item = &'a Point3<f64>>,
    inliers: usize,
    sensor: &Point3<f64>,
    independent_share: f64,
) -> Shape {
    let (mut count, mut squares) = (0, 0.0);
    for p in points {
        count += 1;
        squares += primitive.visible_distance_m(p, sensor).powi(2);
    }
    let residual_m = (squares / f64::from(count.max(1))).sqrt();
    let n = inliers.max(1) as f64;
    let size_m = primitive.size_m();
    let k = primitive.parameter_count() as f64;
    let surface_sd = residual_m * (k / (n * independent_share).max(1.0)).sqrt();
    let spacing = (size_m[0] * size_m[1].max(size_m[2]) / n).sqrt();
    let extent_sd = surface_sd.hypot(spacing);
    let (size_sd_m, centre_sd) = match primitive {
        Primitive::Sphere(_) => ([2.0 * surface_sd; 3], surface_sd),
        Primitive::Cylinder(_) => ([2.0 * surface_sd, 2.0 * surface_sd, extent_sd], extent_sd),
        Primitive::Plane(_) => ([extent_sd, extent_sd, 0.0], extent_sd),
        _ => ([extent_sd; 3], extent_sd),
    };
    Shape {
        class: primitive.class(),
        method: Method::Ransac,
        probability: 1.0,
        alternatives: Vec::new(),
        centre: primitive.centre(),
        centre_sd_m: [centre_sd; 3],
        rotation: primitive.canonical_rotation(sensor),
        size_m,
        size_sd_m,
        exponents: primitive.exponents(),
        residual_m,
        inliers,
    }
}

#[cfg(test)]
mod tests {
    use super::ransac_shape;
    use crate::mixture::{FitSettings, Mixture, fit};
    use crate::shape::constants::MIN_NOISE_M;
    use crate::shape::settings::{RansacSource, ShapeSettings};
    use crate::shape::tests::scenes::{random_primitive, simulate_view};
    use nalgebra::Point3;

    /// Share of right answers for each class over 100 simulated views of 60 points or more.
    fn right(sigma_m: f64, ransac_source: RansacSource) -> [f64; 3] {
        let sensor = Point3::origin();
        let settings = ShapeSettings {
            ransac_source,
            ..ShapeSettings::default()
        };
        let is_right = |class: usize, seed: u64| {
            let (truth, mut rng) = random_primitive(class, seed);
            let mut wanted = 60 + (seed % 60) as usize;
            let seen = loop {
                let seen = simulate_view(&truth, &sensor, wanted, sigma_m, &mut rng);
                if seen.len() >= 60 {
                    break seen;
                }
                wanted += 2;
            };
            let mixture = match ransac_source {
                RansacSource::Points => Mixture::default(),
                RansacSource::Ellipsoids { .. } => {
                    let fitted = fit(&seen, None, &FitSettings::default());
                    fitted.expect("a mixture").mixture
                }
            };
            let noise_m = sigma_m.max(MIN_NOISE_M);
            let answer = ransac_shape(&seen, &mixture, &sensor, noise_m, &settings, seed);
            answer.is_some_and(|shape| shape.class == truth.class())
        };
        std::array::from_fn(|class| {
            let right = (3000..3100).filter(|&seed| is_right(class, seed));
            right.count() as f64 / 100.0
        })
    }

    #[test]
    fn the_class_is_found_from_points() {
        for sigma_m in [0.032, 0.001] {
            let right = right(sigma_m, RansacSource::Points);
            eprintln!("points, sigma {sigma_m} m: right {right:?}");
            assert!(right.iter().all(|r| *r >= 0.98), "{sigma_m}: {right:?}");
        }
    }

    #[test]
    fn the_class_is_found_less_often_from_samples_on_ellipsoids() {
        for sigma_m in [0.032, 0.001] {
            let samples = ShapeSettings::paper().ransac_source;
            let right = right(sigma_m, samples);
            eprintln!("samples, sigma {sigma_m} m: right {right:?}");
            assert!(right.iter().all(|r| *r >= 0.85), "{sigma_m}: {right:?}");
        }
    }
}
