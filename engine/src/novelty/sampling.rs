//! Weights of one scene, seen twice, differ: when is that more than the sampling?

use super::QuantifySettings;

/// Where two weights of a component differ by no more than two samples of one and the same weight
/// would, both take their common value. The scatter of samples is measured on the components
/// themselves (its median; neighbouring cells are not independent), so that no threshold of size enters. `unsure` is
/// surface that one view or the other did not surely see: visible weights may differ by that much. No difference is
/// larger than the surface of the component that deviates: all else was seen in its place by both views.
pub fn explained_by_sampling(
    weights: [Vec<f64>; 2],
    unsure: &[f64],
    deviating: &[f64],
    masses: [f64; 2],
    settings: &QuantifySettings,
) -> [Vec<f64>; 2] {
    let [mut then, mut now] = weights;
    let pooled: Vec<f64> = then
        .iter()
        .zip(&now)
        .map(|(a, b)| (a * masses[0] + b * masses[1]) / (masses[0] + masses[1]))
        .collect();
    let square: Vec<f64> = (0..then.len())
        .map(|k| {
            let variance = pooled[k] * (1.0 / masses[0] + 1.0 / masses[1]);
            // Less than one cell is no sample.
            if pooled[k] * masses[0].min(masses[1]) < 1.0 {
                0.0
            } else {
                let beyond = (then[k] - now[k]).abs() - unsure[k];
                beyond.max(0.0).powi(2) / variance
            }
        })
        .collect();
    let mut sorted: Vec<f64> = square.iter().copied().filter(|s| *s > 0.0).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    // The median of chi-squared with one degree of freedom is 0.455.
    let scatter = sorted
        .get(sorted.len() / 2)
        .map_or(1.0, |m| m / 0.455)
        .max(1.0);
    let limit = settings.weight_sigmas.powi(2) * scatter;
    let mut excess = [0.0; 2];
    let mut common = 0.0;
    for k in 0..pooled.len() {
        let difference = (then[k] - now[k]).abs();
        if square[k] > limit && deviating[k] < difference {
            let believed = deviating[k] / difference;
            then[k] = pooled[k] + believed * (then[k] - pooled[k]);
            now[k] = pooled[k] + believed * (now[k] - pooled[k]);
        }
        if square[k] <= limit {
            then[k] = pooled[k];
            now[k] = pooled[k];
            common += pooled[k];
        } else {
            excess[0] += then[k];
            excess[1] += now[k];
        }
    }
    for (side, weights) in [&mut then, &mut now].into_iter().enumerate() {
        let left = 1.0 - excess[side];
        for (weight, s) in weights.iter_mut().zip(&square) {
            if *s <= limit && common > 0.0 {
                *weight *= left / common;
            }
        }
    }
    [then, now]
}

#[cfg(test)]
mod tests {
    use super::{QuantifySettings, explained_by_sampling};
    use rand::SeedableRng;
    use rand_distr::{Binomial, Distribution};

    #[test]
    fn samples_of_one_mixture_count_as_equal_and_a_real_change_does_not() {
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
        let [then, now] = explained_by_sampling(
            [a.clone(), b.clone()],
            &[0.0; 100],
            &[1.0; 100],
            [n, n],
            &settings,
        );
        assert!(then.iter().zip(&now).all(|(t, n)| (t - n).abs() < 1e-15));
        b[7] *= 2.0;
        let sum: f64 = b.iter().sum();
        b.iter_mut().for_each(|w| *w /= sum);
        let [then, now] = explained_by_sampling(
            [a.clone(), b.clone()],
            &[0.0; 100],
            &[1.0; 100],
            [n, n],
            &settings,
        );
        assert!(now[7] > 1.8 * then[7]);
        assert!((now.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        // Nothing deviates: whatever it is, it is no change of the scene.
        let [then, now] =
            explained_by_sampling([a, b], &[0.0; 100], &[0.0; 100], [n, n], &settings);
        assert!(then.iter().zip(&now).all(|(t, n)| (t - n).abs() < 1e-6));
    }
}
