//! What a leg gathers while it runs, and what becomes of it.

use super::constants::{TIMER_SCANS, TIMER_STEP_PERIODS};
use super::plan::{SweepPlan, TiltPlan};
use crate::sweep::{Leg, Motion, Poll, RawScan, TimeSample};
use scip::stamp_advance_ms;
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
        let lag_s = |s: &RawScan| s.arrived_s - s.stamp_ms as f64 * 1e-3;
        let least = |scans: &[RawScan]| scans.iter().map(lag_s).fold(f64::INFINITY, f64::min);
        let allowed_s = TIMER_STEP_PERIODS * plan.line_period.as_secs_f64();
        let last = self.scans.len().saturating_sub(TIMER_SCANS);
        let stepped = (TIMER_SCANS..=last).any(|at| {
            let (before, after) = self.scans.split_at(at);
            (least(before) - least(after)).abs() > allowed_s
        });
        let begin = self.scans.get(..TIMER_SCANS).unwrap_or(&self.scans);
        let end = self.scans.get(last..).unwrap_or(&self.scans);
        let drift_s =
            (least(end) - self.exchange_lag_s(true)) - (least(begin) - self.exchange_lag_s(false));
        // Without scans or exchanges there is no number, and others will say so.
        stepped || drift_s.abs() > allowed_s
    }

    /// Host less timer in the quickest exchange of time before the scans, or after them; no number without any.
    fn exchange_lag_s(&self, after: bool) -> f64 {
        let begin_s = self.scans.first().map_or(f64::INFINITY, |s| s.arrived_s);
        self.time_samples
            .iter()
            .filter(|s| (s.sent_s > begin_s) == after)
            .min_by(|a, b| (a.received_s - a.sent_s).total_cmp(&(b.received_s - b.sent_s)))
            .map_or(f64::NAN, |s| {
                (s.sent_s + s.received_s) / 2.0 - s.stamp_ms as f64 * 1e-3
            })
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
    use super::StampUnwrapper;

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
