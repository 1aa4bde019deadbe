//! Samples on the surfaces of a mixture's ellipsoids (paper section IV.A, Eq. 8-9).

use super::constants::{DRAWS_PER_SAMPLE, MIN_SEMI_AXIS_M};
use crate::mixture::{Gaussian, Mixture, Posterior};
use nalgebra::{Matrix3, Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, UnitSphere};

struct Ellipsoid {
    mean: Point3<f64>,
    axes: Matrix3<f64>,
    /// Standard deviations along the axes.
    sd: Vector3<f64>,
    weight: f64,
}

impl Ellipsoid {
    /// `None` for a component without weight or with a covariance that is not finite.
    fn new(weight: f64, gaussian: &Gaussian) -> Option<Self> {
        if weight <= 0.0 || !gaussian.covariance.iter().all(|v| v.is_finite()) {
            return None;
        }
        let eigen = gaussian.covariance.symmetric_eigen();
        let sd = |l: f64| l.max(0.0).sqrt().max(MIN_SEMI_AXIS_M);
        Some(Self {
            mean: gaussian.mean,
            axes: eigen.eigenvectors,
            sd: eigen.eigenvalues.map(sd),
            weight,
        })
    }

    fn gaussian(&self) -> Gaussian {
        let variances = Matrix3::from_diagonal(&self.sd.map(|s| s * s));
        Gaussian {
            mean: self.mean,
            covariance: self.axes * variances * self.axes.transpose(),
        }
    }
}

/// `count` points, uniform by area, on the ellipsoids whose semi-axes are `scale` standard deviations along each component's
/// eigenvectors, and the outward unit normals there. A component is drawn with probability p_k; a sample is kept only where
/// its own component has the greatest posterior (paper Eq. 8), which leaves the outside of overlapping ellipsoids. Fewer
/// samples are returned where that leaves next to nothing.
pub fn surface_samples(
    mixture: &Mixture,
    count: usize,
    scale: f64,
    seed: u64,
) -> (Vec<Point3<f64>>, Vec<Vector3<f64>>) {
    let components = mixture.weights.iter().zip(&mixture.components);
    let ellipsoids: Vec<Ellipsoid> = components
        .filter_map(|(weight, gaussian)| Ellipsoid::new(*weight, gaussian))
        .collect();
    let total: f64 = ellipsoids.iter().map(|e| e.weight).sum();
    let (mut points, mut normals) = (Vec::with_capacity(count), Vec::with_capacity(count));
    let posterior = Posterior::new(&Mixture {
        weights: ellipsoids.iter().map(|e| e.weight / total).collect(),
        components: ellipsoids.iter().map(Ellipsoid::gaussian).collect(),
    });
    let Ok(posterior) = posterior else {
        return (points, normals);
    };
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for _ in 0..count.saturating_mul(DRAWS_PER_SAMPLE) {
        if points.len() == count {
            break;
        }
        let mut left = rng.random::<f64>() * total;
        let chosen = ellipsoids.iter().position(|e| {
            left -= e.weight;
            left <= 0.0
        });
        let k = chosen.unwrap_or(ellipsoids.len() - 1);
        let Some(e) = ellipsoids.get(k) else { break };
        let u = Vector3::from(<UnitSphere as Distribution<[f64; 3]>>::sample(
            &UnitSphere,
            &mut rng,
        ));
        // Scaling the unit sphere by A scales its area by |A^-T u| det A.
        let gradient = u.component_div(&e.sd);
        if rng.random::<f64>() > gradient.norm() * e.sd.min() {
            continue;
        }
        let x = e.mean + e.axes * u.component_mul(&e.sd) * scale;
        if posterior.most_probable(&x) != k {
            continue;
        }
        points.push(x);
        normals.push((e.axes * gradient).normalize());
    }
    (points, normals)
}

#[cfg(test)]
mod tests {
    use super::surface_samples;
    use crate::mixture::{Gaussian, Mixture};
    use nalgebra::{Matrix3, Point3, Vector3};

    fn component(mean: [f64; 3], sd: [f64; 3]) -> Gaussian {
        Gaussian {
            mean: Point3::from(mean),
            covariance: Matrix3::from_diagonal(&Vector3::from(sd.map(|s| s * s))),
        }
    }

    #[test]
    fn samples_are_on_the_ellipsoid_and_normals_are_perpendicular() {
        let mixture = Mixture {
            weights: vec![1.0],
            components: vec![component([1.0, 2.0, 3.0], [0.3, 0.1, 0.2])],
        };
        let (points, normals) = surface_samples(&mixture, 2000, 2.0, 5);
        assert_eq!(points.len(), 2000);
        for (p, n) in points.iter().zip(&normals) {
            let d = p - Point3::new(1.0, 2.0, 3.0);
            let z = d.component_div(&Vector3::new(0.6, 0.2, 0.4));
            assert!((z.norm() - 1.0).abs() < 1e-9);
            let gradient = z.component_div(&Vector3::new(0.6, 0.2, 0.4)).normalize();
            assert!((gradient - n).norm() < 1e-9);
        }
        assert_eq!(points, surface_samples(&mixture, 2000, 2.0, 5).0);
    }

    #[test]
    fn samples_of_a_sphere_are_uniform_by_area() {
        let mixture = Mixture {
            weights: vec![1.0],
            components: vec![component([0.0; 3], [1.0; 3])],
        };
        let (points, _) = surface_samples(&mixture, 4000, 1.0, 6);
        let upper = points.iter().filter(|p| p.z > 0.5).count();
        assert!((upper as f64 / 4000.0 - 0.25).abs() < 0.03);
    }

    #[test]
    fn no_sample_is_inside_another_component() {
        let mixture = Mixture {
            weights: vec![0.5, 0.5],
            components: vec![
                component([0.0; 3], [0.5; 3]),
                component([0.4, 0.0, 0.0], [0.5; 3]),
            ],
        };
        let (points, _) = surface_samples(&mixture, 1000, 1.0, 7);
        assert!(points.iter().all(|p| p.x.min(0.4 - p.x) < 0.21));
        assert!(
            surface_samples(&Mixture::default(), 10, 1.0, 7)
                .0
                .is_empty()
        );
    }
}
