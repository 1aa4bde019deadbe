//! What a mixture hides: its components as plates that lines of sight end on.

use super::constants::PREDICTED_SIGMAS;
use crate::mixture::Mixture;
use crate::mixture::linalg::Eigen;
use nalgebra::{Point3, Vector3};

/// The plate that a component spans: its two widest axes, a half side of sqrt(3) standard deviations each, as of a uniform
/// surface.
struct Plate {
    /// From the sensor, metres.
    middle: Vector3<f64>,
    normal: Vector3<f64>,
    along: [Vector3<f64>; 2],
    half_sides_m: [f64; 2],
    thickness_m: f64,
}

/// Plates of a mixture, seen from a sensor.
pub(super) struct Plates {
    origin: Point3<f64>,
    plates: Vec<Plate>,
    /// Angle within which a neighbouring beam may have met a plate that this one passes, radians.
    margin_rad: f64,
}

impl Plates {
    /// The components of `mixtures`, all in the frame of `origin`, where the sensor is.
    pub(super) fn new(mixtures: &[&Mixture], origin: Point3<f64>, margin_rad: f64) -> Self {
        let components = mixtures.iter().flat_map(|mixture| &mixture.components);
        let plates = components
            .map(|g| {
                let axes = Eigen::new(&g.covariance);
                let axis = |i: usize| -> Vector3<f64> { axes.vectors.column(i).into() };
                let sd_m = |i: usize| -> f64 { axes.values[i].max(0.0).sqrt() };
                Plate {
                    middle: g.mean - origin,
                    normal: axis(0),
                    along: [axis(1), axis(2)],
                    half_sides_m: [1, 2].map(|i| 3.0_f64.sqrt() * sd_m(i)),
                    thickness_m: sd_m(0),
                }
            })
            .collect();
        Self {
            origin,
            plates,
            margin_rad,
        }
    }

    /// Whether a plate stands between the sensor and `p`, whose range has the standard deviation `noise_m`.
    pub(super) fn hide(&self, p: &Point3<f64>, noise_m: f64) -> bool {
        let sight = p - self.origin;
        let range_m = sight.norm();
        let Some(direction) = sight.try_normalize(1e-6) else {
            return false;
        };
        self.plates
            .iter()
            .any(|plate| plate.is_before(&direction, range_m, noise_m, self.margin_rad))
    }
}

impl Plate {
    fn is_before(
        &self,
        direction: &Vector3<f64>,
        range_m: f64,
        noise_m: f64,
        margin_rad: f64,
    ) -> bool {
        let cos = self.normal.dot(direction);
        let height_m = self.normal.dot(&self.middle);
        let met_m = height_m / cos;
        // A plate that is met at a flat angle is met anywhere within its thickness.
        let sigma_m = noise_m.hypot(self.thickness_m / cos);
        // Not a number where the plate is met edge on: then it hides nothing.
        if !(met_m > 0.0 && met_m < range_m - PREDICTED_SIGMAS * sigma_m) {
            return false;
        }
        let off = direction * met_m - self.middle;
        let margin_m = margin_rad * met_m;
        (0..2).all(|i| self.along[i].dot(&off).abs() <= self.half_sides_m[i] + margin_m)
    }
}

#[cfg(test)]
mod tests {
    use super::Plates;
    use crate::mixture::{Gaussian, Mixture};
    use nalgebra::{Matrix3, Point3, Vector3};

    /// A plate of 1 m x 2 m across the x axis, 3 m ahead.
    fn plates(margin_rad: f64) -> Plates {
        let covariance = Matrix3::from_diagonal(&Vector3::new(1e-6, 1.0 / 12.0, 4.0 / 12.0));
        let mean = Point3::new(3.0, 0.0, 0.0);
        let mixture = Mixture::from_masses(vec![1.0], vec![Gaussian { mean, covariance }]);
        Plates::new(
            &[&mixture.expect("a mixture")],
            Point3::origin(),
            margin_rad,
        )
    }

    #[test]
    fn a_plate_hides_what_lies_behind_it() {
        let plates = plates(0.0);
        assert!(plates.hide(&Point3::new(6.0, 0.0, 0.0), 0.01));
        assert!(!plates.hide(&Point3::new(3.02, 0.0, 0.0), 0.01));
        assert!(!plates.hide(&Point3::new(2.0, 0.0, 0.0), 0.01));
        assert!(!plates.hide(&Point3::new(-6.0, 0.0, 0.0), 0.01));
    }

    #[test]
    fn it_ends_at_its_sides_and_a_neighbouring_beam_beyond() {
        // At twice the range the sides are twice as far off: 1 m and 2 m.
        for (y, z) in [(0.98, 0.0), (0.0, 1.98)] {
            assert!(plates(0.0).hide(&Point3::new(6.0, y, z), 0.01));
        }
        for (y, z) in [(1.02, 0.0), (0.0, 2.02)] {
            assert!(!plates(0.0).hide(&Point3::new(6.0, y, z), 0.01));
            assert!(plates(0.02).hide(&Point3::new(6.0, y, z), 0.01));
        }
    }

    #[test]
    fn a_plate_along_the_line_of_sight_hides_nothing() {
        let covariance = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 1e-6));
        let mean = Point3::new(3.0, 0.0, 0.0);
        let mixture = Mixture::from_masses(vec![1.0], vec![Gaussian { mean, covariance }]);
        let floor = Plates::new(&[&mixture.expect("a mixture")], Point3::origin(), 0.01);
        assert!(!floor.hide(&Point3::new(6.0, 0.0, 0.0), 0.01));
        assert!(!floor.hide(&Point3::new(6.0, 0.0, 0.001), 0.01));
    }
}
