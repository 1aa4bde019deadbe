//! Candidates and the confidence intervals of their scores (Schnabel section 4.5).

use super::constants::{SCORE_SIGMAS, USABLE_SET_SHARE};
use super::surface::UnboundedSurface;

/// A surface, scored on the first `scored` points of the sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SurfaceCandidate {
    pub surface: UnboundedSurface,
    /// Octree level of the cell that its points were drawn from.
    pub level: u32,
    pub scored: usize,
    pub inliers: usize,
    /// Whether it was fitted to points of the sample.
    pub polished: bool,
}

impl SurfaceCandidate {
    pub(super) fn new(surface: UnboundedSurface, level: u32) -> Self {
        Self {
            surface,
            level,
            scored: 0,
            inliers: 0,
            polished: false,
        }
    }

    /// Expected share of all `n` points on it, and the half width of its interval (hypergeometric).
    pub(super) fn share(&self, n: usize) -> (f64, f64) {
        let (n, scored, inliers) = (n as f64, self.scored as f64, self.inliers as f64);
        if scored >= n {
            return (inliers / n.max(1.0), 0.0);
        }
        // Rule of succession: no inliers among few points do not prove that there are none.
        let share = (inliers + 1.0) / (scored + 2.0);
        let unseen = (n - scored) / (n - 1.0).max(1.0);
        let spread = (share * (1.0 - share) / (scored + 2.0) * unseen).sqrt();
        (inliers / scored.max(1.0), SCORE_SIGMAS * spread)
    }

    /// Upper end of that interval.
    pub(super) fn upper_share(&self, n: usize) -> f64 {
        let (expected, spread) = self.share(n);
        expected + spread
    }
}

/// Probability that one draw of three points finds a primitive with this `share` of the points (Schnabel section 4.3 with
/// k = 3): the first point is on it, the level is the right one, half of the points in the cell are on it, and the noise
/// leaves the set usable.
pub(super) fn hit_probability(share: f64, levels: u32) -> f64 {
    (USABLE_SET_SHARE * share / (4.0 * f64::from(levels))).clamp(0.0, 1.0)
}

/// Probability that `draws` draws find what one draw finds with `hit_probability`.
pub(super) fn detection_probability(hit_probability: f64, draws: usize) -> f64 {
    1.0 - (1.0 - hit_probability).powf(draws as f64)
}

#[cfg(test)]
mod tests {
    use super::{SurfaceCandidate, detection_probability, hit_probability};
    use crate::shape::ransac::surface::UnboundedSurface;
    use nalgebra::Vector3;

    fn candidate(scored: usize, inliers: usize) -> SurfaceCandidate {
        let surface = UnboundedSurface::Sphere {
            centre: Vector3::zeros(),
            radius_m: 1.0,
        };
        SurfaceCandidate {
            scored,
            inliers,
            ..SurfaceCandidate::new(surface, 0)
        }
    }

    #[test]
    fn intervals_narrow_as_more_points_are_scored_and_vanish_in_the_end() {
        let widths: Vec<f64> = [64, 256, 1024, 4096]
            .iter()
            .map(|&scored| candidate(scored, scored / 4).share(4096))
            .map(|(share, width)| {
                assert!((share - 0.25).abs() < 1e-12);
                width
            })
            .collect();
        assert!(widths.windows(2).all(|w| w[1] < w[0]), "{widths:?}");
        assert_eq!(widths[3], 0.0);
        // Hypergeometric: sqrt(.25 * .75 / 256 * 3840 / 4095) to first order.
        assert!((widths[1] - 0.0262).abs() < 3e-4, "{widths:?}");
        assert!(candidate(64, 0).upper_share(4096) > 0.01);
    }

    #[test]
    fn larger_primitives_are_found_in_fewer_draws() {
        // Half of the points on the primitive and one level: 1/8 of the draws, a quarter of them usable;
        // 1 - (1 - 1/32)^n >= .99 from n = 146 on.
        assert_eq!(hit_probability(0.5, 1), 0.125 * 0.25);
        assert!(
            detection_probability(1.0 / 32.0, 145) < 0.99
                && detection_probability(1.0 / 32.0, 146) > 0.99
        );
        assert_eq!(detection_probability(0.0, 1000), 0.0);
    }
}
