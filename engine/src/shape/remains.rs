//! What a fit leaves between its surface and the points: noise alone, or a sign that another class
//! made them.

use super::constants::{
    FACE_FLOOR_POINTS, FOREIGN_SHARE, OUTLIER_SIGMAS, QUADRIC_NEIGHBOURS, UNEXPLAINED_SIGMAS,
};
use super::matching::Observed;
use super::primitive::Primitive;
use nalgebra::{Matrix3, Matrix6, Point3, Unit, Vector3, Vector6};

/// Cells per axis in which remains are averaged: three tell a slope and a bend.
const CELLS: usize = 3;

/// Whether the distances of the points from the surface are no greater than `sd_m` makes them.
pub(super) fn within(observed: &Observed, primitive: &Primitive, sd_m: f64) -> bool {
    let distances = distances(observed, primitive, sd_m);
    let n = distances.len().max(1) as f64;
    mean_square(&distances) <= 1.0 + UNEXPLAINED_SIGMAS * (2.0 / n).sqrt()
}

/// Whether more points lie beyond `OUTLIER_SIGMAS` of the surface than strays do. Cut off as in
/// [`within`], the few of a face far behind the others would pass for noise.
pub(super) fn more_than_strays(observed: &Observed, primitive: &Primitive, sd_m: f64) -> bool {
    let limit_m = OUTLIER_SIGMAS * sd_m;
    let points = observed.points.iter();
    let beyond = points.filter(|p| observed.distance_m(primitive, p).abs() > limit_m);
    beyond.count() as f64 > strays(observed.points.len())
}

/// Points of another surface, or out of noise's reach, that `count` points of one may hold.
pub(super) fn strays(count: usize) -> f64 {
    FOREIGN_SHARE * count as f64 + FACE_FLOOR_POINTS
}

/// Whether the distances of the points from the surface have no sign in common within any region
/// of the thing. `axes` are the moments' eigenvectors by falling eigenvalue; the regions lie along
/// the first two.
pub(super) fn without_pattern(
    observed: &Observed,
    primitive: &Primitive,
    axes: &[Unit<Vector3<f64>>],
) -> bool {
    let distances = distances(observed, primitive, observed.noise_m);
    let [first, second] = [0, 1].map(|k| thirds(&observed.points, &axes[k]));
    let (mut sums, mut counts) = ([0.0; CELLS * CELLS], [0.0; CELLS * CELLS]);
    for ((z, i), k) in distances.iter().zip(first).zip(second) {
        sums[i * CELLS + k] += z;
        counts[i * CELLS + k] += 1.0;
    }
    // Chi-square of the cells' means, in units of what the distances themselves scatter.
    let square = mean_square(&distances).max(f64::MIN_POSITIVE);
    let (mut chi_2, mut degrees) = (0.0, 0.0);
    for (sum, count) in sums.iter().zip(&counts).filter(|(_, n)| **n > 0.0) {
        chi_2 += sum * sum / (count * square);
        degrees += 1.0;
    }
    chi_2 <= degrees + UNEXPLAINED_SIGMAS * f64::sqrt(2.0 * degrees)
}

/// Noise of the points by their own neighbours, metres: what a quadric through the nearest
/// `QUADRIC_NEIGHBOURS` of each leaves of them, in the median. It knows no class and no law, and so
/// tells a noisy laser from a wrong class; edges and bends within a neighbourhood make it too great.
/// Zero for fewer points.
pub(super) fn noise_among_neighbours_m(points: &[Point3<f64>]) -> f64 {
    let mut left: Vec<f64> = points
        .iter()
        .filter_map(|p| quadric_remains(points, p))
        .collect();
    left.sort_by(f64::total_cmp);
    let median = left.get(left.len() / 2).copied().unwrap_or(0.0);
    median.sqrt()
}

/// Variance of the nearest points of `p` about the quadric over their own plane.
fn quadric_remains(points: &[Point3<f64>], p: &Point3<f64>) -> Option<f64> {
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

/// Distances of all points in units of `sd_m`, cut off where an outlier's pull ends.
fn distances(observed: &Observed, primitive: &Primitive, sd_m: f64) -> Vec<f64> {
    let points = observed.points.iter();
    let cut = |z: f64| z.clamp(-OUTLIER_SIGMAS, OUTLIER_SIGMAS);
    points
        .map(|p| cut(observed.distance_m(primitive, p) / sd_m))
        .collect()
}

fn mean_square(distances: &[f64]) -> f64 {
    distances.iter().map(|z| z * z).sum::<f64>() / distances.len().max(1) as f64
}

/// Which third of all points, by their place along `axis`, every point belongs to.
fn thirds(points: &[Point3<f64>], axis: &Unit<Vector3<f64>>) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    let place = |i: usize| points[i].coords.dot(axis);
    order.sort_by(|&a, &b| place(a).total_cmp(&place(b)));
    let mut third = vec![0; points.len()];
    for (rank, &i) in order.iter().enumerate() {
        third[i] = rank * CELLS / points.len();
    }
    third
}

#[cfg(test)]
mod tests {
    use super::{more_than_strays, noise_among_neighbours_m, within, without_pattern};
    use crate::shape::matching::Observed;
    use crate::shape::primitive::{Cylinder, Primitive, Sphere};
    use crate::shape::scenes::look;
    use crate::shape::settings::{BeamDensity, SurfaceModel};
    use nalgebra::{Matrix3, Point3, Vector3};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    /// Points of an upright bar of radius 0.2 m seen from far, `bulge_m` wider half-way up and as
    /// much narrower at its ends, with alternating noise of 1 cm.
    fn bar(bulge_m: f64) -> (Observed, Primitive) {
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
        let observed = Observed::new(
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
    fn neighbours_tell_the_noise_of_a_ball() {
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
            let seen = look(&ball, &Point3::origin(), points, sigma_m, &mut rng);
            let told = noise_among_neighbours_m(&seen);
            assert!((from..to).contains(&told), "{sigma_m}: {told}");
        }
    }

    #[test]
    fn a_side_far_behind_is_more_than_strays_and_two_points_are_not() {
        let (mut observed, cylinder) = bar(0.0);
        let told = |observed: &Observed| {
            // Noise told a little too large, as laws of noise mostly are.
            let sd_m = 1.05 * observed.noise_m;
            (
                within(observed, &cylinder, sd_m),
                more_than_strays(observed, &cylinder, sd_m),
            )
        };
        // Of 108 points 3 may be strays.
        observed.points[..3].fill(Point3::new(0.3, 0.3, 0.0));
        assert_eq!(told(&observed), (true, false));
        observed.points[..4].fill(Point3::new(0.3, 0.3, 0.0));
        assert_eq!(told(&observed), (true, true));
    }

    #[test]
    fn noise_is_noise_and_a_bulge_below_it_is_seen() {
        let axes = [Vector3::z_axis(), Vector3::y_axis(), Vector3::x_axis()];
        for (bulge_m, noise) in [(0.0, true), (0.012, false), (0.05, false)] {
            let (observed, cylinder) = bar(bulge_m);
            let told = without_pattern(&observed, &cylinder, &axes);
            assert_eq!(told, noise, "{bulge_m}");
            let told = within(&observed, &cylinder, observed.noise_m);
            assert_eq!(told, noise, "{bulge_m}");
        }
    }
}
