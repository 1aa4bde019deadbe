//! Splits a cloud until every part is flat: the components of the engine `standard`. Deterministic.

use super::constants::{
    FLAT_SIGMA_M, FLAT_SIGMAS_OF_NOISE, FLAT_WIDTH_M, FLAT_WIDTH_SPACINGS, REGULARISATION_M2,
    SPLIT_MIN_POINTS,
};
use super::linalg::Eigen;
use super::point_blocks::{check_points, check_weights};
use super::{Gaussian, Mixture, MixtureError};
use nalgebra::{Matrix3, Point3, Vector3};

/// When a part is flat and narrow enough.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SplitSettings {
    /// Standard deviation across a part at most, metres.
    pub flat_sigma_m: f64,
    /// Width of a part at most, metres: the side of the uniform plate of its largest variance.
    pub width_m: f64,
    /// Parts of this many points or fewer are not split further.
    pub min_points: usize,
    /// Added to the diagonal of every covariance, square metres.
    pub regularisation_m2: f64,
}

impl Default for SplitSettings {
    fn default() -> Self {
        Self {
            flat_sigma_m: FLAT_SIGMA_M,
            width_m: FLAT_WIDTH_M,
            min_points: SPLIT_MIN_POINTS,
            regularisation_m2: REGULARISATION_M2,
        }
    }
}

impl SplitSettings {
    /// Coarser where the data demand it: a flat wall with range noise `noise_sigma_m` stays one part, and a part has several
    /// points `spacing_m` apart.
    pub fn for_data(noise_sigma_m: f64, spacing_m: f64) -> Self {
        Self {
            flat_sigma_m: FLAT_SIGMA_M.max(FLAT_SIGMAS_OF_NOISE * noise_sigma_m),
            width_m: FLAT_WIDTH_M.max(FLAT_WIDTH_SPACINGS * spacing_m),
            ..Self::default()
        }
    }
}

/// Halves the points at their mean, across their longest principal axis, until every part is flat and narrow; each part is
/// one component. Meant for voxel-thinned points.
///
/// # Errors
/// No points, coordinates or weights that are not finite, weights without sum.
pub fn split_until_flat(
    points: &[Point3<f64>],
    weights: Option<&[f64]>,
    settings: &SplitSettings,
) -> Result<Mixture, MixtureError> {
    check_points(points)?;
    let first = points.first().ok_or(MixtureError::NoPoints)?;
    if let Some(weights) = weights {
        check_weights(points, weights)?;
    }
    let weight = |i: usize| weights.map_or(1.0, |w| w[i]);
    let mut weighted: Vec<(Vector3<f64>, f64)> = points
        .iter()
        .enumerate()
        .map(|(i, p)| (p - first, weight(i)))
        .filter(|(_, w)| *w > 0.0)
        .collect();
    let (mut masses, mut components) = (Vec::new(), Vec::new());
    let mut open = vec![(0, weighted.len())];
    while let Some((from, to)) = open.pop() {
        let part = &mut weighted[from..to];
        let (mass, mean, covariance) = moments(part);
        let second_half = halve(part, mean, &covariance, settings);
        if let Some(middle) = second_half {
            open.push((from + middle, to));
            open.push((from, from + middle));
            continue;
        }
        masses.push(mass);
        components.push(Gaussian {
            mean: first + mean,
            covariance: covariance + Matrix3::from_diagonal_element(settings.regularisation_m2),
        });
    }
    Mixture::from_masses(masses, components)
}

fn moments(part: &[(Vector3<f64>, f64)]) -> (f64, Vector3<f64>, Matrix3<f64>) {
    let (mut mass, mut sum) = (0.0, Vector3::zeros());
    for (p, w) in part {
        mass += w;
        sum += p * *w;
    }
    let mean = sum / mass;
    let mut s = [0.0; 6];
    for (p, w) in part {
        let d = p - mean;
        let wd = d * *w;
        s[0] += wd.x * d.x;
        s[1] += wd.x * d.y;
        s[2] += wd.x * d.z;
        s[3] += wd.y * d.y;
        s[4] += wd.y * d.z;
        s[5] += wd.z * d.z;
    }
    let [xx, xy, xz, yy, yz, zz] = s;
    (
        mass,
        mean,
        Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) / mass,
    )
}

/// Partitions the part into two halves; returns the index of the second, `None` if the part stays whole.
fn halve(
    part: &mut [(Vector3<f64>, f64)],
    mean: Vector3<f64>,
    covariance: &Matrix3<f64>,
    settings: &SplitSettings,
) -> Option<usize> {
    if part.len() <= settings.min_points.max(1) {
        return None;
    }
    let eigen = Eigen::new(covariance);
    let sigma = |i: usize| eigen.values[i].max(0.0).sqrt();
    // A uniform plate of side a has variance a^2 / 12.
    let width = 12f64.sqrt() * sigma(2);
    if sigma(0) <= settings.flat_sigma_m && width <= settings.width_m {
        return None;
    }
    let axis: Vector3<f64> = eigen.vectors.column(2).into();
    let mut middle = 0;
    for i in 0..part.len() {
        if axis.dot(&(part[i].0 - mean)) < 0.0 {
            part.swap(i, middle);
            middle += 1;
        }
    }
    (middle > 0 && middle < part.len()).then_some(middle)
}

#[cfg(test)]
mod tests {
    use super::{SplitSettings, split_until_flat};
    use crate::mixture::linalg::Eigen;
    use nalgebra::{Point3, Vector3};

    /// Floor and two walls of a room, points 6 cm apart.
    fn corner() -> Vec<Point3<f64>> {
        let mut points = Vec::new();
        for i in 0..70 {
            for j in 0..50 {
                let (a, b) = (f64::from(i) * 0.06, f64::from(j) * 0.06);
                points.extend([
                    Point3::new(a, b, 0.0),
                    Point3::new(a, 0.0, b),
                    Point3::new(0.0, a, b),
                ]);
            }
        }
        points
    }

    #[test]
    fn every_part_is_flat_and_narrow() {
        let settings = SplitSettings::default();
        let mixture = split_until_flat(&corner(), None, &settings).expect("splits");
        assert!((20..400).contains(&mixture.len()), "{}", mixture.len());
        for g in &mixture.components {
            let values = Eigen::new(&g.covariance).values;
            assert!(values[0].sqrt() <= settings.flat_sigma_m + 1e-3);
            assert!((12.0 * values[2]).sqrt() <= settings.width_m + 1e-2);
        }
    }

    #[test]
    fn mass_and_moments_are_kept_far_from_the_origin() {
        let far: Vec<_> = corner()
            .iter()
            .map(|p| p + Vector3::new(1e6, -1e6, 0.0))
            .collect();
        let settings = SplitSettings {
            regularisation_m2: 0.0,
            ..SplitSettings::default()
        };
        let weights: Vec<f64> = (0..far.len()).map(|i| (i % 4) as f64).collect();
        let mixture = split_until_flat(&far, Some(&weights), &settings).expect("splits");
        let pairs = far.iter().zip(weights.iter().copied());
        let (whole, _) = crate::mixture::Gaussian::from_weighted_points(pairs).expect("mass");
        let total = mixture.total_moments().expect("mass");
        assert!((total.mean - whole.mean).norm() < 1e-8);
        assert!((total.covariance - whole.covariance).amax() < 1e-7);
        assert_eq!(
            split_until_flat(&far, Some(&weights), &settings).expect("again"),
            mixture
        );
    }

    #[test]
    fn repeated_and_single_points_are_one_component() {
        let p = Point3::new(3.0, 2.0, 1.0);
        for points in [vec![p], vec![p; 100]] {
            let mixture = split_until_flat(&points, None, &SplitSettings::default()).expect("one");
            assert_eq!((mixture.len(), mixture.components[0].mean), (1, p));
        }
        assert!(split_until_flat(&[], None, &SplitSettings::default()).is_err());
    }
}
