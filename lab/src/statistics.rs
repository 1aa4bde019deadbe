//! Rates with confidence intervals, quantiles and means.

use serde::Serialize;

/// Normal quantile of a two-sided 95 % interval.
const Z: f64 = 1.959_963_984_540_054;

/// A share with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Rate {
    /// Successes.
    pub count: usize,
    /// Trials.
    pub of: usize,
    /// `count` / `of`; 0 of none.
    pub rate: f64,
    /// Lower end of the Wilson score interval.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
}

impl Rate {
    /// `count` of `of`, with the Wilson score interval (no continuity correction).
    pub fn new(count: usize, of: usize) -> Self {
        if of == 0 {
            return Self {
                count,
                of,
                rate: 0.0,
                low: 0.0,
                high: 1.0,
            };
        }
        let n = of as f64;
        let p = count as f64 / n;
        let z2 = Z * Z;
        let middle = (p + z2 / (2.0 * n)) / (1.0 + z2 / n);
        let half = Z / (1.0 + z2 / n) * (p * (1.0 - p) / n + z2 / (4.0 * n * n)).sqrt();
        Self {
            count,
            of,
            rate: p,
            low: if count == 0 {
                0.0
            } else {
                (middle - half).max(0.0)
            },
            high: if count == of {
                1.0
            } else {
                (middle + half).min(1.0)
            },
        }
    }
}

/// The value below which this share of them lies; `None` of none.
pub(crate) fn quantile(values: impl IntoIterator<Item = f64>, share: f64) -> Option<f64> {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    values.get((share * last as f64).round() as usize).copied()
}

/// The median, of two in the middle the upper; `None` of none.
pub(crate) fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    quantile(values, 0.5)
}

/// The mean; `None` of none.
pub(crate) fn mean(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (sum, n) = values
        .into_iter()
        .fold((0.0, 0usize), |(sum, n), v| (sum + v, n + 1));
    (n > 0).then(|| sum / n as f64)
}

/// The root mean square; `None` of none.
pub(crate) fn rms(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    mean(values.into_iter().map(|v| v * v)).map(f64::sqrt)
}

#[cfg(test)]
mod tests {
    use super::{Rate, mean, quantile};

    #[test]
    fn intervals_are_wilson_score_intervals() {
        // Roots of |count / of - q| = z sqrt(q (1 - q) / of), found by bisection.
        for (count, of, low, high) in [
            (0, 10, 0.0, 0.277_533),
            (5, 10, 0.236_593, 0.763_407),
            (1, 100, 0.001_767, 0.054_486),
            (98, 100, 0.929_988, 0.994_498),
            (10, 10, 0.722_467, 1.0),
        ] {
            let rate = Rate::new(count, of);
            assert!((rate.low - low).abs() < 1e-5, "{rate:?}");
            assert!((rate.high - high).abs() < 1e-5, "{rate:?}");
        }
        assert_eq!((Rate::new(0, 0).low, Rate::new(0, 0).high), (0.0, 1.0));
    }

    #[test]
    fn quantiles_and_means() {
        assert_eq!(quantile([3.0, 1.0, 2.0], 0.5), Some(2.0));
        assert_eq!(quantile([], 0.5), None);
        assert_eq!(mean([1.0, 2.0]), Some(1.5));
        assert_eq!(mean([]), None);
    }
}
