//! The front door: both methods on one novelty, and the choice between them.

use super::constants::{
    LEAST_LISTED_PROBABILITY, LEAST_NEAR_SHARE, LEAST_NOISE_M, LEAST_POINTS, LEAST_SPREAD_M,
    ROUGHNESS_SHARE,
};
use super::continued::continued;
use super::covariance::{Candidate, candidates, shown};
use super::euclidean::{by_consensus, primitives};
use super::lengths::{Look, measured};
use super::lonely::in_company;
use super::model::{Alternative, Class, Method, Retrieval, Shape};
use super::settings::{Choice, ShapeSettings};
use crate::mixture::{Gaussian, Mixture};
use crate::novelty::Rim;
use nalgebra::{Matrix3, Point3, Vector3};

/// Why no shape can be told.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ShapeError {
    /// Fewer points than carry a shape.
    #[error("a shape needs at least {least} points, got {got}")]
    TooFewPoints {
        /// Points given.
        got: usize,
        /// Least number.
        least: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("coordinates must be finite, got {value} in {place}")]
    NotFinite {
        /// The offender.
        value: f64,
        /// Where it stands.
        place: &'static str,
    },
    /// The points lie on one line, or all in one place.
    #[error(
        "a shape needs points spread over a surface, got a width of {second_m} m (at least {least_m} m)"
    )]
    NoSurface {
        /// Standard deviation along the second principal axis, metres.
        second_m: f64,
        /// Least, metres.
        least_m: f64,
    },
    /// No primitive could be fitted.
    #[error("no primitive fits the {points} points")]
    NothingFits {
        /// Points given.
        points: usize,
    },
}

/// The shape of one novelty from its points (metres), what lies about it, its Gaussians, and where
/// the sensor stood. `mixture` may be empty; then the points' own Gaussian stands for it. So may
/// `rim`; then a thing ends where its points do.
///
/// # Errors
///
/// [`ShapeError`] for too few points, coordinates that are not finite, and points without a
/// surface (all on a line, or in one place).
pub fn retrieve(
    points: &[Point3<f64>],
    rim: &Rim,
    mixture: &Mixture,
    sensor_origin: &Point3<f64>,
    settings: &ShapeSettings,
    seed: u64,
) -> Result<Retrieval, ShapeError> {
    let thing = Thing::of(points, mixture, sensor_origin, settings, seed)?;
    if !settings.points_judge || rim.beside.is_empty() {
        let (covariance, ransac) = thing.by_both();
        return thing.told(covariance, ransac);
    }
    // One answer tells which points of the rim are its own; the other method waits for these.
    let covariance = thing.by_matching();
    let ransac = match covariance {
        Some(_) => None,
        None => thing.by_consensus(),
    };
    let first = covariance.as_ref().or(ransac.as_ref());
    let first = first.ok_or_else(|| thing.nothing_fits())?;
    let noise_m = settings
        .noise
        .sigma_m((first.centre - sensor_origin).norm());
    let near_m = near_m(&first.size_m, noise_m);
    let more = continued(first, points, rim, sensor_origin, near_m);
    if more.is_empty() {
        let ransac = ransac.or_else(|| thing.by_consensus());
        return thing.told(covariance, ransac);
    }
    let all: Vec<Point3<f64>> = points.iter().chain(&more).copied().collect();
    let grown = Thing::of(&all, mixture, sensor_origin, settings, seed).and_then(|thing| {
        let (covariance, ransac) = thing.by_both();
        thing.told(covariance, ransac)
    });
    // What was told without them stands.
    grown.or_else(|_| {
        let ransac = ransac.or_else(|| thing.by_consensus());
        thing.told(covariance, ransac)
    })
}

/// Half the width of the band about a surface in which the points of a thing lie, metres.
fn near_m(size_m: &[f64; 3], noise_m: f64) -> f64 {
    let spread_m = Vector3::from(*size_m).norm() / 4.0;
    3.0 * noise_m.hypot(ROUGHNESS_SHARE * spread_m)
}

/// A thing that ends where its points do.
struct Thing<'a> {
    /// Without strays.
    points: Vec<Point3<f64>>,
    own: Gaussian,
    noise_m: f64,
    mixture: &'a Mixture,
    sensor: &'a Point3<f64>,
    settings: &'a ShapeSettings,
    seed: u64,
}

impl<'a> Thing<'a> {
    fn of(
        points: &[Point3<f64>],
        mixture: &'a Mixture,
        sensor: &'a Point3<f64>,
        settings: &'a ShapeSettings,
        seed: u64,
    ) -> Result<Self, ShapeError> {
        checked(points, sensor)?;
        let points = in_company(points);
        let own = checked(&points, sensor)?;
        let noise_m = settings
            .noise
            .sigma_m((own.mean - sensor).norm())
            .max(LEAST_NOISE_M);
        Ok(Self {
            points,
            own,
            noise_m,
            mixture,
            sensor,
            settings,
            seed,
        })
    }

    /// Method B's answer; `None` where it is not asked, too.
    fn by_matching(&self) -> Option<Shape> {
        if self.settings.choice == Choice::Ransac {
            return None;
        }
        let of_mixture = self.settings.moments_of_mixture;
        let total = of_mixture.then(|| total_moments(self.mixture)).flatten();
        let moments = total.unwrap_or(self.own);
        let (points, sensor) = (&self.points, self.sensor);
        let found = candidates(points, &moments, sensor, self.noise_m, self.settings)?;
        Some(told(points, sensor, found, self.noise_m, self.settings))
    }

    /// Method A's answer; `None` where it is not asked, too.
    fn by_consensus(&self) -> Option<Shape> {
        if self.settings.choice == Choice::Covariance {
            return None;
        }
        by_consensus(
            &self.points,
            self.mixture,
            self.sensor,
            self.noise_m,
            self.settings,
            self.seed,
        )
    }

    fn by_both(&self) -> (Option<Shape>, Option<Shape>) {
        rayon::join(|| self.by_matching(), || self.by_consensus())
    }

    fn nothing_fits(&self) -> ShapeError {
        ShapeError::NothingFits {
            points: self.points.len(),
        }
    }

    /// The choice between both answers, and the parts where it does not explain the thing.
    fn told(
        &self,
        covariance: Option<Shape>,
        ransac: Option<Shape>,
    ) -> Result<Retrieval, ShapeError> {
        let chosen = covariance.as_ref().or(ransac.as_ref());
        let best = chosen.cloned().ok_or_else(|| self.nothing_fits())?;
        let spread_m = self.own.covariance.trace().max(0.0).sqrt();
        let expected = self.noise_m.hypot(ROUGHNESS_SHARE * spread_m);
        let parts = if best.residual_m > self.settings.parts_above * expected {
            primitives(&self.points, None, self.sensor, self.settings, self.seed)
        } else {
            Vec::new()
        };
        // One part is no explanation by parts.
        let parts = if parts.len() < 2 { Vec::new() } else { parts };
        Ok(Retrieval {
            best,
            covariance,
            ransac,
            parts,
        })
    }
}

fn checked(points: &[Point3<f64>], sensor: &Point3<f64>) -> Result<Gaussian, ShapeError> {
    let too_few = ShapeError::TooFewPoints {
        got: points.len(),
        least: LEAST_POINTS,
    };
    if points.len() < LEAST_POINTS {
        return Err(too_few);
    }
    let of = |p: &Point3<f64>, place| match p.iter().find(|v| !v.is_finite()) {
        Some(&value) => Err(ShapeError::NotFinite { value, place }),
        None => Ok(()),
    };
    of(sensor, "the sensor's origin")?;
    points.iter().try_for_each(|p| of(p, "the points"))?;
    let moments = Gaussian::of_points(points).ok_or(too_few)?;
    let mut variances: [f64; 3] = moments.covariance.symmetric_eigenvalues().into();
    variances.sort_by(f64::total_cmp);
    let second_m = variances[1].max(0.0).sqrt();
    if second_m < LEAST_SPREAD_M {
        return Err(ShapeError::NoSurface {
            second_m,
            least_m: LEAST_SPREAD_M,
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

/// The most probable candidate in the room's words.
fn told(
    points: &[Point3<f64>],
    sensor: &Point3<f64>,
    (best, mut alternatives): (Candidate, Vec<Alternative>),
    noise_m: f64,
    settings: &ShapeSettings,
) -> Shape {
    let ambiguous = best.among_fitted < settings.ambiguous_below;
    alternatives.retain(|a| a.probability >= LEAST_LISTED_PROBABILITY);
    if !ambiguous {
        alternatives.retain(|a| a.class != best.primitive.class());
    }
    let near_m = near_m(&best.primitive.size_m(), noise_m);
    let near: Vec<Point3<f64>> = points
        .iter()
        .filter(|p| best.primitive.visible_distance_m(p, sensor).abs() < near_m)
        .copied()
        .collect();
    // A thing that is not quite of its class (a person) ends where all its points do.
    let own = near.len() as f64 >= LEAST_NEAR_SHARE * points.len() as f64;
    let best = if settings.points_judge {
        let (surface, density) = shown(points, sensor, settings);
        measured(
            best,
            &Look {
                of_class: own,
                near: if own { &near } else { points },
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
        rotation: best.primitive.rotation(sensor),
        size_m: best.primitive.size_m(),
        size_sd_m: best.size_sd_m,
        exponents: best.primitive.exponents(),
        residual_m: (squares / points.len() as f64).sqrt(),
        inliers: near.len(),
    }
}
