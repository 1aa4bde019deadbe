//! Both methods on one novelty, and the choice between them.

use super::consensus::{detect_shapes, ransac_shape};
use super::constants::{
    MIN_INLIER_SHARE, MIN_LISTED_PROBABILITY, MIN_NOISE_M, MIN_POINTS, MIN_SPREAD_M,
    ROUGHNESS_SHARE,
};
use super::error::ShapeError;
use super::matching::estimate::PrimitiveEstimate;
use super::matching::extent::lengths::{EdgeObservations, measure_lengths};
use super::matching::select::{match_classes, surface_model_for};
use super::model::{Alternative, Class, Method, Retrieval, Shape};
use super::points::extension::extend_along_surface;
use super::points::outliers::remove_outliers;
use super::settings::{MethodChoice, ShapeSettings};
use crate::mixture::{Gaussian, Mixture};
use crate::novelty::Surroundings;
use nalgebra::{Matrix3, Point3, Vector3};

/// The shape of one novelty from its points (metres), their surroundings, its Gaussians, and the sensor's position.
/// Where `mixture` is empty, the points' own Gaussian is used. Where `surroundings` are empty, the object ends with its
/// points.
///
/// # Errors
///
/// [`ShapeError`] for too few points, coordinates that are not finite, and points without a surface (all on a line, or
/// at one position).
pub fn retrieve(
    points: &[Point3<f64>],
    surroundings: &Surroundings,
    mixture: &Mixture,
    sensor_origin: &Point3<f64>,
    settings: &ShapeSettings,
    seed: u64,
) -> Result<Retrieval, ShapeError> {
    let input = RetrievalInput::new(points, mixture, sensor_origin, settings, seed)?;
    if !settings.use_point_distances || surroundings.own.is_empty() {
        let (covariance, ransac) = input.run_both();
        return input.choose(covariance, ransac);
    }
    // A first answer selects its points of the surroundings; the other method waits for them.
    let covariance = input.run_matching();
    let ransac = match covariance {
        Some(_) => None,
        None => input.run_ransac(),
    };
    let first = covariance.as_ref().or(ransac.as_ref());
    let first = first.ok_or_else(|| input.nothing_fits())?;
    let noise_m = settings
        .noise
        .sigma_m((first.centre - sensor_origin).norm());
    let band_m = surface_band_m(&first.size_m, noise_m);
    let more = extend_along_surface(first, points, surroundings, sensor_origin, band_m);
    if more.is_empty() {
        let ransac = ransac.or_else(|| input.run_ransac());
        return input.choose(covariance, ransac);
    }
    let all: Vec<Point3<f64>> = points.iter().chain(&more).copied().collect();
    let extended =
        RetrievalInput::new(&all, mixture, sensor_origin, settings, seed).and_then(|input| {
            let (covariance, ransac) = input.run_both();
            input.choose(covariance, ransac)
        });
    // Else the answer without the surroundings.
    extended.or_else(|_| {
        let ransac = ransac.or_else(|| input.run_ransac());
        input.choose(covariance, ransac)
    })
}

/// Half the width of the band about a surface that holds the points of an object, metres.
fn surface_band_m(size_m: &[f64; 3], noise_m: f64) -> f64 {
    let spread_m = Vector3::from(*size_m).norm() / 4.0;
    3.0 * noise_m.hypot(ROUGHNESS_SHARE * spread_m)
}

/// One object's points, checked and without outliers, and what both methods need besides.
struct RetrievalInput<'a> {
    points: Vec<Point3<f64>>,
    /// Of these points.
    moments: Gaussian,
    noise_m: f64,
    mixture: &'a Mixture,
    sensor: &'a Point3<f64>,
    settings: &'a ShapeSettings,
    seed: u64,
}

impl<'a> RetrievalInput<'a> {
    fn new(
        points: &[Point3<f64>],
        mixture: &'a Mixture,
        sensor: &'a Point3<f64>,
        settings: &'a ShapeSettings,
        seed: u64,
    ) -> Result<Self, ShapeError> {
        checked_moments(points, sensor)?;
        let points = remove_outliers(points);
        let moments = checked_moments(&points, sensor)?;
        let noise_m = settings
            .noise
            .sigma_m((moments.mean - sensor).norm())
            .max(MIN_NOISE_M);
        Ok(Self {
            points,
            moments,
            noise_m,
            mixture,
            sensor,
            settings,
            seed,
        })
    }

    /// Method B's answer; `None` also where it was not chosen.
    fn run_matching(&self) -> Option<Shape> {
        if self.settings.choice == MethodChoice::Ransac {
            return None;
        }
        let use_mixture = self.settings.use_mixture_moments;
        let total = use_mixture.then(|| total_moments(self.mixture)).flatten();
        let moments = total.unwrap_or(self.moments);
        let (points, sensor) = (&self.points, self.sensor);
        let found = match_classes(points, &moments, sensor, self.noise_m, self.settings)?;
        Some(matched_shape(
            points,
            sensor,
            found,
            self.noise_m,
            self.settings,
        ))
    }

    /// Method A's answer; `None` also where it was not chosen.
    fn run_ransac(&self) -> Option<Shape> {
        if self.settings.choice == MethodChoice::Covariance {
            return None;
        }
        ransac_shape(
            &self.points,
            self.mixture,
            self.sensor,
            self.noise_m,
            self.settings,
            self.seed,
        )
    }

    fn run_both(&self) -> (Option<Shape>, Option<Shape>) {
        rayon::join(|| self.run_matching(), || self.run_ransac())
    }

    fn nothing_fits(&self) -> ShapeError {
        ShapeError::NothingFits {
            points: self.points.len(),
        }
    }

    /// Method B's answer, or method A's where B has none, and the parts where it does not explain the points.
    fn choose(
        &self,
        covariance: Option<Shape>,
        ransac: Option<Shape>,
    ) -> Result<Retrieval, ShapeError> {
        let chosen = covariance.as_ref().or(ransac.as_ref());
        let best = chosen.cloned().ok_or_else(|| self.nothing_fits())?;
        let spread_m = self.moments.covariance.trace().max(0.0).sqrt();
        let expected_m = self.noise_m.hypot(ROUGHNESS_SHARE * spread_m);
        let parts = if best.residual_m > self.settings.parts_above_ratio * expected_m {
            detect_shapes(&self.points, None, self.sensor, self.settings, self.seed)
        } else {
            Vec::new()
        };
        // A single part explains no more than the shape itself.
        let parts = if parts.len() < 2 { Vec::new() } else { parts };
        Ok(Retrieval {
            best,
            covariance,
            ransac,
            parts,
        })
    }
}

/// Mean and covariance of points that can have a shape.
fn checked_moments(points: &[Point3<f64>], sensor: &Point3<f64>) -> Result<Gaussian, ShapeError> {
    let too_few = ShapeError::TooFewPoints {
        got: points.len(),
        min: MIN_POINTS,
    };
    if points.len() < MIN_POINTS {
        return Err(too_few);
    }
    let finite = |p: &Point3<f64>, input| match p.iter().find(|v| !v.is_finite()) {
        Some(&value) => Err(ShapeError::NotFinite { value, input }),
        None => Ok(()),
    };
    finite(sensor, "the sensor's origin")?;
    points.iter().try_for_each(|p| finite(p, "the points"))?;
    let moments = Gaussian::from_points(points).ok_or(too_few)?;
    let mut variances: [f64; 3] = moments.covariance.symmetric_eigenvalues().into();
    variances.sort_by(f64::total_cmp);
    let second_m = variances[1].max(0.0).sqrt();
    if second_m < MIN_SPREAD_M {
        return Err(ShapeError::NoSurface {
            second_m,
            min_m: MIN_SPREAD_M,
        });
    }
    Ok(moments)
}

/// Mean and covariance of a whole mixture; `None` if it is empty or not finite.
fn total_moments(mixture: &Mixture) -> Option<Gaussian> {
    let pairs = || mixture.weights.iter().zip(&mixture.components);
    let total: f64 = pairs().map(|(w, _)| w).sum();
    let first = mixture.components.first()?.mean;
    let shift = pairs().fold(Vector3::zeros(), |s, (w, g)| s + (g.mean - first) * *w) / total;
    let mean = first + shift;
    let covariance = pairs().fold(Matrix3::zeros(), |s, (w, g)| {
        let d = g.mean - mean;
        s + (g.covariance + d * d.transpose()) * *w
    }) / total;
    let finite = covariance.iter().chain(mean.iter()).all(|v| v.is_finite());
    (finite && total > 0.0).then_some(Gaussian { mean, covariance })
}

/// Method B's answer with lengths from the edges, where the points' distances are used.
fn matched_shape(
    points: &[Point3<f64>],
    sensor: &Point3<f64>,
    (best, mut alternatives): (PrimitiveEstimate, Vec<Alternative>),
    noise_m: f64,
    settings: &ShapeSettings,
) -> Shape {
    let ambiguous = best.probability_among_fitted < settings.ambiguous_below;
    alternatives.retain(|a| a.probability >= MIN_LISTED_PROBABILITY);
    if !ambiguous {
        alternatives.retain(|a| a.class != best.primitive.class());
    }
    let band_m = surface_band_m(&best.primitive.size_m(), noise_m);
    let inliers: Vec<Point3<f64>> = points
        .iter()
        .filter(|p| best.primitive.visible_distance_m(p, sensor).abs() < band_m)
        .copied()
        .collect();
    // An object that is not quite of its class (a person) ends where all its points do.
    let fits_class = inliers.len() as f64 >= MIN_INLIER_SHARE * points.len() as f64;
    let best = if settings.use_point_distances {
        let (surface, density) = surface_model_for(points, sensor, settings);
        measure_lengths(
            best,
            &EdgeObservations {
                fits_class,
                points: if fits_class { &inliers } else { points },
                noise_m,
                independent_share: settings.independent_share,
                sensor,
                surface,
                density: &density,
            },
        )
    } else {
        best
    };
    let distance = |p: &Point3<f64>| best.primitive.visible_distance_m(p, sensor);
    let squares: f64 = points.iter().map(|p| distance(p).powi(2)).sum();
    Shape {
        class: if ambiguous {
            Class::Ambiguous
        } else {
            best.primitive.class()
        },
        method: Method::Covariance,
        probability: best.probability,
        alternatives,
        centre: best.primitive.centre(),
        centre_sd_m: best.centre_sd_m,
        rotation: best.primitive.canonical_rotation(sensor),
        size_m: best.primitive.size_m(),
        size_sd_m: best.size_sd_m,
        exponents: best.primitive.exponents(),
        residual_m: (squares / points.len() as f64).sqrt(),
        inliers: inliers.len(),
    }
}
