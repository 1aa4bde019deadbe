//! Fits of the moments refined with the points, and the further classes (box, cone, superquadric) that are tried where
//! sphere, cylinder and plane leave points unexplained.

use super::evidence::residuals::{
    exceeds_outlier_count, local_noise_m, within_noise, without_pattern,
};
use super::fit::{MatchedPrimitive, Observation, PointLikelihood, match_primitive};
use super::score::{expected_sd_m, form_penalty, is_plate, score, typical_distance_m};
use super::starts::{box_and_cone_starts, equivalents, superquadric_starts};
use crate::shape::constants::{
    BIASED_NOISE_RATIO, EQUIVALENT_ROUNDS, MAX_EFFECTIVE_POINTS, MAX_REFINED, MAX_RESIDUAL_RATIO,
    MEDIAN_RELATIVE_SD, MIN_NOISE_RATIO, MIN_POINTS_BOX_CONE, MIN_POINTS_NOISE,
    MIN_POINTS_SUPERQUADRIC, RULED_OUT_COST, UNEXPLAINED_SIGMAS,
};
use crate::shape::model::Class;
use crate::shape::primitive::Primitive;
use nalgebra::{Unit, Vector3};

/// `fits`, one list per class, refined with the distances of the points. `view` points from the sensor to the object,
/// `axes` are the moments' eigenvectors by falling eigenvalue.
pub(super) fn refine(
    observed: &Observation,
    fits: Vec<Vec<MatchedPrimitive>>,
    view: &Unit<Vector3<f64>>,
    axes: &[Unit<Vector3<f64>>],
) -> Vec<Vec<MatchedPrimitive>> {
    let expected_m = expected_sd_m(observed);
    let refinement = Refinement {
        observed,
        view,
        axes,
        expected_m,
        likelihood: point_likelihood(observed, expected_m),
    };
    let fits = refit_all(observed, refinement.likelihood, without_ruled_out(fits));
    let mut fits: Vec<Vec<MatchedPrimitive>> = fits
        .into_iter()
        .map(|class| refinement.best_of(class))
        .collect();
    if refinement.needs_boxes_and_cones(&fits) {
        fits.extend(refinement.boxes_and_cones());
        if refinement.needs_superquadrics(&fits) {
            let superquadrics = refinement.superquadrics(&fits);
            fits.push(superquadrics);
        }
    }
    // What no class explains (a person) is no box only because that came closest.
    let simple = [Class::Sphere, Class::Cylinder, Class::Plane];
    for class in &mut fits {
        class.retain(|fit| {
            simple.contains(&fit.primitive.class()) || refinement.fits_within(&fit.primitive, 1.0)
        });
    }
    refinement.refit_with_observed_noise(fits)
}

/// What the fits are compared with.
struct Refinement<'a> {
    observed: &'a Observation,
    view: &'a Unit<Vector3<f64>>,
    axes: &'a [Unit<Vector3<f64>>],
    /// Standard deviation of a point about a surface of its class, metres.
    expected_m: f64,
    likelihood: PointLikelihood,
}

impl Refinement<'_> {
    /// The fits of one class with the best scores.
    fn best_of(&self, mut class: Vec<MatchedPrimitive>) -> Vec<MatchedPrimitive> {
        let score = |fit: &MatchedPrimitive| score(self.observed, fit, self.view);
        class.retain(|fit| !is_plate(&fit.primitive));
        class.sort_by(|a, b| score(a).total_cmp(&score(b)));
        class.truncate(MAX_REFINED);
        class
    }

    /// The primitive with the best score of all classes.
    fn most_likely<'f>(&self, fits: &'f [Vec<MatchedPrimitive>]) -> Option<&'f Primitive> {
        let scored = fits
            .iter()
            .flatten()
            .map(|fit| (score(self.observed, fit, self.view), fit));
        let best = scored.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(&best.1.primitive)
    }

    /// Whether most points are within `ratio` times the largest residual that a class may leave.
    fn fits_within(&self, primitive: &Primitive, ratio: f64) -> bool {
        typical_distance_m(self.observed, primitive) <= ratio * BIASED_NOISE_RATIO * self.expected_m
    }

    /// Relative standard deviation of a typical distance.
    fn distance_scatter(&self) -> f64 {
        MEDIAN_RELATIVE_SD / (self.observed.points.len() as f64).sqrt()
    }

    fn needs_boxes_and_cones(&self, fits: &[Vec<MatchedPrimitive>]) -> bool {
        let observed = self.observed;
        let explains = |primitive: &Primitive| {
            within_noise(observed, primitive, observed.noise_m)
                && !exceeds_outlier_count(observed, primitive, observed.noise_m)
                && without_pattern(observed, primitive, self.axes)
                && form_penalty(observed, primitive, self.view) == 0.0
        };
        observed.points.len() >= MIN_POINTS_BOX_CONE
            && !self.most_likely(fits).is_some_and(explains)
    }

    fn boxes_and_cones(&self) -> [Vec<MatchedPrimitive>; 2] {
        let starts = box_and_cone_starts(self.observed, self.axes, self.expected_m);
        starts.map(|class| self.best_of(self.fit_rough_starts(class)))
    }

    /// A superquadric follows any pattern, a laser's bias included: it is tried where most points are farther off than
    /// their neighbours' noise, or than noise and a bias of its size.
    fn needs_superquadrics(&self, fits: &[Vec<MatchedPrimitive>]) -> bool {
        let scatter = self.distance_scatter();
        let explains = |primitive: &Primitive| {
            let local_m = local_noise_m(&self.observed.points);
            let limit_m = (local_m.max(self.expected_m) * (1.0 + scatter))
                .min(BIASED_NOISE_RATIO * self.expected_m);
            typical_distance_m(self.observed, primitive) <= limit_m
        };
        self.observed.points.len() >= MIN_POINTS_SUPERQUADRIC
            && !self.most_likely(fits).is_some_and(explains)
    }

    fn superquadrics(&self, fits: &[Vec<MatchedPrimitive>]) -> Vec<MatchedPrimitive> {
        let fitted: Vec<Primitive> = fits.iter().flatten().map(|fit| fit.primitive).collect();
        let starts = superquadric_starts(self.observed, self.axes, &fitted, self.expected_m);
        let mut found = self.best_of(self.fit_rough_starts(starts));
        for _ in 0..EQUIVALENT_ROUNDS {
            let others = found.iter().filter_map(|fit| match fit.primitive {
                Primitive::Superquadric(s)
                    if self.fits_within(&fit.primitive, MAX_RESIDUAL_RATIO) =>
                {
                    Some(equivalents(&s))
                }
                _ => None,
            });
            let others = self.fit_rough_starts(others.flatten().collect());
            found = self.best_of(found.into_iter().chain(others).collect());
        }
        let max_ratio =
            (1.0 + UNEXPLAINED_SIGMAS * self.distance_scatter()).min(BIASED_NOISE_RATIO);
        found.retain(|fit| self.fits_within(&fit.primitive, max_ratio / BIASED_NOISE_RATIO));
        found
    }

    /// Fits from rough starts: first with a standard deviation as large as the start's residual, then with the true one.
    fn fit_rough_starts(&self, starts: Vec<Primitive>) -> Vec<MatchedPrimitive> {
        let (observed, likelihood) = (self.observed, self.likelihood);
        let rough = |start: &Primitive| PointLikelihood {
            sd_m: typical_distance_m(observed, start).max(likelihood.sd_m),
            ..likelihood
        };
        let fits = starts.into_iter().filter_map(|start| {
            let near = match_primitive(observed, start, Some(rough(&start)))?;
            match_primitive(observed, near.primitive, Some(likelihood))
        });
        fits.collect()
    }

    /// All fits again, with the standard deviation that the best surface leaves: more than expected keeps a rough object
    /// uncertain; less counts only if there are enough points to know it.
    fn refit_with_observed_noise(
        &self,
        fits: Vec<Vec<MatchedPrimitive>>,
    ) -> Vec<Vec<MatchedPrimitive>> {
        let observed = self.observed;
        let least_m = fits
            .iter()
            .flatten()
            .map(|fit| typical_distance_m(observed, &fit.primitive))
            .fold(f64::INFINITY, f64::min);
        let is_known = observed.points.len() >= MIN_POINTS_NOISE || least_m > self.expected_m;
        let least_m = least_m.max(self.expected_m * MIN_NOISE_RATIO);
        if least_m.is_finite() && is_known {
            refit_all(observed, point_likelihood(observed, least_m), fits)
        } else {
            fits
        }
    }
}

/// Without the classes that the moments alone rule out.
fn without_ruled_out(fits: Vec<Vec<MatchedPrimitive>>) -> Vec<Vec<MatchedPrimitive>> {
    let cheapest = |class: &[MatchedPrimitive]| {
        let costs = class.iter().map(|fit| fit.cost);
        costs.fold(f64::INFINITY, f64::min)
    };
    let least = fits
        .iter()
        .map(|class| cheapest(class))
        .fold(f64::INFINITY, f64::min);
    let ruled_out = |class: &[MatchedPrimitive]| cheapest(class) > least + RULED_OUT_COST;
    fits.into_iter().filter(|class| !ruled_out(class)).collect()
}

/// Every fit matched again with this likelihood.
fn refit_all(
    observed: &Observation,
    likelihood: PointLikelihood,
    fits: Vec<Vec<MatchedPrimitive>>,
) -> Vec<Vec<MatchedPrimitive>> {
    let class = |class: Vec<MatchedPrimitive>| {
        let fits = class.into_iter();
        fits.filter_map(|fit| match_primitive(observed, fit.primitive, Some(likelihood)))
            .collect()
    };
    fits.into_iter().map(class).collect()
}

fn point_likelihood(observed: &Observation, sd_m: f64) -> PointLikelihood {
    PointLikelihood {
        sd_m,
        effective_points: observed.effective_points.min(MAX_EFFECTIVE_POINTS),
    }
}
