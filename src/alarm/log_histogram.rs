//! Counts of distances in bins of equal ratio, in fixed memory. Distances span many powers of ten, and zero is one of them.

use super::constants::{BINS_PER_DECADE, HISTOGRAM_DECADES, HISTOGRAM_FROM};

/// Counts of numbers from zero up.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LogHistogram {
    /// Below the first edge, between edges, from the last edge on.
    counts: Vec<u64>,
}

/// One bin with its count: `from <= x < to`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HistogramBin {
    /// Lower edge; 0 for the first.
    pub from: f64,
    /// Upper edge; infinite for the last.
    pub to: f64,
    /// Numbers in it.
    pub count: u64,
}

impl Default for LogHistogram {
    fn default() -> Self {
        Self {
            counts: vec![0; BINS_PER_DECADE * HISTOGRAM_DECADES + 2],
        }
    }
}

impl LogHistogram {
    /// Counts a number; what is not finite is left out.
    pub fn add(&mut self, x: f64) {
        if x.is_finite() {
            // Its bin is the last whose lower edge it reaches.
            let (mut low, mut high) = (0, self.counts.len());
            while high - low > 1 {
                let middle = low.midpoint(high);
                if x >= lower_edge(middle) {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            self.counts[low] += 1;
        }
    }

    /// Numbers counted.
    pub fn total(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// The least bin edge that at most the share `rate` of the numbers, and of one more that is as they are, reaches; `None`
    /// without numbers.
    pub fn edge_exceeded_by(&self, rate: f64) -> Option<f64> {
        let total = self.total();
        if total == 0 {
            return None;
        }
        // One more visit ranks anywhere among them with the same chance.
        let allowed = (rate * (total + 1) as f64 - 1.0).max(0.0).floor() as u64;
        let mut above = 0;
        for (bin, count) in self.counts.iter().enumerate().rev() {
            above += count;
            if above > allowed {
                let edge = lower_edge(bin + 1);
                return (bin + 1 < self.counts.len()).then_some(edge);
            }
        }
        None
    }

    /// Bins of `per_decade` per power of ten from the first to the last that is not empty, and the one from zero.
    pub fn bins(&self, per_decade: usize) -> Vec<HistogramBin> {
        let merged = (BINS_PER_DECADE / per_decade.max(1)).max(1);
        let inner = self.counts.len() - 2;
        let mut bins = vec![HistogramBin {
            from: 0.0,
            to: lower_edge(1),
            count: self.counts[0],
        }];
        for first in (1..=inner).step_by(merged) {
            let end = (first + merged).min(inner + 1);
            bins.push(HistogramBin {
                from: lower_edge(first),
                to: lower_edge(end),
                count: self.counts[first..end].iter().sum(),
            });
        }
        bins.push(HistogramBin {
            from: lower_edge(inner + 1),
            to: f64::INFINITY,
            count: self.counts[inner + 1],
        });
        bins
    }
}

fn lower_edge(bin: usize) -> f64 {
    if bin == 0 {
        return 0.0;
    }
    let (decade, step) = ((bin - 1) / BINS_PER_DECADE, (bin - 1) % BINS_PER_DECADE);
    let within = 10f64.powf(step as f64 / BINS_PER_DECADE as f64);
    HISTOGRAM_FROM * 10f64.powi(decade as i32) * within
}

#[cfg(test)]
mod tests {
    use super::LogHistogram;
    use proptest::prelude::*;

    fn filled(numbers: &[f64]) -> LogHistogram {
        let mut histogram = LogHistogram::default();
        numbers.iter().for_each(|x| histogram.add(*x));
        histogram
    }

    #[test]
    fn what_is_not_finite_is_left_out() {
        assert_eq!(filled(&[f64::NAN, f64::INFINITY]).total(), 0);
        assert_eq!(filled(&[]).edge_exceeded_by(0.1), None);
        assert_eq!(
            filled(&[1e30]).edge_exceeded_by(0.0),
            None,
            "above all edges"
        );
    }

    proptest! {
        #[test]
        fn every_number_is_in_its_bin(
            numbers in prop::collection::vec((-9.0..4.0f64).prop_map(|e| 10f64.powf(e)), 0..60),
            zeros in 0usize..5, per_decade in 1usize..20,
        ) {
            let all: Vec<f64> = numbers.into_iter().chain(std::iter::repeat_n(0.0, zeros)).collect();
            let bins = filled(&all).bins(per_decade);
            prop_assert!(bins.windows(2).all(|pair| pair[0].to == pair[1].from));
            for bin in bins {
                let inside = all.iter().filter(|x| (bin.from..bin.to).contains(*x)).count();
                prop_assert_eq!(inside as u64, bin.count, "{:?}", bin);
            }
        }

        #[test]
        fn at_most_the_share_reaches_the_edge_and_more_than_it_the_edge_below(
            numbers in prop::collection::vec((-6.0..0.0f64).prop_map(|e| 10f64.powf(e)), 1..80),
            rate in 0.0..0.9f64,
        ) {
            let edge = filled(&numbers).edge_exceeded_by(rate).expect("within the edges");
            let reached = |u: f64| numbers.iter().filter(|x| **x >= u).count() as f64;
            let among = (numbers.len() + 1) as f64;
            prop_assert!(reached(edge) == 0.0 || reached(edge) + 1.0 <= rate * among + 1e-9);
            let below = edge / 10f64.powf(1.0 / super::BINS_PER_DECADE as f64) * (1.0 - 1e-9);
            prop_assert!(reached(below) + 1.0 > rate * among - 1.0);
        }
    }
}
