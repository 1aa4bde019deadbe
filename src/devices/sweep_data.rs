//! The data of a pan segment while it is recorded, and the timing of its scans.

use super::constants::{
    FIRST_BYTE_TURNS, RATE_MIN_SCANS, RATE_PAIR_DIVISOR, START_TIME_SCANS, TIMER_SCANS,
    TIMER_STEP_PERIODS,
};
use super::plan::{SweepPlan, TiltPlan};
use patrold_engine::sweep::{HeadMotion, PanSegment, PositionPoll, StampedScan, TimeSample};
use scip::stamp_advance_ms;
use std::collections::VecDeque;
use std::time::Duration;

/// Unwraps the laser's 24-bit stamps. A step back by less than half the timer's range stays a step back: a timer reading may
/// arrive before an older scan.
#[derive(Debug, Clone, Default)]
pub(crate) struct StampUnwrapper {
    last: Option<(u32, u64)>,
}

/// Half the range of the timer, ms.
const HALF_RANGE_MS: u32 = scip::STAMP_MODULUS_MS / 2;

impl StampUnwrapper {
    /// Milliseconds without wrap. One timer range is added so that a step back from the first stamp stays positive.
    pub(super) fn unwrap(&mut self, stamp_ms: u32) -> u64 {
        let count = match self.last {
            None => u64::from(stamp_ms) + u64::from(scip::STAMP_MODULUS_MS),
            Some((last_ms, count)) => match stamp_advance_ms(last_ms, stamp_ms) {
                ahead if ahead < HALF_RANGE_MS => count + u64::from(ahead),
                ahead => count.saturating_sub(u64::from(scip::STAMP_MODULUS_MS - ahead)),
            },
        };
        self.last = Some((stamp_ms, count));
        count
    }
}

/// Host time at which scans started, independent of delays on the line: the stamp plus the smallest lag of host against
/// timer among recent arrivals and the time exchange before them.
#[derive(Debug, Clone, Default)]
pub(crate) struct ScanTimeEstimator {
    lags_s: VecDeque<f64>,
}

impl ScanTimeEstimator {
    /// Starts over with the time exchange at the start of a segment.
    pub(super) fn restart(&mut self, time_samples: &[TimeSample]) {
        self.lags_s.clear();
        self.lags_s.extend(min_delay_lag_s(time_samples.iter()));
    }

    /// Host time at which the scan passed step 0, seconds; too late at most by the delay of the fastest arrival.
    pub(super) fn start_time_s(&mut self, scan: &StampedScan, period_s: f64) -> f64 {
        let stamp_s = scan.stamp_ms as f64 * 1e-3;
        if self.lags_s.len() >= START_TIME_SCANS {
            self.lags_s.pop_front();
        }
        self.lags_s
            .push_back(scan.arrived_s - FIRST_BYTE_TURNS * period_s - stamp_s);
        stamp_s + self.lags_s.iter().copied().fold(f64::INFINITY, f64::min)
    }
}

/// Host time minus timer in the fastest exchange, seconds.
fn min_delay_lag_s<'a>(samples: impl Iterator<Item = &'a TimeSample>) -> Option<f64> {
    samples
        .min_by(|a, b| (a.received_s - a.sent_s).total_cmp(&(b.received_s - b.sent_s)))
        .map(|s| (s.sent_s + s.received_s) / 2.0 - s.stamp_ms as f64 * 1e-3)
}

/// A pan segment being recorded.
#[derive(Debug, Clone, Default)]
pub(crate) struct PanSegmentDraft {
    pub scans: Vec<StampedScan>,
    /// Tilt of each scan in step-and-stare, counts.
    pub tilt_steps: Vec<i32>,
    pub polls: Vec<PositionPoll>,
    pub time_samples: Vec<TimeSample>,
}

impl PanSegmentDraft {
    /// Whether the laser's timer stepped against the host clock during the segment. The driver detects all steps but those
    /// by whole scan periods, which look like lost or repeated scans. A late host raises the lag of single arrivals, never
    /// of all scans before or after, so the smallest lags on both sides of any scan must agree; so must the lags of the
    /// arrivals and of the time exchanges at both ends.
    pub(super) fn timer_stepped(&self, plan: &SweepPlan) -> bool {
        if matches!(plan.tilt, TiltPlan::Steps(_)) {
            return false;
        }
        self.has_step(TIMER_STEP_PERIODS * plan.line_period.as_secs_f64())
    }

    /// Whether lags differ by more than `allowed_s` after the rate difference of the two clocks is removed; 0.2 % alone is a
    /// scan period in less than a minute.
    fn has_step(&self, allowed_s: f64) -> bool {
        let rate = self.lag_rate();
        let begin_s = self.scans.first().map_or(0.0, |s| s.arrived_s);
        let lag_s = |s: &StampedScan| arrival_lag_s(s) - rate * (s.arrived_s - begin_s);
        let min_lag_s =
            |scans: &[StampedScan]| scans.iter().map(lag_s).fold(f64::INFINITY, f64::min);
        let last = self.scans.len().saturating_sub(TIMER_SCANS);
        let has_step = (TIMER_SCANS..=last).any(|at| {
            let (before, after) = self.scans.split_at(at);
            (min_lag_s(before) - min_lag_s(after)).abs() > allowed_s
        });
        let begin = self.scans.get(..TIMER_SCANS).unwrap_or(&self.scans);
        let end = self.scans.get(last..).unwrap_or(&self.scans);
        // Each end against its own exchange, seconds away: the rate difference does not matter.
        let min_lag_s = |scans: &[StampedScan]| {
            scans
                .iter()
                .map(arrival_lag_s)
                .fold(f64::INFINITY, f64::min)
        };
        let drift_s = (min_lag_s(end) - self.exchange_lag_s(true))
            - (min_lag_s(begin) - self.exchange_lag_s(false));
        // NaN, hence no step, without scans or exchanges.
        has_step || drift_s.abs() > allowed_s
    }

    /// Host time minus timer in the fastest time exchange before the scans, or after them, seconds; NaN without any.
    fn exchange_lag_s(&self, after: bool) -> f64 {
        let begin_s = self.scans.first().map_or(f64::INFINITY, |s| s.arrived_s);
        let samples = self.time_samples.iter();
        min_delay_lag_s(samples.filter(|s| (s.sent_s > begin_s) == after)).unwrap_or(f64::NAN)
    }

    /// Growth of the lag per second: median over pairs of scans, robust against one step and a few late arrivals.
    fn lag_rate(&self) -> f64 {
        if self.scans.len() < RATE_MIN_SCANS {
            return 0.0;
        }
        let later = self.scans.iter().skip(self.scans.len() / RATE_PAIR_DIVISOR);
        let mut rates: Vec<f64> = self
            .scans
            .iter()
            .zip(later)
            .map(|(a, b)| {
                let timer_s = (b.stamp_ms as f64 - a.stamp_ms as f64) * 1e-3;
                (arrival_lag_s(b) - arrival_lag_s(a)) / timer_s
            })
            .filter(|rate| rate.is_finite())
            .collect();
        let middle = rates.len() / 2;
        rates.sort_by(f64::total_cmp);
        rates.get(middle).copied().unwrap_or(0.0)
    }

    /// The finished segment at `pan_rad`; without the polls on the speed ramps.
    pub(super) fn finish(self, plan: &SweepPlan, pan_rad: f64) -> PanSegment {
        let (motion, polls) = match &plan.tilt {
            TiltPlan::Steps(_) => (
                HeadMotion::StepAndStare {
                    tilt_steps: self.tilt_steps,
                },
                Vec::new(),
            ),
            TiltPlan::Continuous {
                start_steps,
                end_steps,
                speed_steps_s,
                ramp_steps,
            } => {
                let direction = (end_steps - start_steps).signum();
                let polls = self
                    .polls
                    .into_iter()
                    .filter(|p| {
                        is_off_ramp(p.tilt_steps, *start_steps, *ramp_steps)
                            && is_off_ramp(p.tilt_steps, *end_steps, *ramp_steps)
                    })
                    .collect();
                let speed_steps_s = f64::from(direction * speed_steps_s);
                (HeadMotion::Tilting { speed_steps_s }, polls)
            }
        };
        PanSegment {
            pan_rad,
            motion,
            scans: self.scans,
            polls,
            time_samples: self.time_samples,
        }
    }
}

/// Host time of the arrival minus stamp, seconds.
fn arrival_lag_s(scan: &StampedScan) -> f64 {
    scan.arrived_s - scan.stamp_ms as f64 * 1e-3
}

/// Stopped at `end`, or past its speed ramp.
fn is_off_ramp(steps: i32, end: i32, ramp_steps: i32) -> bool {
    ramp_steps == 0 || steps == end || (steps - end).abs() > ramp_steps
}

pub(super) fn time_sample(
    sent: Duration,
    received: Duration,
    stamp_ms: u32,
    stamps: &mut StampUnwrapper,
) -> TimeSample {
    TimeSample {
        sent_s: sent.as_secs_f64(),
        received_s: received.as_secs_f64(),
        stamp_ms: stamps.unwrap(stamp_ms),
    }
}

#[cfg(test)]
mod tests {
    use super::{PanSegmentDraft, ScanTimeEstimator, StampUnwrapper, is_off_ramp, min_delay_lag_s};
    use patrold_engine::sweep::{StampedScan, TimeSample};

    fn scan(stamp_ms: u64, arrived_s: f64) -> StampedScan {
        StampedScan {
            stamp_ms,
            arrived_s,
            values: Vec::new(),
        }
    }

    /// A segment of `count` scans, ten a second; the timer is fast by `rate` and steps after a third of them.
    fn segment(count: u64, rate: f64, step_s: f64) -> PanSegmentDraft {
        let stamp = |host_s: f64, step_s: f64| ((host_s * (1.0 + rate) + step_s) * 1e3) as u64;
        let exchange = |at_s: f64, step_s: f64| TimeSample {
            sent_s: at_s - 0.001,
            received_s: at_s + 0.001,
            stamp_ms: stamp(at_s, step_s),
        };
        let scans = (0..count).map(|n| {
            let begun_s = 10.0 + n as f64 * 0.1;
            let step_s = if n > count / 3 { step_s } else { 0.0 };
            // Some arrivals are late.
            let late_s = [0.0, 0.004, 0.0, 0.03][n as usize % 4];
            scan(stamp(begun_s, step_s), begun_s + 0.075 + late_s)
        });
        PanSegmentDraft {
            scans: scans.collect(),
            time_samples: vec![
                exchange(9.5, 0.0),
                exchange(10.5 + count as f64 * 0.1, step_s),
            ],
            ..PanSegmentDraft::default()
        }
    }

    #[test]
    fn a_wrong_rate_is_no_step_however_long_the_segment() {
        for rate in [0.0013, -0.0013, 0.002, -0.002, 0.0] {
            for count in [20, 99, 100, 450, 3000] {
                assert!(!segment(count, rate, 0.0).has_step(0.05), "{rate} {count}");
                for step_s in [0.1, -0.1, 0.2, -3.0] {
                    let has_step = segment(count, rate, step_s).has_step(0.05);
                    assert!(has_step, "{rate} {count} {step_s}");
                }
            }
        }
    }

    #[test]
    fn a_stalled_line_does_not_change_the_start_time() {
        let mut times = ScanTimeEstimator::default();
        times.restart(&segment(0, 0.0, 0.0).time_samples);
        assert!((times.start_time_s(&scan(10_000, 10.075), 0.1) - 10.0).abs() < 0.002);
        // Scanned at 10.1 s, arrived a second late.
        assert!((times.start_time_s(&scan(10_100, 11.175), 0.1) - 10.1).abs() < 0.002);
        // A timer that is slow by 0.2 % does not make scans of the tenth minute look old.
        for n in 2..6000_u32 {
            let stamp_ms = 10_000 + u64::from(n) * 100;
            let begun_s = 10.0 + f64::from(n) * 0.1 * 1.002;
            let start_s = times.start_time_s(&scan(stamp_ms, begun_s + 0.075), 0.1);
            assert!((-0.025..0.002).contains(&(start_s - begun_s)), "{n}");
        }
    }

    #[test]
    fn the_fastest_exchange_gives_the_lag_wherever_it_is() {
        let exchange = |sent_s: f64, took_s: f64, lag_s: f64| TimeSample {
            sent_s,
            received_s: sent_s + took_s,
            stamp_ms: (1e3 * (sent_s + took_s / 2.0 - lag_s)).round() as u64,
        };
        let (fast, slow) = (exchange(8.0, 0.002, 3.0), exchange(5.0, 0.1, 3.04));
        let later = exchange(20.0, 0.05, 3.02);
        for samples in [[&fast, &slow, &later], [&later, &slow, &fast]] {
            let lag_s = min_delay_lag_s(samples.into_iter()).expect("exchanges");
            assert!((lag_s - 3.0).abs() < 0.001, "{lag_s}");
        }
        assert_eq!(min_delay_lag_s(std::iter::empty()), None);
    }

    #[test]
    fn each_segment_begins_with_the_lag_of_its_own_exchange() {
        let mut times = ScanTimeEstimator::default();
        times.restart(&segment(0, 0.0, 0.0).time_samples);
        times.start_time_s(&scan(10_000, 10.075), 0.1);
        // The timer was set back by two seconds in between.
        times.restart(&segment(0, 0.0, -2.0).time_samples[1..]);
        let start_s = times.start_time_s(&scan(9_000, 11.075), 0.1);
        assert!((start_s - 11.0).abs() < 0.002, "{start_s}");
    }

    #[test]
    fn a_position_counts_at_the_end_and_past_the_ramp() {
        for (steps, is_off) in [
            (100, true),
            (99, false),
            (90, false),
            (89, true),
            (110, false),
            (111, true),
        ] {
            assert_eq!(is_off_ramp(steps, 100, 10), is_off, "{steps}");
            assert!(is_off_ramp(steps, 100, 0), "no ramp: {steps}");
        }
    }

    #[test]
    fn stamps_continue_over_the_wrap_and_may_step_back() {
        let mut stamps = StampUnwrapper::default();
        let first = stamps.unwrap(0xFF_FF00);
        assert_eq!(stamps.unwrap(0x00_0010) - first, 0x110);
        assert_eq!(first - stamps.unwrap(0xFF_FEF0), 0x10);
        assert_eq!(stamps.unwrap(0x00_0020) - first, 0x120);
        // Each from the one before, however far from the first.
        for thirds in 1..=6 {
            let ahead = u64::from(scip::STAMP_MODULUS_MS) / 3 * thirds;
            let stamp_ms = (0x20 + ahead) % u64::from(scip::STAMP_MODULUS_MS);
            assert_eq!(stamps.unwrap(stamp_ms as u32) - first, 0x120 + ahead);
        }
    }

    #[test]
    fn a_first_stamp_near_zero_leaves_room_for_a_step_back() {
        let mut stamps = StampUnwrapper::default();
        let first = stamps.unwrap(5);
        assert_eq!(first - stamps.unwrap(0xFF_FFFE), 7);
    }
}
