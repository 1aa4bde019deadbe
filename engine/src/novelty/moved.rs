//! One thing that went here and came there is one thing that moved.

use super::{Kind, Novelty};
use nalgebra::SymmetricEigen;

/// Two things are alike if neither principal width is more than this many times the other's.
const WIDTH_RATIO: f64 = 1.5;
/// The same for the thinnest width, which depends on the side that is seen.
const DEPTH_RATIO: f64 = 2.5;

/// Links each appeared novelty to the disappeared one it is most like, each at most once.
pub fn link(novelties: &mut [Novelty]) {
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    for (a, came) in novelties.iter().enumerate() {
        for (d, went) in novelties.iter().enumerate() {
            if came.kind == Kind::Appeared
                && went.kind == Kind::Disappeared
                && let Some(unlike) = unlikeness(came, went)
            {
                pairs.push((unlike, a, d));
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

/// Sum of the logarithms of the ratios of widths; `None` where they cannot be one thing.
fn unlikeness(a: &Novelty, b: &Novelty) -> Option<f64> {
    let widths = |n: &Novelty| {
        let mut w: Vec<f64> = SymmetricEigen::new(n.moments.covariance)
            .eigenvalues
            .iter()
            // A centimetre: below it, widths are noise.
            .map(|v| v.max(1e-4).sqrt())
            .collect();
        w.sort_unstable_by(f64::total_cmp);
        w
    };
    let mut sum = 0.0;
    for (axis, (x, y)) in widths(a).iter().zip(&widths(b)).enumerate() {
        let ratio = (x / y).max(y / x);
        if ratio > if axis == 0 { DEPTH_RATIO } else { WIDTH_RATIO } {
            return None;
        }
        sum += ratio.ln();
    }
    Some(sum)
}
