//! All primitives of a cloud, one after the other.

use super::cloud::Cloud;
use super::constants::{
    CONNECTIVITY_CELL_M, CONNECTIVITY_SPACINGS, CONSENSUS_ANGLE_RAD, DETECTION_PROBABILITY,
    GIVEN_NORMALS_ANGLE_RAD, MAX_RADIUS_DIAGONALS, MIN_CONNECTIVITY_EPSILONS, MIN_PART_SHARE,
};
use super::extent::bounded_primitive;
use super::normals::spacing_m;
use super::score::Tolerance;
use super::search::SurfaceSearch;
use crate::mixture::InstructionSet;
use crate::shape::constants::MIN_POINTS;
use crate::shape::primitive::Primitive;
use nalgebra::{Point3, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Settings of [`detect`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RansacSettings {
    /// Greatest distance of an inlier from the surface, metres.
    pub epsilon_m: f64,
    /// Greatest angle between an inlier's normal and the surface's, radians; `None` takes what suits estimated or given
    /// normals.
    pub normal_angle_rad: Option<f64>,
    /// Least number of inliers.
    pub min_points: usize,
    /// Search until no better primitive was missed with this probability.
    pub probability: f64,
    /// Stop after this many primitives.
    pub max_primitives: usize,
    /// Side of the cells through which inliers must be connected, metres; `None` takes twice the distance to the sixth
    /// neighbour.
    pub cell_m: Option<f64>,
}

impl RansacSettings {
    /// Settings for one novelty of `points` points: at most `max_primitives` primitives of at least a twelfth of the points,
    /// found with 99 % probability.
    pub fn with_defaults(points: usize, epsilon_m: f64, max_primitives: usize) -> Self {
        let share = (points as f64 * MIN_PART_SHARE).ceil() as usize;
        Self {
            epsilon_m,
            normal_angle_rad: None,
            min_points: share.max(MIN_POINTS),
            probability: DETECTION_PROBABILITY,
            max_primitives,
            cell_m: Some(CONNECTIVITY_CELL_M),
        }
    }

    /// For points with measured normals, which are better than estimates. An angle that is set stays.
    pub(in crate::shape) fn with_given_normals(self) -> Self {
        Self {
            normal_angle_rad: self.normal_angle_rad.or(Some(GIVEN_NORMALS_ANGLE_RAD)),
            ..self
        }
    }

    /// With cells large enough to connect `points`, so that a sparse cloud of a large object is connected too.
    pub(in crate::shape) fn with_cells_for(self, points: &[Point3<f64>]) -> Self {
        let spacing_cell_m = CONNECTIVITY_SPACINGS * spacing_m(points);
        Self {
            cell_m: self.cell_m.map(|cell_m| cell_m.max(spacing_cell_m)),
            ..self
        }
    }
}

/// A primitive and its points.
#[derive(Debug, Clone, PartialEq)]
pub struct Detected {
    /// The refitted primitive with the extent of its inliers.
    pub primitive: Primitive,
    /// Indices of the points, rising.
    pub inliers: Vec<usize>,
}

/// Primitives with disjoint inliers, in the order found (mostly the largest first), after Schnabel, Wahl and Klein (2007).
/// `normals[i]` is the unit normal of `points[i]`, of either sign; points without one, or with coordinates that are not
/// finite, take no part. Coordinates are processed in f32 relative to a point of the cloud, so `epsilon_m` must be above a
/// millionth of its width.
pub fn detect(
    points: &[Point3<f64>],
    normals: &[Vector3<f64>],
    settings: &RansacSettings,
    seed: u64,
) -> Vec<Detected> {
    let mut cloud = Cloud::new(points, normals);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let search = build_search(points, &cloud, settings);
    let mut found = Vec::new();
    while found.len() < settings.max_primitives && cloud.len() >= search.min_points {
        let Some((surface, indices)) = search.next(&cloud, &mut rng) else {
            break;
        };
        found.push(Detected {
            primitive: bounded_primitive(&surface, &cloud, &indices),
            inliers: indices.iter().map(|&k| k as usize).collect(),
        });
        cloud.remove(&indices);
    }
    found
}

/// The search for these settings; `cloud` is of `points`.
pub(super) fn build_search(
    points: &[Point3<f64>],
    cloud: &Cloud,
    settings: &RansacSettings,
) -> SurfaceSearch {
    let cell_m = settings
        .cell_m
        .unwrap_or_else(|| CONNECTIVITY_SPACINGS * spacing_m(points));
    SurfaceSearch {
        tolerance: Tolerance {
            epsilon_m: settings.epsilon_m,
            cos_angle: settings
                .normal_angle_rad
                .unwrap_or(CONSENSUS_ANGLE_RAD)
                .cos(),
        },
        min_points: settings.min_points.max(3),
        probability: settings.probability,
        cell_m: cell_m.max(MIN_CONNECTIVITY_EPSILONS * settings.epsilon_m),
        max_radius_m: MAX_RADIUS_DIAGONALS * cloud.diagonal_m(),
        instructions: InstructionSet::best(),
    }
}

#[cfg(test)]
mod tests {
    use super::{RansacSettings, detect};
    use nalgebra::{Point3, Vector3};

    #[test]
    fn an_angle_that_is_set_is_kept_also_for_given_normals() {
        // A plate whose normals all lean by 0.55 rad, more than given normals are allowed.
        let points: Vec<_> = (0..400)
            .map(|i| Point3::new(f64::from(i % 20) * 0.05, f64::from(i / 20) * 0.05, 1.0))
            .collect();
        let leaning = Vector3::new(0.55f64.sin(), 0.0, 0.55f64.cos());
        let normals = vec![leaning; points.len()];
        let defaults = RansacSettings::with_defaults(points.len(), 0.01, 1);
        let with_angle = |angle_rad| RansacSettings {
            normal_angle_rad: angle_rad,
            ..defaults
        };
        for (angle_rad, found) in [(None, 0), (Some(0.6), 1), (Some(0.5), 0)] {
            let settings = with_angle(angle_rad).with_given_normals();
            let got = detect(&points, &normals, &settings, 1).len();
            assert_eq!(got, found, "{angle_rad:?}");
        }
        // Estimated normals are allowed more.
        assert_eq!(detect(&points, &normals, &defaults, 1).len(), 1);
    }
}
