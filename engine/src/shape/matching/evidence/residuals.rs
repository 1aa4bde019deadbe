//! Residuals between a fitted surface and the points: noise, or a sign of another class.

use crate::shape::constants::{
    FACE_NOISE_POINTS, OUTLIER_FRACTION, OUTLIER_SIGMAS, QUADRIC_NEIGHBOURS, UNEXPLAINED_SIGMAS,
};
use crate::shape::matching::fit::Observation;
use crate::shape::primitive::Primitive;
use nalgebra::{Matrix3, Matrix6, Point3, Unit, Vector3, Vector6};

/// Cells per axis in which residuals are averaged: three show a slope and a bend.
const CELLS: usize = 3;

/// Whether the distances of the points from the surface are no greater than noise of `sd_m` explains.
pub(in crate::shape::matching) fn within_noise(
    observed: &Observation,
    primitive: &Primitive,
    sd_m: f64,
) -> bool {
    let distances = clipped_distances(observed, primitive, sd_m);
    let n = distances.len().max(1) as f64;
    mean_square(&distances) <= 1.0 + UNEXPLAINED_SIGMAS * (2.0 / n).sqrt()
}

/// Whether more points are beyond `OUTLIER_SIGMAS` of the surface than outliers are expected. Clipped as in
/// [`within_noise`], the few of a face far behind the others would pass for noise.
pub(in crate::shape::matching) fn exceeds_outlier_count(
    observed: &Observation,
    primitive: &Primitive,
    sd_m: f64,
) -> bool {
    let limit_m = OUTLIER_SIGMAS * sd_m;
    let points = observed.points.iter();
    let beyond = points.filter(|p| observed.distance_m(primitive, p).abs() > limit_m);
    beyond.count() as f64 > max_outliers(observed.points.len())
}

/// Points of other surfaces or far beyond the noise that are expected among `count` points of an object.
pub(super) fn max_outliers(count: usize) -> f64 {
    OUTLIER_FRACTION * count as f64 + FACE_NOISE_POINTS
}

/// Whether the mean distances from the surface over the regions of the object are no greater than noise explains. `axes`
/// are the moments' eigenvectors by falling eigenvalue; the regions are thirds along the first two.
pub(in crate::shape::matching) fn without_pattern(
    observed: &Observation,
    primitive: &Primitive,
    axes: &[Unit<Vector3<f64>>],
) -> bool {
    let distances = clipped_distances(observed, primitive, observed.noise_m);
    let [first, second] = [0, 1].map(|k| thirds(&observed.points, &axes[k]));
    let (mut sums, mut counts) = ([0.0; CELLS * CELLS], [0.0; CELLS * CELLS]);
    for ((z, i), k) in distances.iter().zip(first).zip(second) {
        sums[i * CELLS + k] += z;
        counts[i * CELLS + k] += 1.0;
    }
    // Chi-square of the cells' means, in units of the variance of the distances.
    let square = mean_square(&distances).max(f64::MIN_POSITIVE);
    let (mut chi_2, mut degrees) = (0.0, 0.0);
    for (sum, count) in sums.iter().zip(&counts).filter(|(_, n)| **n > 0.0) {
        chi_2 += sum * sum / (count * square);
        degrees += 1.0;
    }
    chi_2 <= degrees + UNEXPLAINED_SIGMAS * f64::sqrt(2.0 * degrees)
}

/// Noise of the points about their neighbours, metres: the median over all points of the residual of a quadric through
/// the nearest `QUADRIC_NEIGHBOURS`. It depends on no class and no noise law, and so distinguishes a noisy laser from a
/// wrong class; edges within a neighbourhood make it too great. Zero for fewer points.
pub(in crate::shape::matching) fn local_noise_m(points: &[Point3<f64>]) -> f64 {
    let mut variances: Vec<f64> = points
        .iter()
        .filter_map(|p| quadric_variance(points, p))
        .collect();
    variances.sort_by(f64::total_cmp);
    let median = variances.get(variances.len() / 2).copied().unwrap_or(0.0);
    median.sqrt()
}

/// Variance of the nearest points of `p` about the quadric over their plane, square metres.
fn quadric_variance(points: &[Point3<f64>], p: &Point3<f64>) -> Option<f64> {
    if points.len() < QUADRIC_NEIGHBOURS {
        return None;
    }
    let mut near: Vec<Vector3<f64>> = points.iter().map(|q| q - p).collect();
    near.select_nth_unstable_by(QUADRIC_NEIGHBOURS - 1, |a, b| {
        a.norm_squared().total_cmp(&b.norm_squared())
    });
    near.truncate(QUADRIC_NEIGHBOURS);
    let mean = near.iter().sum::<Vector3<f64>>() / near.len() as f64;
    let spread: Matrix3<f64> = near
        .iter()
        .map(|d| (d - mean) * (d - mean).transpose())
        .sum();
    let eigen = spread.symmetric_eigen();
    let flat = eigen.eigenvalues.imin();
    let [i, k] = [(flat + 1) % 3, (flat + 2) % 3];
    let unit = spread.trace().sqrt().max(f64::MIN_POSITIVE);
    let (mut normal, mut right, mut square) = (Matrix6::zeros(), Vector6::zeros(), 0.0);
    for d in &near {
        let local = eigen.eigenvectors.transpose() * (d - mean) / unit;
        let (x, y, z) = (local[i], local[k], local[flat]);
        let row = Vector6::new(1.0, x, y, x * x, x * y, y * y);
        normal += row * row.transpose();
        right += row * z;
        square += z * z;
    }
    let solved = normal.cholesky()?.solve(&right);
    let free = (QUADRIC_NEIGHBOURS - 6) as f64;
    Some((square - solved.dot(&right)).max(0.0) / free * unit * unit)
}

/// Distances of all points in units of `sd_m`, clipped at `OUTLIER_SIGMAS`.
fn clipped_distances(observed: &Observation, primitive: &Primitive, sd_m: f64) -> Vec<f64> {
    let points = observed.points.iter();
    let clip = |z: f64| z.clamp(-OUTLIER_SIGMAS, OUTLIER_SIGMAS);
    points
        .map(|p| clip(observed.distance_m(primitive, p) / sd_m))
        .collect()
}

fn mean_square(values: &[f64]) -> f64 {
    values.iter().map(|z| z * z).sum::<f64>() / values.len().max(1) as f64
}

/// For each point, which third of all points along `axis` it belongs to.
fn thirds(points: &[Point3<f64>], axis: &Unit<Vector3<f64>>) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    let position = |i: usize| points[i].coords.dot(axis);
    order.sort_by(|&a, &b| position(a).total_cmp(&position(b)));
    let mut third = vec![0; points.len()];
    for (rank, &i) in order.iter().enumerate() {
        third[i] = rank * CELLS / points.len();
    }
    third
}

#[cfg(test)]
mod tests {
    use super::{exceeds_outlier_count, local_noise_m, within_noise, without_pattern};
    use crate::shape::matching::fit::Observation;
    use crate::shape::primitive::{Cylinder, Primitive, Sphere};
    use crate::shape::settings::{BeamDensity, SurfaceModel};
    use crate::shape::tests::scenes::simulate_view;
    use nalgebra::{Matrix3, Point3, Vector3};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    /// Points of an upright cylinder of radius 0.2 m, `bulge_m` wider half-way up and as much narrower at its ends, with
    /// alternating noise of 1 cm.
    fn bulging_cylinder(bulge_m: f64) -> (Observation, Primitive) {
        let mut points = Vec::new();
        for row in 0..12 {
            let z = f64::from(row) / 11.0 - 0.5;
            for column in 0..9 {
                let angle = (f64::from(column) - 4.0) * 0.35;
                let noise = if (row + column) % 2 == 0 { 0.01 } else { -0.01 };
                let r = 0.2 + noise + bulge_m * (1.0 - 4.0 * z.abs());
                points.push(Point3::new(-r * angle.cos(), r * angle.sin(), z));
            }
        }
        let observed = Observation::new(
            &Matrix3::identity(),
            108.0,
            0.01,
            Point3::new(-3.0, 0.0, 0.0),
            points,
            SurfaceModel::Visible,
            BeamDensity::SolidAngle,
        );
        let cylinder = Primitive::Cylinder(Cylinder {
            centre: Point3::origin(),
            axis: Vector3::z_axis(),
            radius_m: 0.2,
            length_m: 1.1,
        });
        (observed, cylinder)
    }

    #[test]
    fn the_noise_of_a_sphere_is_known_from_neighbours() {
        let ball = Primitive::Sphere(Sphere {
            centre: Point3::new(3.0, 0.0, 0.0),
            radius_m: 0.3,
        });
        for (points, sigma_m, from, to) in [
            (150, 0.01, 0.008, 0.013),
            (150, 0.03, 0.025, 0.036),
            (600, 0.0, 0.0, 2e-3),
        ] {
            let mut rng = ChaCha8Rng::seed_from_u64(11);
            let seen = simulate_view(&ball, &Point3::origin(), points, sigma_m, &mut rng);
            let noise_m = local_noise_m(&seen);
            assert!((from..to).contains(&noise_m), "{sigma_m}: {noise_m}");
        }
    }

    #[test]
    fn a_face_far_behind_exceeds_the_outliers_and_three_points_do_not() {
        let (mut observed, cylinder) = bulging_cylinder(0.0);
        let flags = |observed: &Observation| {
            // Noise assumed a little too large, as noise laws mostly are.
            let sd_m = 1.05 * observed.noise_m;
            (
                within_noise(observed, &cylinder, sd_m),
                exceeds_outlier_count(observed, &cylinder, sd_m),
            )
        };
        // Of 108 points 3 may be outliers.
        observed.points[..3].fill(Point3::new(0.3, 0.3, 0.0));
        assert_eq!(flags(&observed), (true, false));
        observed.points[..4].fill(Point3::new(0.3, 0.3, 0.0));
        assert_eq!(flags(&observed), (true, true));
    }

    #[test]
    fn a_bulge_below_the_noise_is_found() {
        let axes = [Vector3::z_axis(), Vector3::y_axis(), Vector3::x_axis()];
        for (bulge_m, noise) in [(0.0, true), (0.012, false), (0.05, false)] {
            let (observed, cylinder) = bulging_cylinder(bulge_m);
            let unpatterned = without_pattern(&observed, &cylinder, &axes);
            assert_eq!(unpatterned, noise, "{bulge_m}");
            let small = within_noise(&observed, &cylinder, observed.noise_m);
            assert_eq!(small, noise, "{bulge_m}");
        }
    }
}
