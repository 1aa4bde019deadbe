//! Decides which differences of weights noise and sampling explain (`docs/novelty.md section 7`).

use super::QuantifySettings;

/// The weights of one mixture's components, as Gamma states them and as both views show them. Each list sums to one.
#[derive(Debug)]
pub(super) struct WeightEvidence<'a> {
    /// Stated by Gamma.
    pub gamma: &'a [f64],
    /// Shown by the reference's own view.
    pub reference: &'a [f64],
    /// Shown by the current view.
    pub current: &'a [f64],
    /// Components whose weight Gamma states against its own view.
    pub stated: &'a [bool],
    /// Surface that one view or the other did not surely see: weights may differ by that much.
    pub unsure: &'a [f64],
    /// Surface of the component that deviates. It limits a difference: all else was seen in its place by both views.
    pub deviating: &'a [f64],
    /// Number of samples that the weights of reference and current view are worth.
    pub samples: [f64; 2],
}

impl WeightEvidence<'_> {
    /// Weights of Theta. They are Gamma's where both views show the same weight, up to what two samples of one weight differ
    /// by. The scatter of samples is measured on the components themselves (its median; neighbouring cells are not
    /// independent), so no threshold of size enters. The weights that stay Gamma's are scaled together, so that the sum is
    /// one.
    pub(super) fn theta(&self, settings: &QuantifySettings) -> Vec<f64> {
        let statistic = self.statistic();
        let mut sorted: Vec<f64> = statistic.iter().copied().filter(|s| *s > 0.0).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        // The median of chi-squared with one degree of freedom is 0.455.
        let scatter = sorted
            .get(sorted.len() / 2)
            .map_or(1.0, |m| m / 0.455)
            .max(1.0);
        let limit = settings.weight_sigmas.powi(2);
        let counts: Vec<bool> = (0..self.gamma.len())
            .map(|k| self.stated[k] || statistic[k] > limit * scatter)
            .collect();
        let mut theta = self.gamma.to_vec();
        let (mut moved, mut common) = (0.0, 0.0);
        for k in 0..theta.len() {
            if !counts[k] {
                common += theta[k];
                continue;
            }
            // Gamma decides: where it states another weight than its own view shows, the views do not limit the difference.
            theta[k] = if self.stated[k] {
                self.current[k]
            } else {
                let difference = self.current[k] - self.reference[k];
                let kept = (self.deviating[k] / difference.abs()).min(1.0);
                (theta[k] + difference * kept).max(0.0)
            };
            moved += theta[k];
        }
        if common > 0.0 {
            let scale = (1.0 - moved).max(0.0) / common;
            let settled = theta
                .iter_mut()
                .zip(&counts)
                .filter(|(_, counts)| !**counts);
            settled.for_each(|(weight, _)| *weight *= scale);
        }
        theta
    }

    /// Squared difference of what both views show, in variances of samples of one weight.
    fn statistic(&self) -> Vec<f64> {
        let [n, m] = self.samples;
        (0..self.gamma.len())
            .map(|k| {
                let pooled = (self.reference[k] * n + self.current[k] * m) / (n + m);
                // Less than one cell is no sample.
                if pooled * n.min(m) < 1.0 {
                    return 0.0;
                }
                let excess = (self.reference[k] - self.current[k]).abs() - self.unsure[k];
                excess.max(0.0).powi(2) / (pooled * (1.0 / n + 1.0 / m))
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::{QuantifySettings, WeightEvidence};
    use rand::SeedableRng;
    use rand_distr::{Binomial, Distribution};

    const SAMPLES: f64 = 20_000.0;

    /// Two samples of one mixture of 100 components.
    fn samples() -> [Vec<f64>; 2] {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let coin = Binomial::new(20_000, 0.01).expect("a share");
        std::array::from_fn(|_| {
            let counts: Vec<f64> = (0..100).map(|_| coin.sample(&mut rng) as f64).collect();
            let sum: f64 = counts.iter().sum();
            counts.iter().map(|c| c / sum).collect()
        })
    }

    /// `stated`: the component whose weight Gamma states against its view.
    fn theta(
        gamma: &[f64],
        reference: &[f64],
        current: &[f64],
        deviating: f64,
        stated: Option<usize>,
    ) -> Vec<f64> {
        let stated: Vec<bool> = (0..100).map(|k| stated == Some(k)).collect();
        WeightEvidence {
            gamma,
            reference,
            current,
            stated: &stated,
            unsure: &[0.0; 100],
            deviating: &[deviating; 100],
            samples: [SAMPLES; 2],
        }
        .theta(&QuantifySettings::default())
    }

    fn doubled(weights: &[f64], k: usize) -> Vec<f64> {
        let mut doubled = weights.to_vec();
        doubled[k] *= 2.0;
        let sum: f64 = doubled.iter().sum();
        doubled.iter().map(|w| w / sum).collect()
    }

    fn assert_near(a: &[f64], b: &[f64], tolerance: f64) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < tolerance));
    }

    #[test]
    fn samples_of_one_mixture_are_gamma() {
        let [a, b] = samples();
        assert_near(&theta(&a, &a, &b, 1.0, None), &a, 1e-15);
    }

    #[test]
    fn a_real_change_moves_its_weight_alone() {
        let [a, b] = samples();
        let b = doubled(&b, 7);
        let found = theta(&a, &a, &b, 1.0, None);
        assert!(found[7] > 1.8 * a[7]);
        assert!((found.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        // Nothing deviates, so it is no change of the scene.
        assert_near(&theta(&a, &a, &b, 0.0, None), &a, 1e-6);
    }

    #[test]
    fn a_weight_that_gamma_states_against_its_view_counts() {
        let [a, b] = samples();
        let gamma = doubled(&a, 7);
        let found = theta(&gamma, &a, &b, 0.0, Some(7));
        assert!((found[7] - b[7]).abs() < 1e-15, "{} {}", found[7], b[7]);
        assert!((found.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }
}
