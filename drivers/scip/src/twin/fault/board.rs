//! The faults that are set, and what they do to what comes by.

use std::mem::discriminant;
use std::time::Duration;

use super::{Fault, FaultSpec};
use crate::twin::Instant;
use crate::twin::constants::{CODE_COVERED, GARBAGE_EVERY, MAX_FAULTS, VERIFY_STATUS, VERIFY_TIME};
use crate::twin::noise::Noise;

/// A fault that may still happen.
#[derive(Debug, Clone)]
struct Live {
    fault: Fault,
    at: Instant,
    lasting: Option<Duration>,
    /// `None`: without end.
    left: Option<u32>,
}

impl Live {
    fn until(&self) -> Option<Instant> {
        // For these `for` says how long the consequence lasts, not for how long it may begin.
        if matches!(self.fault, Fault::Verify { .. } | Fault::Hardware { .. }) {
            return None;
        }
        self.lasting
            .and_then(|lasting| self.at.checked_add(lasting))
    }

    fn holds(&self, t: Instant) -> bool {
        t >= self.at && self.left != Some(0) && self.until().is_none_or(|until| t < until)
    }

    fn is_over(&self, t: Instant) -> bool {
        self.left == Some(0) || self.until().is_some_and(|until| t >= until)
    }
}

/// The faults that are set.
#[derive(Debug, Clone, Default)]
pub(in crate::twin) struct FaultBoard {
    live: Vec<Live>,
}

impl FaultBoard {
    /// Sets a fault; the oldest goes if there are too many.
    pub(in crate::twin) fn inject(&mut self, spec: FaultSpec, now: Instant) {
        self.live.retain(|live| !live.is_over(now));
        if self.live.len() >= MAX_FAULTS {
            self.live.remove(0);
        }
        let FaultSpec {
            fault,
            at,
            lasting,
            count,
        } = spec;
        let consequence_lasts = matches!(fault, Fault::Verify { .. } | Fault::Hardware { .. });
        let left = if lasting.is_some() && !consequence_lasts {
            count
        } else {
            count.or(fault.default_count())
        };
        self.live.push(Live {
            fault,
            at: at.max(now),
            lasting,
            left,
        });
    }

    /// Ends what a power cycle ends: troubles of the firmware that nothing else limits.
    pub(in crate::twin) fn power_cycled(&mut self, now: Instant) {
        self.live.retain(|live| {
            !(live.fault.is_cured_by_power()
                && live.holds(now)
                && live.lasting.is_none()
                && live.left.is_none())
        });
    }

    fn use_up(&mut self, kind: Fault, t: Instant) -> Option<Live> {
        let live = self
            .live
            .iter_mut()
            .find(|live| discriminant(&live.fault) == discriminant(&kind) && live.holds(t))?;
        live.left = live.left.map(|left| left.saturating_sub(1));
        Some(live.clone())
    }

    /// Whether this fault happens to what comes by at `t`. Counts it.
    pub(in crate::twin) fn happens(&mut self, kind: Fault, t: Instant) -> bool {
        self.use_up(kind, t).is_some()
    }

    /// Whether the stream stops to verify an error: the status, and for how long.
    pub(in crate::twin) fn verification(&mut self, t: Instant) -> Option<(u8, Duration)> {
        let live = self.use_up(
            Fault::Verify {
                status: VERIFY_STATUS,
            },
            t,
        )?;
        match live.fault {
            Fault::Verify { status } => Some((status, live.lasting.unwrap_or(VERIFY_TIME))),
            _ => None,
        }
    }

    fn next(&self) -> Option<&Live> {
        let waiting = self
            .live
            .iter()
            .filter(|live| live.fault.is_event() && !live.is_over(live.at));
        waiting.min_by_key(|live| live.at)
    }

    /// When the next fault happens that does not wait for something to come by.
    pub(in crate::twin) fn next_event(&self) -> Option<Instant> {
        self.next().map(|live| live.at)
    }

    /// The fault that happens at or before `t`, and how long its consequence lasts.
    pub(in crate::twin) fn fire(&mut self, t: Instant) -> Option<(Fault, Option<Duration>)> {
        let at = self.next_event().filter(|at| *at <= t)?;
        let live = self
            .live
            .iter_mut()
            .find(|live| live.fault.is_event() && live.at == at && !live.is_over(at))?;
        let happened = (live.fault, live.lasting);
        if live.fault.comes_in_bursts() {
            let until = live.until();
            live.left = live.left.map(|left| left.saturating_sub(1));
            live.at += GARBAGE_EVERY;
            live.lasting = until.map(|until| until.saturating_sub(live.at));
        } else {
            live.left = Some(0);
        }
        self.live.retain(|live| !live.is_over(live.at));
        Some(happened)
    }

    /// Covers the window, wholly or from the step straight ahead on: the left half.
    pub(in crate::twin) fn cover(&mut self, ranges: &mut [u32], front_step: usize, t: Instant) {
        if self.happens(Fault::Covered, t) {
            ranges.fill(CODE_COVERED);
        } else if self.happens(Fault::HalfCovered, t) {
            ranges
                .get_mut(front_step..)
                .unwrap_or_default()
                .fill(CODE_COVERED);
        }
    }

    /// Spoils the lines of `VV`.
    pub(in crate::twin) fn spoil_version(&mut self, lines: &mut Vec<u8>, t: Instant) {
        if self.happens(Fault::OddVersion, t) {
            if let [.., sum, b'\n'] = lines.as_mut_slice() {
                *sum = (sum.wrapping_sub(0x30) ^ 1).wrapping_add(0x30);
            }
            lines.extend_from_slice(b"I\n");
        }
        if self.happens(Fault::TornVersion, t) {
            lines.truncate(lines.len() / 2);
        }
    }

    /// Spoils the bytes of a scan.
    pub(in crate::twin) fn spoil(&mut self, reply: &mut Vec<u8>, t: Instant, noise: &mut Noise) {
        if self.happens(Fault::BadSum, t) {
            // A line's sum stands before its LF. The echo (first) has none, the last line is empty.
            let ends: Vec<usize> = (1..reply.len())
                .filter(|end| reply[*end] == b'\n' && reply[*end - 1] != b'\n')
                .collect();
            let line = noise.between(1, (ends.len() as u64).saturating_sub(1).max(1)) as usize;
            if let Some(sum) = ends.get(line).and_then(|end| reply.get_mut(end - 1)) {
                *sum = (sum.wrapping_sub(0x30) ^ 1).wrapping_add(0x30);
            }
        }
        if self.happens(Fault::BitFlip, t) && !reply.is_empty() {
            let at = noise.between(0, reply.len() as u64 - 1) as usize;
            if let Some(byte) = reply.get_mut(at) {
                *byte ^= 1 << noise.between(0, 7);
            }
        }
        if self.happens(Fault::DroppedByte, t) && !reply.is_empty() {
            reply.remove(noise.between(0, reply.len() as u64 - 1) as usize);
        }
        if self.happens(Fault::TruncatedScan, t) {
            let length = reply.len() as u64;
            reply.truncate(noise.between(length / 4, 3 * length / 4) as usize);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: Duration = Duration::from_secs(1);

    #[test]
    fn count_window_and_both() {
        let mut board = FaultBoard::default();
        board.inject(
            FaultSpec {
                at: S,
                count: Some(2),
                lasting: None,
                fault: Fault::BadSum,
            },
            Duration::ZERO,
        );
        assert!(!board.happens(Fault::BadSum, S / 2));
        assert!(board.happens(Fault::BadSum, S) && board.happens(Fault::BadSum, 9 * S));
        assert!(!board.happens(Fault::BadSum, 9 * S));
        board.inject(
            FaultSpec {
                at: S,
                count: None,
                lasting: Some(S),
                fault: Fault::Silence,
            },
            10 * S,
        );
        assert!(
            board.happens(Fault::Silence, 10 * S) && board.happens(Fault::Silence, 10 * S + S / 2)
        );
        assert!(!board.happens(Fault::Silence, 11 * S));
    }

    #[test]
    fn garbage_comes_in_bursts() {
        let mut board = FaultBoard::default();
        board.inject(
            FaultSpec {
                at: S,
                count: Some(3),
                lasting: None,
                fault: Fault::Garbage,
            },
            Duration::ZERO,
        );
        let mut bursts = Vec::new();
        while let Some(at) = board.next_event() {
            assert!(board.fire(at).is_some());
            bursts.push(at.as_millis());
        }
        assert_eq!(bursts, [1000, 1100, 1200]);
        board.inject("garbage:for=0.25".parse().expect("known"), 2 * S);
        let mut bursts = 0;
        while let Some(at) = board.next_event() {
            assert!(board.fire(at).is_some());
            bursts += 1;
        }
        assert_eq!(bursts, 3);
        assert!(board.live.is_empty());
    }

    #[test]
    fn never_more_than_so_many() {
        let mut board = FaultBoard::default();
        for _ in 0..10_000 {
            board.inject(Fault::Covered.into(), S);
        }
        assert_eq!(board.live.len(), MAX_FAULTS);
    }
}
