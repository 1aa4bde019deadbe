//! Starts of EM by k-means++ (Arthur and Vassilvitskii 2007), followed by Lloyd steps.

use super::constants::{MAX_LLOYD_STEPS, REGULARISATION_M2};
use super::point_blocks::{check_points, check_weights};
use super::{Gaussian, Mixture, MixtureError};
use nalgebra::{Matrix3, Point3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A start with `components` components, another one for every `restart` of a `seed`. Each component has the mean, covariance
/// and mass of one cell of k-means.
///
/// # Errors
/// No points or components, more components than distinct points (of some weight), coordinates or
/// weights that are not finite.
pub fn k_means_start(
    points: &[Point3<f64>],
    weights: Option<&[f64]>,
    components: usize,
    seed: u64,
    restart: u64,
) -> Result<Mixture, MixtureError> {
    check_points(points)?;
    if points.is_empty() {
        return Err(MixtureError::NoPoints);
    }
    if components == 0 {
        return Err(MixtureError::NoComponents);
    }
    if let Some(weights) = weights {
        check_weights(points, weights)?;
    }
    let weight = |i: usize| weights.map_or(1.0, |w| w[i]);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(restart);
    let mut centres = draw_centres(points, &weight, components, &mut rng)?;
    let mut cell = vec![0usize; points.len()];
    for _ in 0..MAX_LLOYD_STEPS {
        let moved = assign(points, &centres, &mut cell);
        if !moved {
            break;
        }
        recentre(points, &weight, &cell, &mut centres);
    }
    from_cells(points, &weight, &cell, &centres)
}

/// k-means++: each next centre is a point drawn in proportion to its squared distance from the centres so far.
fn draw_centres(
    points: &[Point3<f64>],
    weight: &impl Fn(usize) -> f64,
    components: usize,
    rng: &mut ChaCha8Rng,
) -> Result<Vec<Point3<f64>>, MixtureError> {
    let mut draw_weight: Vec<f64> = (0..points.len()).map(weight).collect();
    let mut nearest = vec![f64::INFINITY; points.len()];
    let mut centres = Vec::with_capacity(components);
    while centres.len() < components {
        let total: f64 = draw_weight.iter().sum();
        if total.is_nan() || total <= 0.0 {
            return Err(MixtureError::TooFewPoints {
                components,
                distinct: centres.len(),
            });
        }
        let mut rest = rng.random::<f64>() * total;
        let mut chosen = None;
        for (i, &p) in draw_weight.iter().enumerate() {
            if p > 0.0 {
                chosen = Some(i);
                rest -= p;
                if rest < 0.0 {
                    break;
                }
            }
        }
        let Some(centre) = chosen.map(|i| points[i]) else {
            continue;
        };
        for (i, p) in points.iter().enumerate() {
            let d2 = (p - centre).norm_squared();
            if d2 < nearest[i] {
                nearest[i] = d2;
                draw_weight[i] = weight(i) * d2;
            }
        }
        centres.push(centre);
    }
    Ok(centres)
}

/// Assigns every point to the cell of its nearest centre (the first on ties); whether any changed.
fn assign(points: &[Point3<f64>], centres: &[Point3<f64>], cell: &mut [usize]) -> bool {
    let mut moved = false;
    for (p, cell) in points.iter().zip(cell) {
        let (mut best, mut at) = (f64::INFINITY, 0);
        for (k, c) in centres.iter().enumerate() {
            let d2 = (p - c).norm_squared();
            if d2 < best {
                (best, at) = (d2, k);
            }
        }
        moved |= at != *cell;
        *cell = at;
    }
    moved
}

/// Moves every centre to the mean of its cell; an empty cell keeps its centre.
fn recentre(
    points: &[Point3<f64>],
    weight: &impl Fn(usize) -> f64,
    cell: &[usize],
    centres: &mut [Point3<f64>],
) {
    let mut sums = vec![(0.0, nalgebra::Vector3::zeros()); centres.len()];
    for (i, (p, &k)) in points.iter().zip(cell).enumerate() {
        let w = weight(i);
        sums[k].0 += w;
        sums[k].1 += (p - centres[k]) * w;
    }
    for (centre, (mass, shift)) in centres.iter_mut().zip(sums) {
        if mass > 0.0 {
            *centre += shift / mass;
        }
    }
}

fn from_cells(
    points: &[Point3<f64>],
    weight: &impl Fn(usize) -> f64,
    cell: &[usize],
    centres: &[Point3<f64>],
) -> Result<Mixture, MixtureError> {
    let mut members = vec![Vec::new(); centres.len()];
    for (i, &k) in cell.iter().enumerate() {
        members[k].push(i);
    }
    let (mut masses, mut components) = (Vec::new(), Vec::new());
    for (members, &centre) in members.iter().zip(centres) {
        let found =
            Gaussian::from_weighted_points(members.iter().map(|&i| (&points[i], weight(i))));
        let empty = (
            Gaussian {
                mean: centre,
                covariance: Matrix3::zeros(),
            },
            0.0,
        );
        let (mut gaussian, mass) = found.unwrap_or(empty);
        gaussian.covariance += Matrix3::from_diagonal_element(REGULARISATION_M2);
        masses.push(mass);
        components.push(gaussian);
    }
    Mixture::from_masses(masses, components)
}

#[cfg(test)]
mod tests {
    use super::k_means_start;
    use crate::mixture::MixtureError;
    use nalgebra::{Point3, Vector3};

    fn three_clusters() -> Vec<Point3<f64>> {
        let clusters = [
            Point3::origin(),
            Point3::new(10.0, 0.0, 0.0),
            Point3::new(0.0, 10.0, 0.0),
        ];
        (0..90)
            .map(|i| {
                clusters[i % 3]
                    + Vector3::new(
                        (i as f64).sin(),
                        (i as f64 * 1.7).cos(),
                        0.3 * (i as f64 * 0.7).sin(),
                    )
            })
            .collect()
    }

    #[test]
    fn clusters_are_found_and_restarts_differ() {
        let points = three_clusters();
        let start = k_means_start(&points, None, 3, 7, 0).expect("enough points");
        for w in &start.weights {
            assert!((w - 1.0 / 3.0).abs() < 1e-12);
        }
        assert_eq!(k_means_start(&points, None, 3, 7, 0).expect("again"), start);
        let many: Vec<_> = (0..4)
            .map(|r| k_means_start(&points, None, 6, 7, r).expect("enough"))
            .collect();
        assert!(many.windows(2).any(|pair| pair[0] != pair[1]));
    }

    #[test]
    fn too_few_distinct_points_are_an_error() {
        let p = Point3::new(1.0, 2.0, 3.0);
        let err = k_means_start(&[p, p, p + Vector3::x()], None, 3, 0, 0)
            .expect_err("two distinct points");
        assert_eq!(
            err,
            MixtureError::TooFewPoints {
                components: 3,
                distinct: 2
            }
        );
        assert_eq!(
            k_means_start(&[], None, 1, 0, 0),
            Err(MixtureError::NoPoints)
        );
        assert_eq!(
            k_means_start(&[p], None, 0, 0, 0),
            Err(MixtureError::NoComponents)
        );
        let weightless = k_means_start(&[p, p + Vector3::x()], Some(&[1.0, 0.0]), 2, 0, 0);
        assert_eq!(
            weightless,
            Err(MixtureError::TooFewPoints {
                components: 2,
                distinct: 1
            })
        );
    }
}
