//! Links a novelty that appeared to the one that disappeared if both are the same object.

use super::{Novelty, NoveltyKind};
use nalgebra::SymmetricEigen;

/// Largest ratio of principal widths of the same object.
const MAX_WIDTH_RATIO: f64 = 1.5;
/// The same for the smallest width, which depends on the side that is seen.
const MAX_DEPTH_RATIO: f64 = 2.5;

/// Links each appeared novelty to the most similar disappeared one, each at most once.
pub(super) fn link(novelties: &mut [Novelty]) {
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    for (a, appeared) in novelties.iter().enumerate() {
        for (d, disappeared) in novelties.iter().enumerate() {
            if appeared.kind == NoveltyKind::Appeared
                && disappeared.kind == NoveltyKind::Disappeared
                && let Some(difference) = dissimilarity(appeared, disappeared)
            {
                pairs.push((difference, a, d));
            }
        }
    }
    pairs.sort_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))));
    let mut taken = vec![false; novelties.len()];
    for (_, a, d) in pairs {
        if !taken[a] && !taken[d] {
            taken[a] = true;
            taken[d] = true;
            novelties[a].moved_from = Some(d);
        }
    }
}

/// Sum of the logarithms of the ratios of widths; `None` if they cannot be the same object.
fn dissimilarity(a: &Novelty, b: &Novelty) -> Option<f64> {
    let widths = |n: &Novelty| {
        let mut w: Vec<f64> = SymmetricEigen::new(n.moments.covariance)
            .eigenvalues
            .iter()
            // One centimetre: below it, widths are noise.
            .map(|v| v.max(1e-4).sqrt())
            .collect();
        w.sort_unstable_by(f64::total_cmp);
        w
    };
    let mut sum = 0.0;
    for (axis, (x, y)) in widths(a).iter().zip(&widths(b)).enumerate() {
        let ratio = (x / y).max(y / x);
        if ratio
            > if axis == 0 {
                MAX_DEPTH_RATIO
            } else {
                MAX_WIDTH_RATIO
            }
        {
            return None;
        }
        sum += ratio.ln();
    }
    Some(sum)
}
