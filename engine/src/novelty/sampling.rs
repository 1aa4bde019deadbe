//! Decides which differences of weights sampling alone explains (`docs/novelty.md section 7`).

use super::QuantifySettings;

/// Sets the two weights of a component to their common value where they differ by no more than two samples of one weight
/// would. The scatter of samples is measured on the components themselves (its median; neighbouring cells are not
/// independent), so no threshold of size enters.
///
/// `unsure` is surface that one view or the other did not surely see: weights may differ by that much. `deviating` limits a
/// difference to the surface of the component that deviates: all else was seen in its place by both views. `samples` is the
/// number of samples of each side.
pub(super) fn explained_by_sampling(
    weights: [Vec<f64>; 2],
    unsure: &[f64],
    deviating: &[f64],
    samples: [f64; 2],
    settings: &QuantifySettings,
) -> [Vec<f64>; 2] {
    let [mut reference, mut current] = weights;
    let pooled: Vec<f64> = reference
        .iter()
        .zip(&current)
        .map(|(a, b)| (a * samples[0] + b * samples[1]) / (samples[0] + samples[1]))
        .collect();
    let statistic: Vec<f64> = (0..reference.len())
        .map(|k| {
            let variance = pooled[k] * (1.0 / samples[0] + 1.0 / samples[1]);
            // Less than one cell is no sample.
            if pooled[k] * samples[0].min(samples[1]) < 1.0 {
                0.0
            } else {
                let excess = (reference[k] - current[k]).abs() - unsure[k];
                excess.max(0.0).powi(2) / variance
            }
        })
        .collect();
    let mut sorted: Vec<f64> = statistic.iter().copied().filter(|s| *s > 0.0).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    // The median of chi-squared with one degree of freedom is 0.455.
    let scatter = sorted
        .get(sorted.len() / 2)
        .map_or(1.0, |m| m / 0.455)
        .max(1.0);
    let limit = settings.weight_sigmas.powi(2) * scatter;
    let mut remaining = [0.0; 2];
    let mut common = 0.0;
    for k in 0..pooled.len() {
        let difference = (reference[k] - current[k]).abs();
        if statistic[k] > limit && deviating[k] < difference {
            let kept = deviating[k] / difference;
            reference[k] = pooled[k] + kept * (reference[k] - pooled[k]);
            current[k] = pooled[k] + kept * (current[k] - pooled[k]);
        }
        if statistic[k] <= limit {
            reference[k] = pooled[k];
            current[k] = pooled[k];
            common += pooled[k];
        } else {
            remaining[0] += reference[k];
            remaining[1] += current[k];
        }
    }
    for (side, weights) in [&mut reference, &mut current].into_iter().enumerate() {
        let left = 1.0 - remaining[side];
        for (weight, s) in weights.iter_mut().zip(&statistic) {
            if *s <= limit && common > 0.0 {
                *weight *= left / common;
            }
        }
    }
    [reference, current]
}

#[cfg(test)]
mod tests {
    use super::{QuantifySettings, explained_by_sampling};
    use rand::SeedableRng;
    use rand_distr::{Binomial, Distribution};

    #[test]
    fn samples_of_one_mixture_become_equal_and_a_real_change_stays() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let n = 20_000.0;
        let coin = Binomial::new(20_000, 0.01).expect("a share");
        let mut sample = || -> Vec<f64> {
            let counts: Vec<f64> = (0..100).map(|_| coin.sample(&mut rng) as f64).collect();
            let sum: f64 = counts.iter().sum();
            counts.iter().map(|c| c / sum).collect()
        };
        let (a, mut b) = (sample(), sample());
        let settings = QuantifySettings::default();
        let [reference, current] = explained_by_sampling(
            [a.clone(), b.clone()],
            &[0.0; 100],
            &[1.0; 100],
            [n, n],
            &settings,
        );
        assert!(
            reference
                .iter()
                .zip(&current)
                .all(|(a, b)| (a - b).abs() < 1e-15)
        );
        b[7] *= 2.0;
        let sum: f64 = b.iter().sum();
        b.iter_mut().for_each(|w| *w /= sum);
        let [reference, current] = explained_by_sampling(
            [a.clone(), b.clone()],
            &[0.0; 100],
            &[1.0; 100],
            [n, n],
            &settings,
        );
        assert!(current[7] > 1.8 * reference[7]);
        assert!((current.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        // Nothing deviates, so it is no change of the scene.
        let [reference, current] =
            explained_by_sampling([a, b], &[0.0; 100], &[0.0; 100], [n, n], &settings);
        assert!(
            reference
                .iter()
                .zip(&current)
                .all(|(a, b)| (a - b).abs() < 1e-6)
        );
    }
}
