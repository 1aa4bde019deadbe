//! The schedule of injected faults: those that strike once and those that last.

use std::time::Duration;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{HeadFaultKind, HeadFaultSpec};
use crate::emulator::axis_name::AxisName;
use crate::emulator::constants::{FAULT_PERIOD, MAX_FAULTS, MIN_FAULT_PERIOD};

/// A one-time effect that is due.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::emulator) enum FaultEffect {
    /// The rotor of an axis jumps.
    LoseSteps(AxisName, i32),
    /// `!` and this letter.
    Event(char),
    /// A line of text.
    Text(String),
    Echo,
    Verbose,
    /// The effect of a command of another program.
    ForeignCommand(HeadFaultKind),
    /// Power off until the instant.
    PowerCycle(Duration),
}

#[derive(Debug)]
struct ScheduledFault {
    kind: HeadFaultKind,
    /// Next strike of a one-time fault, start of a lasting one.
    at: Duration,
    lasting: Option<Duration>,
    /// Strikes, bytes, calibrations or periods still to come.
    remaining: u32,
    every: Duration,
    /// Output bytes let through since the last hit.
    skipped: u32,
    /// No byte or calibration is hit before.
    not_before: Duration,
}

impl ScheduledFault {
    /// End of a lasting one.
    fn until(&self) -> Duration {
        self.lasting
            .map_or(Duration::MAX, |lasting| self.at.saturating_add(lasting))
    }

    fn is_active(&self, now: Duration) -> bool {
        self.at <= now && now < self.until() && self.remaining > 0
    }

    /// At the end of a period of a lasting fault: goes on to the next one, if there is one.
    fn begin_next_period(&mut self, now: Duration) {
        while !counts_hits(&self.kind) && self.until() <= now && self.remaining > 1 {
            self.remaining -= 1;
            // One period ends before the next begins.
            self.at = self.at.saturating_add(self.every).max(self.until());
        }
    }

    /// Counts a byte or a calibration that was hit.
    fn hit(&mut self, now: Duration) {
        self.remaining -= 1;
        self.not_before = now.saturating_add(self.every);
    }
}

/// All faults of one emulated head.
#[derive(Debug, Default)]
pub(in crate::emulator) struct FaultSchedule {
    faults: Vec<ScheduledFault>,
}

fn is_one_time(kind: &HeadFaultKind) -> bool {
    matches!(
        kind,
        HeadFaultKind::LostSteps { .. }
            | HeadFaultKind::Event { within: None, .. }
            | HeadFaultKind::Text(_)
            | HeadFaultKind::Echo
            | HeadFaultKind::Verbose
            | HeadFaultKind::Velocity
            | HeadFaultKind::Slaved
            | HeadFaultKind::LimitsOff
            | HeadFaultKind::Monitor
            | HeadFaultKind::Moving(_)
            | HeadFaultKind::UnitId(_)
            | HeadFaultKind::Baud(_)
            | HeadFaultKind::AxisError
            | HeadFaultKind::PowerCycle
    )
}

/// Whether its count is of bytes or calibrations.
fn counts_hits(kind: &HeadFaultKind) -> bool {
    matches!(
        kind,
        HeadFaultKind::Event {
            within: Some(_),
            ..
        } | HeadFaultKind::LostByte { .. }
            | HeadFaultKind::GarbageByte { .. }
            | HeadFaultKind::ResetFails
    )
}

impl FaultSchedule {
    pub(in crate::emulator) fn add(&mut self, spec: HeadFaultSpec, now: Duration) {
        let HeadFaultSpec { kind, times } = spec;
        let every = match times.every {
            Some(every) => every.max(MIN_FAULT_PERIOD),
            None if counts_hits(&kind) => Duration::ZERO,
            None => FAULT_PERIOD,
        };
        if self.faults.len() < MAX_FAULTS {
            self.faults.push(ScheduledFault {
                kind,
                at: times.start(now),
                lasting: times.lasting,
                remaining: times.count.unwrap_or(1),
                every,
                skipped: 0,
                not_before: Duration::ZERO,
            });
        }
    }

    /// When a fault starts, strikes or ends next.
    pub(in crate::emulator) fn next_at(&self, now: Duration) -> Option<Duration> {
        self.faults
            .iter()
            .map(|f| {
                if is_one_time(&f.kind) || f.at > now {
                    f.at
                } else {
                    f.until()
                }
            })
            .filter(|at| *at != Duration::MAX)
            .min()
    }

    /// The effects that are due; drops the faults that are over.
    pub(in crate::emulator) fn take_due(&mut self, now: Duration) -> Vec<FaultEffect> {
        let mut effects = Vec::new();
        for fault in &mut self.faults {
            if !is_one_time(&fault.kind) {
                fault.begin_next_period(now);
                continue;
            }
            if fault.at > now {
                continue;
            }
            match &fault.kind {
                _ if fault.remaining == 0 => {}
                HeadFaultKind::LostSteps { axes, steps } => {
                    effects.extend(axes.iter().map(|a| FaultEffect::LoseSteps(*a, *steps)))
                }
                HeadFaultKind::Event { which, .. } => effects.push(FaultEffect::Event(*which)),
                HeadFaultKind::Text(text) => effects.push(FaultEffect::Text(text.clone())),
                HeadFaultKind::Echo => effects.push(FaultEffect::Echo),
                HeadFaultKind::Verbose => effects.push(FaultEffect::Verbose),
                HeadFaultKind::PowerCycle => effects.push(FaultEffect::PowerCycle(
                    fault.lasting.map_or(now, |_| fault.until()),
                )),
                kind => effects.push(FaultEffect::ForeignCommand(kind.clone())),
            }
            fault.remaining = fault.remaining.saturating_sub(1);
            fault.at = fault.at.saturating_add(fault.every);
        }
        self.faults
            .retain(|f| f.remaining > 0 && (is_one_time(&f.kind) || f.until() > now));
        effects
    }

    fn active(&self, now: Duration) -> impl Iterator<Item = &HeadFaultKind> {
        self.faults
            .iter()
            .filter(move |f| f.is_active(now))
            .map(|f| &f.kind)
    }

    /// What hinders one axis: stalled count, blocked rotor, factor on all speeds.
    pub(in crate::emulator) fn hindrance(
        &self,
        axis: AxisName,
        now: Duration,
    ) -> (bool, bool, f64) {
        let (mut stalled, mut blocked, mut speed_factor) = (false, false, 1.0);
        for kind in self.active(now) {
            match kind {
                HeadFaultKind::Stuck { axes, hidden } if axes.contains(&axis) => {
                    stalled |= !hidden;
                    blocked |= hidden;
                }
                HeadFaultKind::Slow { axes, factor } if axes.contains(&axis) => {
                    speed_factor *= factor
                }
                _ => {}
            }
        }
        (stalled, blocked, f64::max(speed_factor, 1e-3))
    }

    /// How far an axis runs past its targets, counts.
    pub(in crate::emulator) fn overshoot(&self, axis: AxisName, now: Duration) -> i32 {
        self.active(now)
            .find_map(|kind| match kind {
                HeadFaultKind::Overshoot { axes, steps } if axes.contains(&axis) => Some(*steps),
                _ => None,
            })
            .unwrap_or(0)
    }

    /// What a fault makes `O` report: volts, degrees Fahrenheit.
    pub(in crate::emulator) fn supply(&self, now: Duration) -> Option<(f64, f64)> {
        self.active(now).find_map(|kind| match kind {
            HeadFaultKind::Supply { volts, degf } => Some((*volts, *degf)),
            _ => None,
        })
    }

    /// The event to insert before the next output byte, if one is due there; counts the byte.
    pub(in crate::emulator) fn inserted_event(&mut self, now: Duration) -> Option<[u8; 2]> {
        for fault in &mut self.faults {
            let HeadFaultKind::Event {
                which,
                within: Some(within),
            } = fault.kind
            else {
                continue;
            };
            if !fault.is_active(now) || now < fault.not_before {
                continue;
            }
            if fault.skipped < within {
                fault.skipped += 1;
                continue;
            }
            // The byte after the event is the first one let through before the next event.
            fault.skipped = 1;
            fault.hit(now);
            return Some([b'!', which as u8]);
        }
        None
    }

    /// Whether the next calibration fails; counts it.
    pub(in crate::emulator) fn take_reset_failure(&mut self, now: Duration) -> bool {
        let failing = |f: &&mut ScheduledFault| {
            f.kind == HeadFaultKind::ResetFails && f.is_active(now) && now >= f.not_before
        };
        let Some(fault) = self.faults.iter_mut().find(failing) else {
            return false;
        };
        fault.hit(now);
        true
    }

    /// A byte from the host as it arrives; `None` if it is lost.
    pub(in crate::emulator) fn filter_input(
        &self,
        byte: u8,
        now: Duration,
        rng: &mut ChaCha8Rng,
    ) -> Option<u8> {
        let mut received = byte;
        for kind in self.active(now) {
            match kind {
                HeadFaultKind::Silence { deaf: true } => return None,
                HeadFaultKind::WrongBaud => received = rng.random(),
                _ => {}
            }
        }
        Some(received)
    }

    /// A byte of the unit as it reaches the host; `None` if it is lost.
    pub(in crate::emulator) fn filter_output(
        &mut self,
        byte: u8,
        now: Duration,
        rng: &mut ChaCha8Rng,
    ) -> Option<u8> {
        let mut sent = Some(byte);
        for fault in self.faults.iter_mut().filter(|f| f.is_active(now)) {
            match fault.kind {
                HeadFaultKind::Silence { .. } => return None,
                HeadFaultKind::WrongBaud => sent = sent.map(|_| rng.random()),
                HeadFaultKind::LostByte { skip } | HeadFaultKind::GarbageByte { skip }
                    if now >= fault.not_before =>
                {
                    if fault.skipped < skip {
                        fault.skipped += 1;
                        continue;
                    }
                    fault.skipped = 0;
                    fault.hit(now);
                    let lost = matches!(fault.kind, HeadFaultKind::LostByte { .. });
                    sent = if lost {
                        None
                    } else {
                        sent.map(|b| b ^ rng.random_range(1..=255_u8))
                    };
                }
                _ => {}
            }
        }
        sent
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    const S: Duration = Duration::from_secs(1);

    fn schedule(text: &str) -> FaultSchedule {
        let mut schedule = FaultSchedule::default();
        schedule.add(text.parse().expect("a fault"), Duration::ZERO);
        schedule
    }

    #[test]
    fn what_lasts_a_time_comes_again_every_so_often() {
        for (text, stuck) in [
            ("stuck:for=1,count=2,every=3", [1, 0, 0, 1, 0, 0, 0]),
            // One period ends before the next begins.
            ("stuck:for=2,count=3,every=1", [1, 1, 1, 1, 1, 1, 0]),
            ("stuck:at=2,for=1", [0, 0, 1, 0, 0, 0, 0]),
            ("stuck:at=5", [0, 0, 0, 0, 0, 1, 1]),
        ] {
            let mut schedule = schedule(text);
            let seen = [0, 1, 2, 3, 4, 5, 6].map(|second| {
                let now = second * S + S / 2;
                // Every start and end by now.
                while schedule.next_at(now).is_some_and(|at| at <= now) {
                    let at = schedule.next_at(now).unwrap_or(now);
                    assert!(schedule.take_due(at).is_empty());
                }
                schedule.take_due(now);
                u8::from(schedule.hindrance(AxisName::Pan, now).0)
            });
            assert_eq!(seen, stuck, "{text}");
        }
    }

    #[test]
    fn strikes_have_a_period_and_bytes_a_least_distance() {
        let mut echoes = schedule("echo:at=500ms,count=3");
        let mut strikes = Vec::new();
        while let Some(at) = echoes.next_at(Duration::ZERO) {
            assert_eq!(echoes.take_due(at), [FaultEffect::Echo]);
            strikes.push(at.as_millis());
        }
        assert_eq!(strikes, [500, 1500, 2500]);
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut lost = |text: &str| {
            let mut schedule = schedule(text);
            [0, 10, 20, 30, 40, 50].map(|ms| {
                let now = Duration::from_millis(ms);
                schedule.filter_output(b'x', now, &mut rng).is_none()
            })
        };
        assert_eq!(
            lost("lost-byte:count=2"),
            [true, true, false, false, false, false]
        );
        assert_eq!(
            lost("lost-byte:count=2,every=25ms"),
            [true, false, false, true, false, false]
        );
    }
}
