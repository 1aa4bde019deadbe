//! Splits a Gaussian in two so that mass, mean and covariance of both together are its own.

use super::super::constants::MAX_SPLIT_SHARE;
use crate::mixture::Gaussian;
use crate::mixture::linalg::Eigen;
use nalgebra::Vector3;

/// Takes a part with the share `share` of the mass and about the moments `part` out of `whole`: the part and the rest. The
/// part is drawn towards the mean of the whole as far as is needed to leave the rest a volume. Where next to nothing would be
/// left, the part is the whole, and there is no rest.
pub(super) fn split_component(
    whole: &Gaussian,
    part: &Gaussian,
    share: f64,
) -> (Gaussian, Option<Gaussian>) {
    if share >= MAX_SPLIT_SHARE {
        return (*whole, None);
    }
    let offset = part.mean - whole.mean;
    // Sigma = f S + (1 - f) R + f / (1 - f) d d^T, with S and R the covariances of part and rest, d the offset of the part.
    let claimed = part.covariance * share + offset * offset.transpose() * (share / (1.0 - share));
    let whitener = Eigen::new(&whole.covariance).map(|v| 1.0 / v.max(f64::MIN_POSITIVE).sqrt());
    let largest = Eigen::new(&(whitener * claimed * whitener.transpose())).values[2];
    let scale = (MAX_SPLIT_SHARE / largest.max(f64::MIN_POSITIVE)).min(1.0);
    let offset: Vector3<f64> = offset * scale.sqrt();
    let taken = Gaussian {
        mean: whole.mean + offset,
        covariance: part.covariance * scale,
    };
    let rest = Gaussian {
        mean: whole.mean - offset * (share / (1.0 - share)),
        covariance: (whole.covariance - claimed * scale) / (1.0 - share),
    };
    (taken, Some(rest))
}

#[cfg(test)]
mod tests {
    use super::split_component;
    use crate::mixture::linalg::Eigen;
    use crate::mixture::{Gaussian, Mixture};
    use nalgebra::{Matrix3, Point3, Vector3};
    use proptest::prelude::*;

    fn gaussian(mean: [f64; 3], sides: [f64; 3], shear: f64) -> Gaussian {
        let root = Matrix3::new(
            sides[0], shear, 0.0, 0.0, sides[1], shear, 0.0, 0.0, sides[2],
        );
        Gaussian {
            mean: Point3::from(mean),
            covariance: root * root.transpose(),
        }
    }

    proptest! {
        #[test]
        fn mass_mean_and_covariance_are_kept(
            at in prop::array::uniform3(-1.0..1.0_f64),
            sides in prop::array::uniform3(0.01..1.0_f64),
            part_sides in prop::array::uniform3(0.001..1.0_f64),
            shear in -0.3..0.3_f64,
            share in 0.001..0.97_f64,
        ) {
            let whole = gaussian([5.0, -2.0, 1.0], sides, shear);
            let mut part = gaussian([0.0; 3], part_sides, -shear);
            part.mean = whole.mean + Vector3::from(at);
            let (taken, rest) = split_component(&whole, &part, share);
            let rest = rest.expect("a rest");
            let both = Mixture {
                weights: vec![share, 1.0 - share],
                components: vec![taken, rest],
            };
            let joined = both.total_moments().expect("mass");
            prop_assert!((joined.mean - whole.mean).norm() < 1e-12);
            prop_assert!((joined.covariance - whole.covariance).norm() < 1e-12);
            for g in [taken, rest] {
                prop_assert!(Eigen::new(&g.covariance).values[0] >= -1e-12);
            }
        }
    }

    #[test]
    fn a_part_that_fits_keeps_its_moments() {
        let whole = gaussian([0.0; 3], [0.4, 0.4, 0.02], 0.0);
        let part = gaussian([0.3, 0.0, 0.0], [0.1, 0.2, 0.01], 0.0);
        let (taken, _) = split_component(&whole, &part, 0.3);
        assert!((taken.mean - part.mean).norm() < 1e-12);
        assert!((taken.covariance - part.covariance).norm() < 1e-12);
        assert_eq!(split_component(&whole, &part, 0.98), (whole, None));
        assert!(split_component(&whole, &part, 0.979).1.is_some());
    }
}
