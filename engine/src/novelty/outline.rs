//! Outline of a segment as a sensor sees it: the ellipse with the moments of its directions.

use nalgebra::{Matrix2, SymmetricEigen, Vector2, Vector3};

/// A uniform distribution over an ellipse extends two standard deviations to each side.
const HALF_AXIS_SIGMAS: f64 = 2.0;

/// An ellipse of directions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Outline {
    axis: Vector3<f64>,
    across: Vector3<f64>,
    up: Vector3<f64>,
    middle: Vector2<f64>,
    covariance: Matrix2<f64>,
    /// Variances along its own axes, the smaller first.
    variances: [f64; 2],
}

impl Outline {
    /// `directions` are unit vectors, at least one.
    pub(super) fn new(directions: &[Vector3<f64>]) -> Self {
        let n = directions.len() as f64;
        let axis = directions
            .iter()
            .sum::<Vector3<f64>>()
            .try_normalize(1e-9)
            .unwrap_or_else(Vector3::x);
        let across = axis
            .cross(&if axis.z.abs() < 0.9 {
                Vector3::z()
            } else {
                Vector3::x()
            })
            .normalize();
        let up = axis.cross(&across);
        let flat: Vec<Vector2<f64>> = directions
            .iter()
            .map(|d| Vector2::new(d.dot(&across), d.dot(&up)))
            .collect();
        let middle = flat.iter().sum::<Vector2<f64>>() / n;
        let covariance = flat
            .iter()
            .map(|v| (v - middle) * (v - middle).transpose())
            .sum::<Matrix2<f64>>()
            / n;
        let eigen = SymmetricEigen::new(covariance);
        let (small, large) = (eigen.eigenvalues.min(), eigen.eigenvalues.max());
        Self {
            axis,
            across,
            up,
            middle,
            covariance,
            variances: [small.max(0.0), large.max(0.0)],
        }
    }

    /// Angular widths, the smaller first, radians: those of a uniform strip, whose standard deviation is its width over
    /// sqrt(12).
    pub(super) fn widths_rad(&self) -> [f64; 2] {
        self.variances.map(|v| (12.0 * v).sqrt())
    }

    /// Solid angle of the ellipse, steradians.
    pub(super) fn solid_angle_sr(&self) -> f64 {
        let [small, large] = self.variances;
        std::f64::consts::PI * HALF_AXIS_SIGMAS * HALF_AXIS_SIGMAS * (small * large).sqrt()
    }

    /// Whether the unit direction `d` lies inside.
    pub(super) fn contains(&self, d: &Vector3<f64>) -> bool {
        let off = Vector2::new(d.dot(&self.across), d.dot(&self.up)) - self.middle;
        d.dot(&self.axis) > 0.0
            && self.covariance.try_inverse().is_some_and(|inverse| {
                off.dot(&(inverse * off)) <= HALF_AXIS_SIGMAS * HALF_AXIS_SIGMAS
            })
    }
}

#[cfg(test)]
mod tests {
    use super::Outline;
    use nalgebra::Vector3;

    /// Directions over an ellipse of half axes `a` across and `b` up (small angles), tilted up by `tilt`.
    fn ellipse(a: f64, b: f64, tilt: f64) -> Vec<Vector3<f64>> {
        let mut inside = Vec::new();
        for i in -40..=40 {
            for k in -40..=40 {
                let (u, v) = (f64::from(i) / 40.0, f64::from(k) / 40.0);
                if u * u + v * v <= 1.0 {
                    let d = Vector3::new(1.0, a * u, b * v).normalize();
                    let (sin, cos) = tilt.sin_cos();
                    inside.push(Vector3::new(
                        d.x * cos - d.z * sin,
                        d.y,
                        d.x * sin + d.z * cos,
                    ));
                }
            }
        }
        inside
    }

    #[test]
    fn an_ellipse_is_its_own_outline() {
        for tilt in [0.0, 0.7, 1.5] {
            let outline = Outline::new(&ellipse(0.05, 0.02, tilt));
            let area = std::f64::consts::PI * 0.05 * 0.02;
            assert!((outline.solid_angle_sr() / area - 1.0).abs() < 0.01);
            let [small, large] = outline.widths_rad();
            // sqrt(12) / 2.
            assert!((small / (0.02 * 3.0_f64.sqrt()) - 1.0).abs() < 0.01);
            assert!((large / (0.05 * 3.0_f64.sqrt()) - 1.0).abs() < 0.01);
            let inside = ellipse(0.049, 0.0196, tilt);
            assert!(inside.iter().all(|d| outline.contains(d)));
            let outside = |d: &&Vector3<f64>| !outline.contains(d);
            let around = ellipse(0.1, 0.04, tilt);
            let share = around.iter().filter(outside).count() as f64 / around.len() as f64;
            assert!((share - 0.75).abs() < 0.02, "{share}");
            assert!(!outline.contains(&-inside[0]));
        }
    }

    #[test]
    fn the_outline_of_a_line_contains_nothing() {
        let line: Vec<_> = (0..9)
            .map(|k| Vector3::new(1.0, 0.01 * f64::from(k), 0.0).normalize())
            .collect();
        let outline = Outline::new(&line);
        assert!(outline.solid_angle_sr() < 1e-6);
        assert!(!outline.contains(&Vector3::new(1.0, 0.04, 0.01).normalize()));
    }
}
