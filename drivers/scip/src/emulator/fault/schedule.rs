//! The injected faults and their effects.

use std::mem::discriminant;
use std::time::Duration;

use super::{LaserFault, LaserFaultSpec};
use crate::emulator::constants::{
    CODE_COVERED, MAX_FAULTS, MIN_FAULT_PERIOD, VERIFY_STATUS, VERIFY_TIME,
};
use crate::emulator::rng::JitterRng;

#[derive(Debug, Clone)]
struct ScheduledLaserFault {
    fault: LaserFault,
    at: Duration,
    duration: Option<Duration>,
    /// `None`: without end.
    count_left: Option<u32>,
    every: Duration,
    /// Not again before.
    not_before: Duration,
}

impl ScheduledLaserFault {
    fn until(&self) -> Option<Duration> {
        if self.fault.is_effect_lasting() {
            return None;
        }
        self.duration
            .and_then(|duration| self.at.checked_add(duration))
    }

    fn is_active(&self, t: Duration) -> bool {
        t >= self.at.max(self.not_before)
            && self.count_left != Some(0)
            && self.until().is_none_or(|until| t < until)
    }

    fn is_over(&self, t: Duration) -> bool {
        self.count_left == Some(0) || self.until().is_some_and(|until| t >= until)
    }
}

#[derive(Debug, Clone, Default)]
pub(in crate::emulator) struct LaserFaultSchedule {
    faults: Vec<ScheduledLaserFault>,
}

impl LaserFaultSchedule {
    /// Adds a fault; drops the oldest if there are too many.
    pub(in crate::emulator) fn inject(&mut self, spec: LaserFaultSpec, now: Duration) {
        self.faults.retain(|scheduled| !scheduled.is_over(now));
        if self.faults.len() >= MAX_FAULTS {
            self.faults.remove(0);
        }
        let LaserFaultSpec { fault, times } = spec;
        let is_single = fault.is_event() && !fault.comes_in_bursts();
        let endless = times.lasting.is_some() && !fault.is_effect_lasting() && !is_single;
        let default_count = if endless { None } else { fault.default_count() };
        self.faults.push(ScheduledLaserFault {
            fault,
            at: times.start(now),
            duration: times.lasting,
            count_left: times.count.or(default_count),
            every: times
                .every
                .map_or(fault.default_period(), |every| every.max(MIN_FAULT_PERIOD)),
            not_before: Duration::ZERO,
        });
    }

    /// Ends the faults that a power cycle cures.
    pub(in crate::emulator) fn power_cycled(&mut self, now: Duration) {
        self.faults.retain(|scheduled| {
            !(scheduled.fault.is_cured_by_power()
                && scheduled.is_active(now)
                && scheduled.duration.is_none()
                && scheduled.count_left.is_none())
        });
    }

    fn consume(&mut self, kind: LaserFault, t: Duration) -> Option<ScheduledLaserFault> {
        let scheduled = self.faults.iter_mut().find(|scheduled| {
            discriminant(&scheduled.fault) == discriminant(&kind) && scheduled.is_active(t)
        })?;
        scheduled.count_left = scheduled.count_left.map(|left| left.saturating_sub(1));
        scheduled.not_before = t.saturating_add(scheduled.every);
        Some(scheduled.clone())
    }

    /// Whether this fault affects the reply or scan at `t`. Counts it.
    pub(in crate::emulator) fn happens(&mut self, kind: LaserFault, t: Duration) -> bool {
        self.consume(kind, t).is_some()
    }

    /// Status and duration, if the stream stops to verify an error.
    pub(in crate::emulator) fn verification(&mut self, t: Duration) -> Option<(u8, Duration)> {
        let scheduled = self.consume(
            LaserFault::Verify {
                status: VERIFY_STATUS,
            },
            t,
        )?;
        match scheduled.fault {
            LaserFault::Verify { status } => {
                Some((status, scheduled.duration.unwrap_or(VERIFY_TIME)))
            }
            _ => None,
        }
    }

    fn next(&self) -> Option<&ScheduledLaserFault> {
        let waiting = self
            .faults
            .iter()
            .filter(|scheduled| scheduled.fault.is_event() && !scheduled.is_over(scheduled.at));
        waiting.min_by_key(|scheduled| scheduled.at)
    }

    /// When the next fault is due that does not wait for a reply or scan.
    pub(in crate::emulator) fn next_event(&self) -> Option<Duration> {
        self.next().map(|scheduled| scheduled.at)
    }

    /// The next fault due at or before `t`, and the duration of its effect.
    pub(in crate::emulator) fn take_due(
        &mut self,
        t: Duration,
    ) -> Option<(LaserFault, Option<Duration>)> {
        let at = self.next_event().filter(|at| *at <= t)?;
        let scheduled = self.faults.iter_mut().find(|scheduled| {
            scheduled.fault.is_event() && scheduled.at == at && !scheduled.is_over(at)
        })?;
        let happened = (scheduled.fault, scheduled.duration);
        let until = scheduled.until();
        scheduled.count_left = scheduled.count_left.map(|left| left.saturating_sub(1));
        scheduled.at = scheduled.at.saturating_add(scheduled.every);
        if let Some(until) = until {
            scheduled.duration = Some(until.saturating_sub(scheduled.at));
        }
        self.faults
            .retain(|scheduled| !scheduled.is_over(scheduled.at));
        Some(happened)
    }

    /// Covers the window, or its left half: the steps from straight ahead on.
    pub(in crate::emulator) fn cover(
        &mut self,
        ranges: &mut [u32],
        front_step: usize,
        t: Duration,
    ) {
        if self.happens(LaserFault::Covered, t) {
            ranges.fill(CODE_COVERED);
        } else if self.happens(LaserFault::HalfCovered, t) {
            ranges
                .get_mut(front_step..)
                .unwrap_or_default()
                .fill(CODE_COVERED);
        }
    }

    pub(in crate::emulator) fn corrupt_version(&mut self, lines: &mut Vec<u8>, t: Duration) {
        if self.happens(LaserFault::OddVersion, t) {
            if let [.., sum, b'\n'] = lines.as_mut_slice() {
                *sum = (sum.wrapping_sub(0x30) ^ 1).wrapping_add(0x30);
            }
            lines.extend_from_slice(b"I\n");
        }
        if self.happens(LaserFault::TornVersion, t) {
            lines.truncate(lines.len() / 2);
        }
    }

    pub(in crate::emulator) fn corrupt_scan(
        &mut self,
        reply: &mut Vec<u8>,
        t: Duration,
        rng: &mut JitterRng,
    ) {
        if self.happens(LaserFault::BadSum, t) {
            // The sum is before the LF. The echo has none, the last line is empty.
            let ends: Vec<usize> = (1..reply.len())
                .filter(|end| reply[*end] == b'\n' && reply[*end - 1] != b'\n')
                .collect();
            let line = rng.between(1, (ends.len() as u64).saturating_sub(1).max(1)) as usize;
            if let Some(sum) = ends.get(line).and_then(|end| reply.get_mut(end - 1)) {
                *sum = (sum.wrapping_sub(0x30) ^ 1).wrapping_add(0x30);
            }
        }
        if self.happens(LaserFault::BitFlip, t) && !reply.is_empty() {
            let at = rng.between(0, reply.len() as u64 - 1) as usize;
            if let Some(byte) = reply.get_mut(at) {
                *byte ^= 1 << rng.between(0, 7);
            }
        }
        if self.happens(LaserFault::DroppedByte, t) && !reply.is_empty() {
            reply.remove(rng.between(0, reply.len() as u64 - 1) as usize);
        }
        if self.happens(LaserFault::TruncatedScan, t) {
            let length = reply.len() as u64;
            reply.truncate(rng.between(length / 4, 3 * length / 4) as usize);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: Duration = Duration::from_secs(1);

    fn spec(text: &str) -> LaserFaultSpec {
        text.parse().expect("a fault")
    }

    /// The instants of what is due by itself, ms.
    fn instants(schedule: &mut LaserFaultSchedule) -> Vec<u128> {
        let mut all = Vec::new();
        while let Some(at) = schedule.next_event() {
            assert!(schedule.take_due(at).is_some());
            all.push(at.as_millis());
        }
        all
    }

    #[test]
    fn every_parts_what_happens_again() {
        let mut schedule = LaserFaultSchedule::default();
        for (text, expected) in [
            ("garbage:count=3,every=2s", &[0, 2000, 4000][..]),
            ("garbage:for=1,every=400ms", &[0, 400, 800]),
            ("brown-out:at=1,count=2", &[1000, 2000]),
            ("timer-jump:count=2,every=0.25", &[0, 250]),
            ("hardware:for=9,count=2", &[0, 1000]),
            ("brown-out:at=500ms", &[500]),
            ("left-streaming:for=9", &[0]),
        ] {
            schedule.inject(spec(text), Duration::ZERO);
            assert_eq!(instants(&mut schedule), expected, "{text}");
        }
        schedule.inject(spec("bad-sum:count=2,every=1"), Duration::ZERO);
        let struck: Vec<bool> = [0, 1, 3, 4, 5, 9]
            .map(|quarter| schedule.happens(LaserFault::BadSum, S * quarter / 4))
            .into();
        assert_eq!(struck, [true, false, false, true, false, false]);
    }

    #[test]
    fn count_and_duration() {
        let mut schedule = LaserFaultSchedule::default();
        schedule.inject(spec("bad-sum:at=1,count=2"), Duration::ZERO);
        assert!(!schedule.happens(LaserFault::BadSum, S / 2));
        assert!(
            schedule.happens(LaserFault::BadSum, S) && schedule.happens(LaserFault::BadSum, 9 * S)
        );
        assert!(!schedule.happens(LaserFault::BadSum, 9 * S));
        schedule.inject(spec("silence:at=1,for=1"), 10 * S);
        assert!(
            schedule.happens(LaserFault::Silence, 10 * S)
                && schedule.happens(LaserFault::Silence, 10 * S + S / 2)
        );
        assert!(!schedule.happens(LaserFault::Silence, 11 * S));
    }

    #[test]
    fn garbage_comes_in_bursts() {
        let mut schedule = LaserFaultSchedule::default();
        schedule.inject(spec("garbage:at=1,count=3"), Duration::ZERO);
        let mut bursts = Vec::new();
        while let Some(at) = schedule.next_event() {
            assert!(schedule.take_due(at).is_some());
            bursts.push(at.as_millis());
        }
        assert_eq!(bursts, [1000, 1100, 1200]);
        schedule.inject("garbage:for=0.25".parse().expect("known"), 2 * S);
        let mut bursts = 0;
        while let Some(at) = schedule.next_event() {
            assert!(schedule.take_due(at).is_some());
            bursts += 1;
        }
        assert_eq!(bursts, 3);
        assert!(schedule.faults.is_empty());
    }

    #[test]
    fn the_number_of_faults_is_limited() {
        let mut schedule = LaserFaultSchedule::default();
        for _ in 0..10_000 {
            schedule.inject(LaserFault::Covered.into(), S);
        }
        assert_eq!(schedule.faults.len(), MAX_FAULTS);
    }
}
