//! The front door: settings, and all primitives of a cloud one after the other.

use super::cloud::Cloud;
use super::constants::{
    CELL_EPSILONS, CELL_SPACINGS, CONNECTED_M, CONSENSUS_ANGLE_RAD, GIVEN_NORMALS_ANGLE_RAD,
    LARGEST_DIAGONALS, LEAST_PART_SHARE, PROBABILITY,
};
use super::extent::covered;
use super::normals::spacing_m;
use super::score::Tolerance;
use super::search::Search;
use crate::mixture::Instructions;
use crate::shape::constants::LEAST_POINTS;
use crate::shape::primitive::Primitive;
use nalgebra::{Point3, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// What makes a primitive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RansacSettings {
    /// Greatest distance of an inlier from the surface, metres.
    pub epsilon_m: f64,
    /// Greatest angle between an inlier's normal and the surface's, radians; `None` takes what suits
    /// estimated normals, or given ones where [`with_given_normals`](Self::with_given_normals) says so.
    pub normal_angle_rad: Option<f64>,
    /// Least number of inliers.
    pub min_points: usize,
    /// Search until a better primitive was missed with at most the rest of this probability.
    pub probability: f64,
    /// Stop after this many primitives.
    pub most: usize,
    /// Side of the cells through which inliers must hang together, metres; `None` takes twice the
    /// distance to the sixth neighbour.
    pub cell_m: Option<f64>,
}

impl RansacSettings {
    /// What suits one novelty of `points` points: parts of a twelfth of them at least, found with
    /// 99 % probability, at most `most` of them.
    pub fn derived(points: usize, epsilon_m: f64, most: usize) -> Self {
        let share = (points as f64 * LEAST_PART_SHARE).ceil() as usize;
        Self {
            epsilon_m,
            normal_angle_rad: None,
            min_points: share.max(LEAST_POINTS),
            probability: PROBABILITY,
            most,
            cell_m: Some(CONNECTED_M),
        }
    }

    /// The same for points that came with normals of their own, which are better than estimates. An
    /// angle that was asked for stays.
    pub fn with_given_normals(self) -> Self {
        Self {
            normal_angle_rad: self.normal_angle_rad.or(Some(GIVEN_NORMALS_ANGLE_RAD)),
            ..self
        }
    }

    /// The same where `points` lie farther apart than the cells: then cells grow with them, so that
    /// a thin cloud of something large hangs together too.
    pub fn with_cells_for(self, points: &[Point3<f64>]) -> Self {
        let spaced_m = CELL_SPACINGS * spacing_m(points);
        Self {
            cell_m: self.cell_m.map(|cell_m| cell_m.max(spaced_m)),
            ..self
        }
    }
}

/// A primitive and the points that lie on it.
#[derive(Debug, Clone, PartialEq)]
pub struct Detected {
    /// The refitted primitive with the extent of its inliers.
    pub primitive: Primitive,
    /// Indices of its points, rising.
    pub inliers: Vec<usize>,
}

/// Primitives with disjoint inliers, in the order found (mostly the largest first); the points of
/// none of them are the [`remainder`]. `normals[i]` is the unit normal of `points[i]`, of either
/// sign; points without one, or with coordinates that are not finite, take no part.
///
/// After Schnabel, Wahl and Klein (2007). Coordinates are worked on in f32 about the cloud's
/// middle: `epsilon_m` shall be above a millionth of its width.
pub fn detect(
    points: &[Point3<f64>],
    normals: &[Vector3<f64>],
    settings: &RansacSettings,
    seed: u64,
) -> Vec<Detected> {
    let mut cloud = Cloud::of(points, normals);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let search = searched(points, &cloud, settings);
    let mut found = Vec::new();
    while found.len() < settings.most && cloud.len() >= search.min_points {
        let Some((surface, places)) = search.next(&cloud, &mut rng) else {
            break;
        };
        found.push(Detected {
            primitive: covered(&surface, &cloud, &places),
            inliers: places.iter().map(|&k| k as usize).collect(),
        });
        cloud.remove(&places);
    }
    found
}

/// The search that `settings` mean on `cloud`, which is of `points`.
pub(super) fn searched(points: &[Point3<f64>], cloud: &Cloud, settings: &RansacSettings) -> Search {
    let cell_m = settings
        .cell_m
        .unwrap_or_else(|| CELL_SPACINGS * spacing_m(points));
    Search {
        tolerance: Tolerance {
            epsilon_m: settings.epsilon_m,
            cos_angle: settings
                .normal_angle_rad
                .unwrap_or(CONSENSUS_ANGLE_RAD)
                .cos(),
        },
        min_points: settings.min_points.max(3),
        probability: settings.probability,
        cell_m: cell_m.max(CELL_EPSILONS * settings.epsilon_m),
        largest_m: LARGEST_DIAGONALS * cloud.diagonal_m(),
        instructions: Instructions::best(),
    }
}

/// Indices below `points` of those on none of the primitives found, rising.
pub fn remainder(points: usize, found: &[Detected]) -> Vec<usize> {
    let mut left = vec![true; points];
    for &i in found.iter().flat_map(|d| &d.inliers) {
        if let Some(left) = left.get_mut(i) {
            *left = false;
        }
    }
    (0..points).filter(|&i| left[i]).collect()
}

#[cfg(test)]
mod tests {
    use super::{RansacSettings, detect};
    use nalgebra::{Point3, Vector3};

    #[test]
    fn an_angle_that_was_asked_for_is_kept_whoever_made_the_normals() {
        // A plate whose normals all lean by 0.55 rad: beyond what given normals are allowed.
        let points: Vec<_> = (0..400)
            .map(|i| Point3::new(f64::from(i % 20) * 0.05, f64::from(i / 20) * 0.05, 1.0))
            .collect();
        let leaning = Vector3::new(0.55f64.sin(), 0.0, 0.55f64.cos());
        let normals = vec![leaning; points.len()];
        let derived = RansacSettings::derived(points.len(), 0.01, 1);
        let asked = |angle_rad| RansacSettings {
            normal_angle_rad: angle_rad,
            ..derived
        };
        for (angle_rad, found) in [(None, 0), (Some(0.6), 1), (Some(0.5), 0)] {
            let settings = asked(angle_rad).with_given_normals();
            let got = detect(&points, &normals, &settings, 1).len();
            assert_eq!(got, found, "{angle_rad:?}");
        }
        // Estimated normals are allowed more.
        assert_eq!(detect(&points, &normals, &derived, 1).len(), 1);
    }
}
