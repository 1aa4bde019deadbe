//! Outlines of shapes and Gaussians, for figures.

use nalgebra::{Matrix3, Point3, Vector3};
use patrold_engine::mixture::Gaussian;
use patrold_engine::shape::{Class, Shape};
use std::f64::consts::TAU;

/// Corners of a circle.
const CORNERS: usize = 48;

/// A line through these points, metres.
pub type Polyline = Vec<Point3<f64>>;

/// The outline of a shape: three great circles, two rims with four lines between, a rectangle; a box for other classes.
pub fn shape_outline(shape: &Shape) -> Vec<Polyline> {
    let half = Vector3::from(shape.size_m) / 2.0;
    let point = |x: f64, y: f64, z: f64| {
        shape.centre + shape.rotation * Vector3::new(x, y, z).component_mul(&half)
    };
    let rectangle = |z: f64| -> Polyline {
        let corners = [
            [1.0, 1.0],
            [-1.0, 1.0],
            [-1.0, -1.0],
            [1.0, -1.0],
            [1.0, 1.0],
        ];
        corners.iter().map(|[x, y]| point(*x, *y, z)).collect()
    };
    let rim = |z: f64| -> Polyline { unit_circle().map(|(c, s)| point(c, s, z)).collect() };
    let edge = |x: f64, y: f64| vec![point(x, y, -1.0), point(x, y, 1.0)];
    match shape.class {
        Class::Sphere => circles(
            &shape.centre,
            &(shape.rotation * Matrix3::from_diagonal(&half)),
        ),
        Class::Cylinder => {
            let sides = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
            let rims = [rim(-1.0), rim(1.0)].into_iter();
            rims.chain(sides.map(|[x, y]| edge(x, y))).collect()
        }
        Class::Plane => vec![rectangle(0.0)],
        _ => {
            let sides = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];
            let ends = [rectangle(-1.0), rectangle(1.0)].into_iter();
            ends.chain(sides.map(|[x, y]| edge(x, y))).collect()
        }
    }
}

/// Three ellipses of the ellipsoid at `scale` standard deviations.
pub fn gaussian_outline(gaussian: &Gaussian, scale: f64) -> Vec<Polyline> {
    let eigen = gaussian.covariance.symmetric_eigen();
    let lengths = eigen.eigenvalues.map(|l| scale * l.max(0.0).sqrt());
    circles(
        &gaussian.mean,
        &(eigen.eigenvectors * Matrix3::from_diagonal(&lengths)),
    )
}

/// The unit circles of the three coordinate planes, transformed by `axes` and moved to `centre`.
fn circles(centre: &Point3<f64>, axes: &Matrix3<f64>) -> Vec<Polyline> {
    [[0, 1], [1, 2], [2, 0]]
        .map(|[i, j]| {
            unit_circle()
                .map(|(c, s)| centre + axes.column(i) * c + axes.column(j) * s)
                .collect()
        })
        .into()
}

fn unit_circle() -> impl Iterator<Item = (f64, f64)> {
    (0..=CORNERS).map(|k| {
        let (sin, cos) = (k as f64 / CORNERS as f64 * TAU).sin_cos();
        (cos, sin)
    })
}

#[cfg(test)]
mod tests {
    use super::gaussian_outline;
    use nalgebra::{Matrix3, Point3, Vector3};
    use patrold_engine::mixture::Gaussian;

    #[test]
    fn the_outline_of_a_gaussian_lies_at_its_distance() {
        let gaussian = Gaussian {
            mean: Point3::new(1.0, 2.0, 3.0),
            covariance: Matrix3::from_diagonal(&Vector3::new(0.04, 0.01, 0.09)),
        };
        for p in gaussian_outline(&gaussian, 2.0).concat() {
            let z = (p - gaussian.mean).component_div(&Vector3::new(0.2, 0.1, 0.3));
            assert!((z.norm() - 2.0).abs() < 1e-12);
        }
    }
}
