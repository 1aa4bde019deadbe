//! Fewer components at the least loss: pairs are merged with their moments kept (Runnalls, IEEE T-AES 43-3, 2007).

use super::Gaussian;
use super::constants::{REGULARISATION_M2, TWIN_LOSS_NATS};
use nalgebra::{Cholesky, Matrix3};

/// One component with both of its masses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CountedComponent {
    pub gaussian: Gaussian,
    /// Above zero.
    pub beams: f64,
    pub area_m2: f64,
}

impl CountedComponent {
    /// Both as one: beams and areas add; mean and covariance are those of the beams of both.
    fn merged(&self, other: &Self) -> Self {
        let beams = self.beams + other.beams;
        let (p, q) = (self.beams / beams, other.beams / beams);
        let d = other.gaussian.mean - self.gaussian.mean;
        let within = self.gaussian.covariance * p + other.gaussian.covariance * q;
        Self {
            gaussian: Gaussian {
                mean: self.gaussian.mean + d * q,
                covariance: within + d * d.transpose() * (p * q),
            },
            beams,
            area_m2: self.area_m2 + other.area_m2,
        }
    }

    fn log_determinant(&self) -> f64 {
        let regular = self.gaussian.covariance + Matrix3::identity() * REGULARISATION_M2;
        Cholesky::new(regular).map_or(f64::INFINITY, |c| {
            2.0 * (0..3).map(|i| c.l_dirty()[(i, i)].ln()).sum::<f64>()
        })
    }
}

/// What a reduction merged.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct MergeLoss {
    /// Number of merges.
    pub merges: usize,
    /// Sum of the bounds of the losses, nats times beams.
    pub nats: f64,
}

/// Merges twins (pairs whose merging costs at most [`TWIN_LOSS_NATS`] per beam), and then the pairs of least loss until at
/// most `max` components (above zero) are left. A merged component stands where the first of the pair stood.
pub(super) fn reduce(parts: &mut Vec<CountedComponent>, max: usize) -> MergeLoss {
    let mut pairs = PairSearch::new(parts, |loss, beams| loss / beams);
    let mut loss = pairs.merge_while(parts, |_, per_beam| per_beam <= TWIN_LOSS_NATS);
    if parts.len() > max {
        let mut pairs = PairSearch::new(parts, |loss, _| loss);
        let more = pairs.merge_while(parts, |left, _| left > max);
        loss.merges += more.merges;
        loss.nats += more.nats;
    }
    loss
}

/// The best partner of every component, kept while pairs are merged.
struct PairSearch {
    log_determinants: Vec<f64>,
    /// (rank, partner) of the best pair of each component; `None` for those merged away or alone.
    best: Vec<Option<(f64, usize)>>,
    alive: Vec<bool>,
    /// The rank of a pair from its loss in nats times beams, and its beams; the least is merged first.
    rank: fn(f64, f64) -> f64,
}

impl PairSearch {
    fn new(parts: &[CountedComponent], rank: fn(f64, f64) -> f64) -> Self {
        let mut search = Self {
            log_determinants: parts
                .iter()
                .map(CountedComponent::log_determinant)
                .collect(),
            best: vec![None; parts.len()],
            alive: vec![true; parts.len()],
            rank,
        };
        for k in 0..parts.len() {
            search.best[k] = search.partner(parts, k);
        }
        search
    }

    /// Runnalls' bound of how much the mixture's KL divergence grows by merging the pair, times all beams:
    /// ((n_i + n_j) ln |S_ij| - n_i ln |S_i| - n_j ln |S_j|) / 2.
    fn loss(&self, parts: &[CountedComponent], i: usize, j: usize) -> f64 {
        let merged = parts[i].merged(&parts[j]);
        let of = |k: usize| parts[k].beams * self.log_determinants[k];
        (0.5 * (merged.beams * merged.log_determinant() - of(i) - of(j))).max(0.0)
    }

    fn partner(&self, parts: &[CountedComponent], k: usize) -> Option<(f64, usize)> {
        (0..parts.len())
            .filter(|&other| other != k && self.alive[other])
            .map(|other| (self.rank_of(parts, k, other), other))
            .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
    }

    fn rank_of(&self, parts: &[CountedComponent], i: usize, j: usize) -> f64 {
        let (i, j) = (i.min(j), i.max(j));
        (self.rank)(self.loss(parts, i, j), parts[i].beams + parts[j].beams)
    }

    /// Merges the pair of least rank while `goes_on` (components left, that rank) says so; those merged away are removed.
    fn merge_while(
        &mut self,
        parts: &mut Vec<CountedComponent>,
        goes_on: impl Fn(usize, f64) -> bool,
    ) -> MergeLoss {
        let mut done = MergeLoss::default();
        let mut left = parts.len();
        loop {
            let ranked = self.best.iter().enumerate();
            let least = ranked
                .filter_map(|(k, best)| best.map(|(rank, other)| (rank, k, other)))
                .min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((rank, a, b)) = least else { break };
            if !goes_on(left, rank) {
                break;
            }
            let (kept, gone) = (a.min(b), a.max(b));
            done.merges += 1;
            done.nats += self.loss(parts, kept, gone);
            parts[kept] = parts[kept].merged(&parts[gone]);
            self.log_determinants[kept] = parts[kept].log_determinant();
            (self.alive[gone], self.best[gone]) = (false, None);
            left -= 1;
            for k in (0..parts.len())
                .filter(|&k| self.alive[k])
                .collect::<Vec<_>>()
            {
                let stale = self.best[k].is_some_and(|(_, p)| p == kept || p == gone);
                if k == kept || stale {
                    self.best[k] = self.partner(parts, k);
                } else {
                    let rank = self.rank_of(parts, k, kept);
                    if self.best[k].is_some_and(|(best, _)| rank < best) {
                        self.best[k] = Some((rank, kept));
                    }
                }
            }
        }
        let mut alive = self.alive.iter();
        parts.retain(|_| alive.next().copied().unwrap_or(true));
        done
    }
}

#[cfg(test)]
mod tests {
    use super::{CountedComponent, reduce};
    use crate::mixture::Gaussian;
    use nalgebra::{Matrix3, Point3};

    fn ball(x: f64, beams: f64) -> CountedComponent {
        CountedComponent {
            gaussian: Gaussian {
                mean: Point3::new(x, 0.0, 0.0),
                covariance: Matrix3::identity() * 0.25,
            },
            beams,
            area_m2: 1.0,
        }
    }

    #[test]
    fn the_loss_of_a_pair_is_runnalls_bound() {
        // Two balls of variance 1/4, 1 m apart, 1 and 3 beams: the merged variance along x is 1/4 + 3/16, so the bound is
        // 4 / 2 ln (7/16 * 16/4) = 2 ln 1.75 nats; (1 mm)^2 on every variance changes it in the fifth digit.
        let mut parts = vec![ball(0.0, 1.0), ball(1.0, 3.0)];
        let loss = reduce(&mut parts, 1);
        assert!((loss.nats - 2.0 * 1.75f64.ln()).abs() < 1e-5, "{loss:?}");
        assert_eq!((loss.merges, parts.len()), (1, 1));
        assert!((parts[0].gaussian.mean.x - 0.75).abs() < 1e-15);
        assert!((parts[0].gaussian.covariance[(0, 0)] - 0.4375).abs() < 1e-15);
        assert_eq!((parts[0].beams, parts[0].area_m2), (4.0, 2.0));
    }

    #[test]
    fn the_cheapest_pairs_go_first_and_twins_always() {
        let mut parts = vec![
            ball(0.0, 1.0),
            ball(5.0, 2.0),
            ball(0.4, 1.0),
            ball(5.0, 1.0),
            ball(9.0, 1.0),
        ];
        let loss = reduce(&mut parts.clone(), 5);
        assert_eq!(loss.merges, 1);
        assert!(loss.nats < 1e-9);
        reduce(&mut parts, 3);
        let means: Vec<f64> = parts.iter().map(|p| p.gaussian.mean.x).collect();
        assert_eq!(means, [0.2, 5.0, 9.0]);
        assert_eq!(parts[1].beams, 3.0);
    }
}
