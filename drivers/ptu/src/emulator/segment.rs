//! A segment of constant acceleration of the count, and the rotor's position meanwhile.

use std::time::Duration;

/// The rotor's relation to the count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Rotor {
    /// Count plus this offset by lost steps.
    Follows(f64),
    /// Held at this count by a stop or a blockage.
    Held(f64),
}

/// A segment of constant acceleration; positions and speeds in counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MotionSegment {
    pub start: Duration,
    pub end: Duration,
    pub p0: f64,
    pub v0: f64,
    pub a: f64,
    /// Count at `end`, exact.
    pub p1: f64,
    pub rotor: Rotor,
    /// The rotor hits a stop at `start`.
    pub contact: bool,
    pub counts_per_half_step: f64,
}

impl MotionSegment {
    pub(super) fn count_at(&self, at: Duration) -> f64 {
        if at >= self.end {
            return self.p1;
        }
        let t = at.saturating_sub(self.start).as_secs_f64();
        self.p0 + self.v0 * t + self.a * t * t / 2.0
    }

    pub(super) fn speed_at(&self, at: Duration) -> f64 {
        self.v0 + self.a * at.min(self.end).saturating_sub(self.start).as_secs_f64()
    }

    /// Position of the rotor, half steps.
    pub(super) fn true_half_steps(&self, at: Duration, whole: bool) -> f64 {
        let counts = match self.rotor {
            Rotor::Held(at) => at,
            Rotor::Follows(lost) if whole => self.count_at(at).round() + lost,
            Rotor::Follows(lost) => self.count_at(at) + lost,
        };
        counts / self.counts_per_half_step
    }
}

/// The rotor after a segment that ended at count `p`. A held one stays where it is and follows from there, unless `blocked`.
pub(super) fn rotor_after(rotor: Rotor, p: f64, blocked: bool) -> Rotor {
    match rotor {
        Rotor::Held(at) if !blocked => Rotor::Follows(at - p.round()),
        Rotor::Follows(lost) if blocked => Rotor::Held(p.round() + lost),
        same => same,
    }
}

/// At rest at count `p`, without an end.
pub(super) fn rest_segment(
    now: Duration,
    p: f64,
    rotor: Rotor,
    counts_per_half_step: f64,
) -> MotionSegment {
    MotionSegment {
        start: now,
        end: Duration::MAX,
        p0: p,
        v0: 0.0,
        a: 0.0,
        p1: p,
        rotor,
        contact: false,
        counts_per_half_step,
    }
}

/// Offset of the head from the rotor at `at`, half steps: the head lags by half of `backlash` in the direction of travel, and is
/// in transition while a reversed rotor crosses the play. `segments` go backwards in time; before them the axis moved in
/// direction `heading`.
pub(super) fn backlash_offset<'a>(
    segments: impl Iterator<Item = &'a MotionSegment>,
    at: Duration,
    backlash: f64,
    heading: f64,
) -> f64 {
    let (mut direction, mut travelled, mut reversed) = (0.0, 0.0, false);
    for segment in segments.filter(|s| s.start <= at) {
        let moved = segment.count_at(at) - segment.p0;
        if moved.abs() < 1e-9 {
            continue;
        }
        reversed = direction != 0.0 && moved.signum() != direction;
        if reversed || travelled > backlash {
            break;
        }
        direction = moved.signum();
        travelled += moved.abs() / segment.counts_per_half_step;
    }
    if direction == 0.0 {
        direction = heading;
    }
    if !reversed && (heading == direction || heading == 0.0) {
        travelled = backlash;
    }
    direction * (backlash / 2.0 - travelled.min(backlash))
}

#[cfg(test)]
mod tests {
    use super::{MotionSegment, Rotor, backlash_offset, rest_segment};
    use std::time::Duration;

    #[test]
    fn the_head_lags_by_half_the_play_and_crosses_it_after_a_reversal() {
        let s = Duration::from_secs;
        let moving = |start: u64, p0: f64, v0: f64| MotionSegment {
            start: s(start),
            end: s(start + 10),
            v0,
            p1: p0 + 10.0 * v0,
            ..rest_segment(s(start), p0, Rotor::Follows(0.0), 1.0)
        };
        let (up, down) = (moving(0, 0.0, 1.0), moving(10, 10.0, -1.0));
        let ahead = |at: f64| {
            backlash_offset(
                [&down, &up].into_iter(),
                Duration::from_secs_f64(at),
                4.0,
                0.0,
            )
        };
        assert_eq!(
            [5.0, 10.0, 12.0, 14.0, 19.0].map(ahead),
            [-2.0, -2.0, 0.0, 2.0, 2.0]
        );
        let still = rest_segment(s(20), 0.0, Rotor::Follows(0.0), 1.0);
        let at_rest = |heading| backlash_offset(std::iter::once(&still), s(30), 4.0, heading);
        assert_eq!([-1.0, 0.0, 1.0].map(at_rest), [2.0, 0.0, -2.0]);
    }
}
