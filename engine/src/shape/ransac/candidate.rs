//! Candidates and what is known of their scores (Schnabel section 4.5).

use super::constants::{SCORE_SIGMAS, USABLE_SETS};
use super::surface::Surface;

/// A surface, scored on the first `seen` points of a random order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Candidate {
    pub surface: Surface,
    /// Octree level that its points came from.
    pub level: u32,
    pub seen: usize,
    pub hits: usize,
    /// Whether it was already fitted to points of the sample.
    pub polished: bool,
}

impl Candidate {
    pub fn new(surface: Surface, level: u32) -> Self {
        Self {
            surface,
            level,
            seen: 0,
            hits: 0,
            polished: false,
        }
    }

    /// Expected share of all `n` points that lie on it, and the half-width of its interval: the
    /// hypergeometric distribution of the hits among those seen.
    pub fn share(&self, n: usize) -> (f64, f64) {
        let (n, seen, hits) = (n as f64, self.seen as f64, self.hits as f64);
        if seen >= n {
            return (hits / n.max(1.0), 0.0);
        }
        // Laplace's estimate: no hits among few points are no proof that there are none.
        let share = (hits + 1.0) / (seen + 2.0);
        let unseen = (n - seen) / (n - 1.0).max(1.0);
        let spread = (share * (1.0 - share) / (seen + 2.0) * unseen).sqrt();
        (hits / seen.max(1.0), SCORE_SIGMAS * spread)
    }

    /// What its share may well be.
    pub fn upper(&self, n: usize) -> f64 {
        let (expected, spread) = self.share(n);
        expected + spread
    }
}

/// Probability that one draw of three points hits a primitive that holds `share` of them
/// (Schnabel section 4.3 with k = 3): the first point lies on it, the level is the right one, in a
/// cell of that level half of the points are its own, and noise leaves the set of use.
pub(super) fn chance(share: f64, levels: u32) -> f64 {
    (USABLE_SETS * share / (4.0 * f64::from(levels))).clamp(0.0, 1.0)
}

/// Probability that `draws` draws found what one draw finds with probability `chance`.
pub(super) fn found(chance: f64, draws: usize) -> f64 {
    1.0 - (1.0 - chance).powf(draws as f64)
}

#[cfg(test)]
mod tests {
    use super::{Candidate, chance, found};
    use crate::shape::ransac::surface::Surface;
    use nalgebra::Vector3;

    fn candidate(seen: usize, hits: usize) -> Candidate {
        let surface = Surface::Sphere {
            centre: Vector3::zeros(),
            radius_m: 1.0,
        };
        Candidate {
            seen,
            hits,
            ..Candidate::new(surface, 0)
        }
    }

    #[test]
    fn scores_narrow_as_more_is_seen_and_are_exact_in_the_end() {
        let widths: Vec<f64> = [64, 256, 1024, 4096]
            .iter()
            .map(|&seen| candidate(seen, seen / 4).share(4096))
            .map(|(share, width)| {
                assert!((share - 0.25).abs() < 1e-12);
                width
            })
            .collect();
        assert!(widths.windows(2).all(|w| w[1] < w[0]), "{widths:?}");
        assert_eq!(widths[3], 0.0);
        // Hypergeometric: sqrt(.25 * .75 / 256 * 3840 / 4095) to first order.
        assert!((widths[1] - 0.0262).abs() < 3e-4, "{widths:?}");
        assert!(candidate(64, 0).upper(4096) > 0.01);
    }

    #[test]
    fn larger_primitives_are_found_in_fewer_draws() {
        // A set of three points on half of the points, in one cell size: 1/8 of the draws, a
        // quarter of them of use; 1 - (1 - 1/32)^n >= .99 from n = 146 on.
        assert_eq!(chance(0.5, 1), 0.125 * 0.25);
        assert!(found(1.0 / 32.0, 145) < 0.99 && found(1.0 / 32.0, 146) > 0.99);
        assert_eq!(found(0.0, 1000), 0.0);
    }
}
