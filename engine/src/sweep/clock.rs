//! Offset and rate of the sensor's clock against the host's (sweep-geometry section 3).

use super::constants::{MAX_RATE_ERROR, MIN_RATE_SPAN_S, STAMP_ROUNDING_S};
use super::raw::{StampedScan, TimeSample};

/// `host_s = anchor_host_s + rate (sensor_s - anchor_sensor_s)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SensorClock {
    anchor_host_s: f64,
    anchor_sensor_s: f64,
    /// Host seconds per sensor second.
    pub(super) rate: f64,
    /// Bound of the error of the offset, seconds: half the shortest round trip.
    pub(super) uncertainty_s: f64,
}

/// Why no clock can be fitted.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ClockError {
    /// No exchange of time.
    #[error("no time exchange with the laser was answered")]
    NoSamples,
    /// The rates of the two clocks differ too much.
    #[error("laser clock runs at {0:.4} of the host's, expected within 1.3 % of it")]
    Rate(f64),
    /// A scan arrived before it was measured.
    #[error("a scan arrived {0:.3} s before its start by the laser clock")]
    EarlyScan(f64),
}

impl SensorClock {
    /// Fits offset and rate. The offset is that of the exchange with the shortest round trip. The rate comes from it and the
    /// best exchange at the other end of the sweep, else from the arrivals of the scans (lower envelope, Olson 2010).
    ///
    /// # Errors
    /// No exchange, an impossible rate, or scans that contradict it.
    pub(super) fn fit(samples: &[TimeSample], scans: &[StampedScan]) -> Result<Self, ClockError> {
        let width = |s: &&TimeSample| s.received_s - s.sent_s;
        let best = |group: &mut dyn Iterator<Item = &TimeSample>| -> Option<TimeSample> {
            group.min_by(|a, b| width(a).total_cmp(&width(b))).copied()
        };
        let anchor = best(&mut samples.iter()).ok_or(ClockError::NoSamples)?;
        let far = |s: &&TimeSample| (sensor_s(s) - sensor_s(&anchor)).abs() >= MIN_RATE_SPAN_S;
        let rate = match best(&mut samples.iter().filter(far)) {
            Some(other) => {
                (middle_s(&other) - middle_s(&anchor)) / (sensor_s(&other) - sensor_s(&anchor))
            }
            None => arrival_rate(scans).unwrap_or(1.0),
        };
        if (rate - 1.0).abs() > MAX_RATE_ERROR {
            return Err(ClockError::Rate(rate));
        }
        let clock = Self {
            anchor_host_s: middle_s(&anchor),
            anchor_sensor_s: sensor_s(&anchor),
            rate,
            uncertainty_s: width(&&anchor) / 2.0,
        };
        clock.check(scans)?;
        Ok(clock)
    }

    /// Host time in seconds of a sensor stamp in milliseconds.
    pub(super) fn host_s(&self, stamp_ms: u64) -> f64 {
        self.anchor_host_s + self.rate * (stamp_ms as f64 * 1e-3 - self.anchor_sensor_s)
    }

    fn check(&self, scans: &[StampedScan]) -> Result<(), ClockError> {
        let earliest = scans
            .iter()
            .map(|scan| scan.arrived_s - self.host_s(scan.stamp_ms))
            .fold(f64::INFINITY, f64::min);
        if earliest < -self.uncertainty_s - STAMP_ROUNDING_S {
            return Err(ClockError::EarlyScan(-earliest));
        }
        Ok(())
    }
}

fn sensor_s(sample: &TimeSample) -> f64 {
    sample.stamp_ms as f64 * 1e-3
}

fn middle_s(sample: &TimeSample) -> f64 {
    (sample.sent_s + sample.received_s) / 2.0
}

/// Rate from the scans with the least delay in the first and in the last third.
fn arrival_rate(scans: &[StampedScan]) -> Option<f64> {
    let third = scans.len() / 3;
    let early = earliest(&scans[..third])?;
    let late = earliest(&scans[scans.len() - third..])?;
    let span_s = (late.stamp_ms as f64 - early.stamp_ms as f64) * 1e-3;
    (span_s >= MIN_RATE_SPAN_S).then(|| (late.arrived_s - early.arrived_s) / span_s)
}

/// The scan with the least delay between stamp and arrival.
fn earliest(scans: &[StampedScan]) -> Option<&StampedScan> {
    let delay_s = |scan: &StampedScan| scan.arrived_s - scan.stamp_ms as f64 * 1e-3;
    scans
        .iter()
        .min_by(|a, b| delay_s(a).total_cmp(&delay_s(b)))
}

#[cfg(test)]
mod tests {
    use super::{ClockError, SensorClock, StampedScan, TimeSample};

    /// A sensor whose 1000 ms are 998.67 host ms (scip2 section 8), switched on at host second 50.
    fn host_of(sensor_s: f64) -> f64 {
        50.0 + 0.99867 * sensor_s
    }

    fn sample(sensor_s: f64, before_s: f64, after_s: f64) -> TimeSample {
        TimeSample {
            sent_s: host_of(sensor_s) - before_s,
            received_s: host_of(sensor_s) + after_s,
            stamp_ms: (sensor_s * 1e3).round() as u64,
        }
    }

    fn scans(delay_s: f64) -> Vec<StampedScan> {
        (0..120)
            .map(|i| {
                let sensor_s = 101.0 + 0.1 * f64::from(i);
                let jitter_s = 0.002 * f64::from(i % 7);
                StampedScan {
                    stamp_ms: (sensor_s * 1e3).round() as u64,
                    arrived_s: host_of(sensor_s) + delay_s + jitter_s,
                    values: Vec::new(),
                }
            })
            .collect()
    }

    #[test]
    fn offset_and_rate_from_exchanges_at_both_ends() {
        let samples = [
            sample(100.0, 0.004, 0.009),
            sample(100.1, 0.0005, 0.0005),
            sample(114.0, 0.0006, 0.0006),
            sample(114.1, 0.02, 0.001),
        ];
        let clock = SensorClock::fit(&samples, &scans(0.08)).expect("fits");
        assert!((clock.rate - 0.99867).abs() < 1e-6);
        assert!((clock.host_s(107_000) - host_of(107.0)).abs() < 1e-4);
        assert!((clock.uncertainty_s - 0.0005).abs() < 1e-9);
    }

    #[test]
    fn rate_from_arrivals_where_only_one_end_was_exchanged() {
        let clock = SensorClock::fit(&[sample(100.0, 0.0005, 0.0005)], &scans(0.08)).expect("fits");
        assert!((clock.rate - 0.99867).abs() < 3e-4, "{}", clock.rate);
    }

    #[test]
    fn impossible_clocks_are_refused() {
        assert_eq!(
            SensorClock::fit(&[], &scans(0.08)),
            Err(ClockError::NoSamples)
        );
        let early = SensorClock::fit(&[sample(100.0, 0.0005, 0.0005)], &scans(-0.2));
        assert!(matches!(early, Err(ClockError::EarlyScan(_))));
        let mut jumped = sample(114.0, 0.0005, 0.0005);
        jumped.stamp_ms += 1000;
        let rate = SensorClock::fit(&[sample(100.0, 0.0005, 0.0005), jumped], &scans(0.08));
        assert!(matches!(rate, Err(ClockError::Rate(_))));
    }
}
