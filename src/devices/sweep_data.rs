//! What a leg gathers while it runs, and what becomes of it.

use super::constants::{
    DATING_SCANS, FIRST_BYTE_TURN, RATE_SCANS, TIMER_SCANS, TIMER_STEP_PERIODS,
};
use super::plan::{SweepPlan, TiltPlan};
use patrold_engine::sweep::{Leg, Motion, Poll, RawScan, TimeSample};
use scip::stamp_advance_ms;
use std::collections::VecDeque;
use std::time::Duration;

/// Unwraps the laser's 24-bit stamps to one count that goes on for ever. A step of less than half a turn of the timer
/// back is one: the timer was read before an older scan arrived.
#[derive(Debug, Clone, Default)]
pub struct StampUnwrapper {
    last: Option<(u32, u64)>,
}

/// Half a turn of the timer, ms.
const HALF_TURN_MS: u32 = scip::STAMP_MODULUS_MS / 2;

impl StampUnwrapper {
    /// The stamp on the endless count; the first one stands as it is, one turn up.
    pub fn unwrap(&mut self, stamp_ms: u32) -> u64 {
        let count = match self.last {
            // A turn up, so that a step back from the first has room.
            None => u64::from(stamp_ms) + u64::from(scip::STAMP_MODULUS_MS),
            Some((last_ms, count)) => match stamp_advance_ms(last_ms, stamp_ms) {
                ahead if ahead < HALF_TURN_MS => count + u64::from(ahead),
                ahead => count.saturating_sub(u64::from(scip::STAMP_MODULUS_MS - ahead)),
            },
        };
        self.last = Some((stamp_ms, count));
        count
    }
}

/// When scans really began, whatever the line did to their arrival: the least lag of host against timer among the
/// recent arrivals and the exchange of time before them, on top of the stamp.
#[derive(Debug, Clone, Default)]
pub struct ScanDating {
    lags_s: VecDeque<f64>,
}

impl ScanDating {
    /// Takes the exchange of time at the beginning of a leg.
    pub fn begin(&mut self, time_samples: &[TimeSample]) {
        self.lags_s.clear();
        self.lags_s.extend(quickest_lag_s(time_samples.iter()));
    }

    /// The host's time at which this scan passed step 0, seconds, never too late by more than the quickest arrival.
    pub fn begun_s(&mut self, scan: &RawScan, period_s: f64) -> f64 {
        let stamp_s = scan.stamp_ms as f64 * 1e-3;
        if self.lags_s.len() >= DATING_SCANS {
            self.lags_s.pop_front();
        }
        self.lags_s
            .push_back(scan.arrived_s - FIRST_BYTE_TURN * period_s - stamp_s);
        stamp_s + self.lags_s.iter().copied().fold(f64::INFINITY, f64::min)
    }
}

/// Host less timer in the quickest of these exchanges, seconds.
fn quickest_lag_s<'a>(samples: impl Iterator<Item = &'a TimeSample>) -> Option<f64> {
    samples
        .min_by(|a, b| (a.received_s - a.sent_s).total_cmp(&(b.received_s - b.sent_s)))
        .map(|s| (s.sent_s + s.received_s) / 2.0 - s.stamp_ms as f64 * 1e-3)
}

/// One leg under way.
#[derive(Debug, Clone, Default)]
pub struct LegDraft {
    /// Scans so far.
    pub scans: Vec<RawScan>,
    /// Where the head stood in each, for step-and-stare.
    pub tilt_steps: Vec<i32>,
    /// Polls so far.
    pub polls: Vec<Poll>,
    /// Exchanges of time so far.
    pub time_samples: Vec<TimeSample>,
}

impl LegDraft {
    /// Whether the laser's timer stepped against the host's clock while its stamps were in use. The driver sees every
    /// step but one by whole periods, which looks like lost or repeated scans. A late host only ever raises the lag of an
    /// arrival, and never that of all scans before or after, so the least lags on either side of any scan must agree;
    /// and so must the lag of the arrivals against the exchanges of time at both ends.
    pub fn timer_stepped(&self, plan: &SweepPlan) -> bool {
        if matches!(plan.tilt, TiltPlan::Steps(_)) {
            return false;
        }
        self.stepped(TIMER_STEP_PERIODS * plan.line_period.as_secs_f64())
    }

    /// Whether lags differ by more than `allowed_s` after the difference of the two clocks' rates is taken out: at 0.2 %
    /// that alone is a scan period in less than a minute.
    fn stepped(&self, allowed_s: f64) -> bool {
        let rate = self.lag_rate();
        let begin_s = self.scans.first().map_or(0.0, |s| s.arrived_s);
        let lag_s = |s: &RawScan| raw_lag_s(s) - rate * (s.arrived_s - begin_s);
        let least = |scans: &[RawScan]| scans.iter().map(lag_s).fold(f64::INFINITY, f64::min);
        let last = self.scans.len().saturating_sub(TIMER_SCANS);
        let stepped = (TIMER_SCANS..=last).any(|at| {
            let (before, after) = self.scans.split_at(at);
            (least(before) - least(after)).abs() > allowed_s
        });
        let begin = self.scans.get(..TIMER_SCANS).unwrap_or(&self.scans);
        let end = self.scans.get(last..).unwrap_or(&self.scans);
        // Each end against its own exchange, seconds away: no rate matters.
        let least = |scans: &[RawScan]| scans.iter().map(raw_lag_s).fold(f64::INFINITY, f64::min);
        let drift_s =
            (least(end) - self.exchange_lag_s(true)) - (least(begin) - self.exchange_lag_s(false));
        // Without scans or exchanges there is no number, and others will say so.
        stepped || drift_s.abs() > allowed_s
    }

    /// Host less timer in the quickest exchange of time before the scans, or after them; no number without any.
    fn exchange_lag_s(&self, after: bool) -> f64 {
        let begin_s = self.scans.first().map_or(f64::INFINITY, |s| s.arrived_s);
        let samples = self.time_samples.iter();
        quickest_lag_s(samples.filter(|s| (s.sent_s > begin_s) == after)).unwrap_or(f64::NAN)
    }

    /// Growth of the lag per second: the median over pairs of scans, which one step and a few late arrivals do not move.
    fn lag_rate(&self) -> f64 {
        let (least, part) = RATE_SCANS;
        if self.scans.len() < least {
            return 0.0;
        }
        let later = self.scans.iter().skip(self.scans.len() / part);
        let mut rates: Vec<f64> = self
            .scans
            .iter()
            .zip(later)
            .map(|(a, b)| {
                let timer_s = (b.stamp_ms as f64 - a.stamp_ms as f64) * 1e-3;
                (raw_lag_s(b) - raw_lag_s(a)) / timer_s
            })
            .filter(|rate| rate.is_finite())
            .collect();
        let middle = rates.len() / 2;
        rates.sort_by(f64::total_cmp);
        rates.get(middle).copied().unwrap_or(0.0)
    }

    /// The leg at `pan_rad`.
    pub fn finish(self, plan: &SweepPlan, pan_rad: f64) -> Leg {
        let (motion, polls) = match &plan.tilt {
            TiltPlan::Steps(_) => (
                Motion::Standing {
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
                let way = (end_steps - start_steps).signum();
                let polls = self
                    .polls
                    .into_iter()
                    .filter(|p| {
                        off_ramps(p.tilt_steps, *start_steps, *ramp_steps)
                            && off_ramps(p.tilt_steps, *end_steps, *ramp_steps)
                    })
                    .collect();
                let speed_steps_s = f64::from(way * speed_steps_s);
                (Motion::Tilting { speed_steps_s }, polls)
            }
        };
        Leg {
            pan_rad,
            motion,
            scans: self.scans,
            polls,
            time_samples: self.time_samples,
        }
    }
}

/// Host at the arrival less timer at the stamp, seconds.
fn raw_lag_s(scan: &RawScan) -> f64 {
    scan.arrived_s - scan.stamp_ms as f64 * 1e-3
}

/// At rest at `end`, or past the ramp that leads from it.
fn off_ramps(steps: i32, end: i32, ramp_steps: i32) -> bool {
    ramp_steps == 0 || steps == end || (steps - end).abs() > ramp_steps
}

/// An exchange of time as the sweep stores it.
pub fn time_sample(
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
    use super::{LegDraft, ScanDating, StampUnwrapper};
    use patrold_engine::sweep::{RawScan, TimeSample};

    fn scan(stamp_ms: u64, arrived_s: f64) -> RawScan {
        RawScan {
            stamp_ms,
            arrived_s,
            values: Vec::new(),
        }
    }

    /// A leg of `count` scans, ten a second, by a timer that runs `rate` fast; after a third of them it steps.
    fn leg(count: u64, rate: f64, step_s: f64) -> LegDraft {
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
        LegDraft {
            scans: scans.collect(),
            time_samples: vec![
                exchange(9.5, 0.0),
                exchange(10.5 + count as f64 * 0.1, step_s),
            ],
            ..LegDraft::default()
        }
    }

    #[test]
    fn a_wrong_rate_is_no_step_however_long_the_leg() {
        for rate in [0.0013, -0.0013, 0.002, -0.002, 0.0] {
            for count in [20, 99, 100, 450, 3000] {
                assert!(!leg(count, rate, 0.0).stepped(0.05), "{rate} {count}");
                for step_s in [0.1, -0.1, 0.2, -3.0] {
                    let stepped = leg(count, rate, step_s).stepped(0.05);
                    assert!(stepped, "{rate} {count} {step_s}");
                }
            }
        }
    }

    #[test]
    fn a_scan_is_dated_by_its_stamp_when_the_line_stalls() {
        let mut dating = ScanDating::default();
        dating.begin(&leg(0, 0.0, 0.0).time_samples);
        assert!((dating.begun_s(&scan(10_000, 10.075), 0.1) - 10.0).abs() < 0.002);
        // Turned at 10.1 s, arrived a second late.
        assert!((dating.begun_s(&scan(10_100, 11.175), 0.1) - 10.1).abs() < 0.002);
        // A timer that is slow by 0.2 % does not make scans of the tenth minute look old.
        for n in 2..6000_u32 {
            let stamp_ms = 10_000 + u64::from(n) * 100;
            let begun_s = 10.0 + f64::from(n) * 0.1 * 1.002;
            let dated_s = dating.begun_s(&scan(stamp_ms, begun_s + 0.075), 0.1);
            assert!((-0.025..0.002).contains(&(dated_s - begun_s)), "{n}");
        }
    }

    #[test]
    fn stamps_go_on_over_the_wrap_and_may_step_back() {
        let mut stamps = StampUnwrapper::default();
        let first = stamps.unwrap(0xFF_FF00);
        assert_eq!(stamps.unwrap(0x00_0010) - first, 0x110);
        assert_eq!(first - stamps.unwrap(0xFF_FEF0), 0x10);
        assert_eq!(stamps.unwrap(0x00_0020) - first, 0x120);
    }

    #[test]
    fn a_first_stamp_near_zero_leaves_room_for_a_step_back() {
        let mut stamps = StampUnwrapper::default();
        let first = stamps.unwrap(5);
        assert_eq!(first - stamps.unwrap(0xFF_FFFE), 7);
    }
}
