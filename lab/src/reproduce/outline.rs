//! Shapes and Gaussians as lines in space, for pictures.

use nalgebra::{Matrix3, Point3, Vector3};
use patrold_engine::mixture::Gaussian;
use patrold_engine::shape::{Class, Shape};
use std::f64::consts::TAU;

/// Corners of a drawn circle.
const CORNERS: usize = 48;

/// A line through these places, metres.
pub type Line = Vec<Point3<f64>>;

/// The edges of a shape: three great circles, two rims with four lines between, a rectangle; a box where the class is
/// open.
pub fn of_shape(shape: &Shape) -> Vec<Line> {
    let half = Vector3::from(shape.size_m) / 2.0;
    let place = |x: f64, y: f64, z: f64| {
        shape.centre + shape.rotation * Vector3::new(x, y, z).component_mul(&half)
    };
    let rectangle = |z: f64| -> Line {
        let corners = [
            [1.0, 1.0],
            [-1.0, 1.0],
            [-1.0, -1.0],
            [1.0, -1.0],
            [1.0, 1.0],
        ];
        corners.iter().map(|[x, y]| place(*x, *y, z)).collect()
    };
    let rim = |z: f64| -> Line { turn().map(|(c, s)| place(c, s, z)).collect() };
    let corner = |x: f64, y: f64| vec![place(x, y, -1.0), place(x, y, 1.0)];
    match shape.class {
        Class::Sphere => circles(
            &shape.centre,
            &(shape.rotation * Matrix3::from_diagonal(&half)),
        ),
        Class::Cylinder => {
            let sides = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
            let rims = [rim(-1.0), rim(1.0)].into_iter();
            rims.chain(sides.map(|[x, y]| corner(x, y))).collect()
        }
        Class::Plane => vec![rectangle(0.0)],
        _ => {
            let sides = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];
            let ends = [rectangle(-1.0), rectangle(1.0)].into_iter();
            ends.chain(sides.map(|[x, y]| corner(x, y))).collect()
        }
    }
}

/// Three ellipses of the ellipsoid at `scale` standard deviations.
pub fn of_gaussian(gaussian: &Gaussian, scale: f64) -> Vec<Line> {
    let eigen = gaussian.covariance.symmetric_eigen();
    let lengths = eigen.eigenvalues.map(|l| scale * l.max(0.0).sqrt());
    circles(
        &gaussian.mean,
        &(eigen.eigenvectors * Matrix3::from_diagonal(&lengths)),
    )
}

/// The unit circles of the three coordinate planes, carried by `axes` to `centre`.
fn circles(centre: &Point3<f64>, axes: &Matrix3<f64>) -> Vec<Line> {
    [[0, 1], [1, 2], [2, 0]]
        .map(|[i, j]| {
            turn()
                .map(|(c, s)| centre + axes.column(i) * c + axes.column(j) * s)
                .collect()
        })
        .into()
}

fn turn() -> impl Iterator<Item = (f64, f64)> {
    (0..=CORNERS).map(|k| {
        let (sin, cos) = (k as f64 / CORNERS as f64 * TAU).sin_cos();
        (cos, sin)
    })
}

#[cfg(test)]
mod tests {
    use super::of_gaussian;
    use nalgebra::{Matrix3, Point3, Vector3};
    use patrold_engine::mixture::Gaussian;

    #[test]
    fn lines_of_a_gaussian_lie_at_their_distance() {
        let gaussian = Gaussian {
            mean: Point3::new(1.0, 2.0, 3.0),
            covariance: Matrix3::from_diagonal(&Vector3::new(0.04, 0.01, 0.09)),
        };
        for p in of_gaussian(&gaussian, 2.0).concat() {
            let z = (p - gaussian.mean).component_div(&Vector3::new(0.2, 0.1, 0.3));
            assert!((z.norm() - 2.0).abs() < 1e-12);
        }
    }
}
