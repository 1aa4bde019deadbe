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

/// The value that one more draw of the same kind exceeds with probability 1 - `share`: of n sorted values the one at
/// position `share` (n + 1), interpolated (Hyndman and Fan's type 6, R's `quantile(x, share, type = 6)`); the greatest
/// where n is too small for the share. `None` of none.
pub(crate) fn quantile_of_next(values: impl IntoIterator<Item = f64>, share: f64) -> Option<f64> {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    let (first, last) = (*values.first()?, *values.last()?);
    let position = share * (values.len() + 1) as f64;
    let below = position.floor();
    let at = |nth: f64| match nth as usize {
        0 => first,
        nth => values.get(nth - 1).copied().unwrap_or(last),
    };
    let (low, high) = (at(below), at(below + 1.0));
    Some(low + (position - below) * (high - low))
}

/// Area under the receiver operating characteristic: the probability that one of `high` exceeds one of `low`, ties by half.
/// `None` where either is empty.
pub(crate) fn area_under_curve(low: &[f64], high: &[f64]) -> Option<f64> {
    let mut sorted = low.to_vec();
    sorted.sort_by(f64::total_cmp);
    let wins = high.iter().map(|h| {
        let below = sorted.partition_point(|l| l < h);
        let not_above = sorted.partition_point(|l| l <= h);
        f64::midpoint(below as f64, not_above as f64)
    });
    let pairs = low.len() * high.len();
    (pairs > 0).then(|| wins.sum::<f64>() / pairs as f64)
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
    use super::{Rate, area_under_curve, mean, quantile, quantile_of_next};

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
    fn one_more_draw_exceeds_the_quantile_with_the_rest_of_the_probability() {
        // R: quantile(1:20, c(.95, .5, .01), type = 6) and quantile(c(2, 7, 1), c(.95, .6), type = 6).
        let close = |values: &[f64], share: f64, expected: f64| {
            let found = quantile_of_next(values.iter().copied(), share).expect("values");
            assert!((found - expected).abs() < 1e-12, "{share}: {found}");
        };
        let twenty: Vec<f64> = (1..=20).map(f64::from).collect();
        close(&twenty, 0.95, 19.95);
        close(&twenty, 0.5, 10.5);
        close(&twenty, 0.01, 1.0);
        close(&[2.0, 7.0, 1.0], 0.95, 7.0);
        close(&[2.0, 7.0, 1.0], 0.6, 4.0);
        assert_eq!(quantile_of_next([], 0.5), None);
    }

    #[test]
    fn the_area_under_the_curve_counts_ordered_pairs() {
        // Of six pairs four are in order and two are ties.
        let area = area_under_curve(&[1.0, 2.0, 2.0], &[3.0, 2.0]).expect("both");
        assert!((area - 5.0 / 6.0).abs() < 1e-12, "{area}");
        assert_eq!(area_under_curve(&[1.0], &[0.0]), Some(0.0));
        assert_eq!(area_under_curve(&[1.0], &[]), None);
        assert_eq!(area_under_curve(&[], &[1.0]), None);
    }

    #[test]
    fn quantiles_and_means() {
        assert_eq!(quantile([3.0, 1.0, 2.0], 0.5), Some(2.0));
        assert_eq!(quantile([], 0.5), None);
        assert_eq!(mean([1.0, 2.0]), Some(1.5));
        assert_eq!(mean([]), None);
    }
}
