//! Quadrature over surfaces: Gauss-Legendre along straight parameters, equal steps around circles.

use nalgebra::{Point3, Vector3};

/// An element of a surface with its outward unit normal.
#[derive(Debug, Clone, Copy)]
pub(in crate::shape) struct SurfaceElement {
    pub position: Point3<f64>,
    pub normal: Vector3<f64>,
    pub area_m2: f64,
}

/// Nodes and weights of the 5-point Gauss-Legendre rule on [-1, 1], exact to degree 9: the error of second moments of a
/// surface with a smooth density is some 1e-4.
const GAUSS_5: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];

/// Nodes and weights of the 5-point rule on [`from`, `to`].
pub(in crate::shape) fn gauss_legendre(from: f64, to: f64) -> impl Iterator<Item = (f64, f64)> {
    let (half, middle) = ((to - from) / 2.0, f64::midpoint(from, to));
    GAUSS_5
        .iter()
        .map(move |(node, weight)| (middle + half * node, half * weight))
}

/// Positive nodes and weights of the 8-point Gauss-Legendre rule on [-1, 1], exact to degree 15: for surfaces whose density
/// is not smooth.
const GAUSS_8: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_3),
];

/// Nodes and weights of the 8-point rule on [-1, 1].
pub(super) fn gauss_legendre_8() -> impl Iterator<Item = (f64, f64)> {
    GAUSS_8
        .iter()
        .flat_map(|&(node, weight)| [(node, weight), (-node, weight)])
}

/// (cos, sin, weight) of `steps` equal steps around a circle; weights sum to 2 pi. Exact for trigonometric polynomials of a
/// degree below `steps`.
pub(super) fn circle_steps(steps: usize) -> impl Iterator<Item = (f64, f64, f64)> {
    let step = std::f64::consts::TAU / steps as f64;
    (0..steps).map(move |k| {
        let (sin, cos) = ((k as f64 + 0.5) * step).sin_cos();
        (cos, sin, step)
    })
}

#[cfg(test)]
mod tests {
    use super::{circle_steps, gauss_legendre, gauss_legendre_8};

    #[test]
    fn rules_integrate_known_functions() {
        let degree_9: f64 = gauss_legendre(0.0, 2.0).map(|(x, w)| w * x.powi(9)).sum();
        assert!((degree_9 / (2f64.powi(10) / 10.0) - 1.0).abs() < 1e-12);
        let degree_14: f64 = gauss_legendre_8().map(|(x, w)| w * x.powi(14)).sum();
        assert!((degree_14 * 15.0 / 2.0 - 1.0).abs() < 1e-12);
        let cos_squared: f64 = circle_steps(8).map(|(c, _, w)| w * c * c).sum();
        assert!((cos_squared - std::f64::consts::PI).abs() < 1e-12);
    }
}
