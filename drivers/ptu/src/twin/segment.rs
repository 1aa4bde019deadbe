//! A piece of constant acceleration of the count, and where the rotor is meanwhile.

use super::Instant;

/// Where the rotor is while the count runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Rotor {
    /// Count plus this many lost steps.
    Follows(f64),
    /// Held at this count by a stop or a blockage.
    Held(f64),
}

/// A piece of constant acceleration of the count, and what the rotor does meanwhile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Segment {
    pub start: Instant,
    pub end: Instant,
    pub p0: f64,
    pub v0: f64,
    pub a: f64,
    /// Count at `end`, exact.
    pub p1: f64,
    pub rotor: Rotor,
    /// The rotor meets a stop at `start`.
    pub contact: bool,
    pub counts_per_half_step: f64,
}

impl Segment {
    /// The count at an instant of the segment.
    pub(super) fn count_at(&self, at: Instant) -> f64 {
        if at >= self.end {
            return self.p1;
        }
        let t = at.saturating_sub(self.start).as_secs_f64();
        self.p0 + self.v0 * t + self.a * t * t / 2.0
    }

    /// Signed speed of the count.
    pub(super) fn speed_at(&self, at: Instant) -> f64 {
        self.v0 + self.a * at.min(self.end).saturating_sub(self.start).as_secs_f64()
    }

    /// Where the rotor is, half steps.
    pub(super) fn true_half_steps(&self, at: Instant, whole: bool) -> f64 {
        let counts = match self.rotor {
            Rotor::Held(at) => at,
            Rotor::Follows(lost) if whole => self.count_at(at).round() + lost,
            Rotor::Follows(lost) => self.count_at(at) + lost,
        };
        counts / self.counts_per_half_step
    }
}

/// The rotor after a segment that ended at count `p`: a held one stays where it is and follows from there.
pub(super) fn settled(rotor: Rotor, p: f64, blocked: bool) -> Rotor {
    match rotor {
        Rotor::Held(at) if !blocked => Rotor::Follows(at - p.round()),
        Rotor::Follows(lost) if blocked => Rotor::Held(p.round() + lost),
        same => same,
    }
}

/// Standing at count `p` until further notice.
pub(super) fn rest(now: Instant, p: f64, rotor: Rotor, counts_per_half_step: f64) -> Segment {
    Segment {
        start: now,
        end: Instant::MAX,
        p0: p,
        v0: 0.0,
        a: 0.0,
        p1: p,
        rotor,
        contact: false,
        counts_per_half_step,
    }
}

/// How far the head is ahead of the rotor at `at`, half steps: half of `backlash` behind in the direction of travel, on the
/// way there while a reversed rotor crosses the play. `segments` go backwards in time; before them the axis went `heading`.
pub(super) fn play<'a>(
    segments: impl Iterator<Item = &'a Segment>,
    at: Instant,
    backlash: f64,
    heading: f64,
) -> f64 {
    let (mut way, mut travelled, mut reversed) = (0.0, 0.0, false);
    for segment in segments.filter(|s| s.start <= at) {
        let moved = segment.count_at(at) - segment.p0;
        if moved.abs() < 1e-9 {
            continue;
        }
        reversed = way != 0.0 && moved.signum() != way;
        if reversed || travelled > backlash {
            break;
        }
        way = moved.signum();
        travelled += moved.abs() / segment.counts_per_half_step;
    }
    if way == 0.0 {
        way = heading;
    }
    if !reversed && (heading == way || heading == 0.0) {
        travelled = backlash;
    }
    way * (backlash / 2.0 - travelled.min(backlash))
}

#[cfg(test)]
mod tests {
    use super::{Rotor, Segment, play, rest};
    use std::time::Duration;

    #[test]
    fn the_head_lags_by_half_the_play_and_crosses_it_after_a_reversal() {
        let s = Duration::from_secs;
        let moving = |start: u64, p0: f64, v0: f64| Segment {
            start: s(start),
            end: s(start + 10),
            v0,
            p1: p0 + 10.0 * v0,
            ..rest(s(start), p0, Rotor::Follows(0.0), 1.0)
        };
        let (up, down) = (moving(0, 0.0, 1.0), moving(10, 10.0, -1.0));
        let ahead = |at: f64| {
            play(
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
        let still = rest(s(20), 0.0, Rotor::Follows(0.0), 1.0);
        let at_rest = |heading| play(std::iter::once(&still), s(30), 4.0, heading);
        assert_eq!([-1.0, 0.0, 1.0].map(at_rest), [2.0, 0.0, -2.0]);
    }
}
