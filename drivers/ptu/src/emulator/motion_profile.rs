//! The motion profile of one axis: segments of constant acceleration in closed form (ptu-d46 section 9).
//!
//! At or below the base speed an axis starts, stops and reverses at once; above it the speed ramps.

/// The speeds that shape a motion. Positions/s and positions/s^2, all positive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SpeedRamp {
    pub speed: f64,
    /// Base speed: no ramp at or below it.
    pub base: f64,
    /// Acceleration above the base speed.
    pub acceleration: f64,
}

/// A segment of constant acceleration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ProfileSegment {
    /// Seconds.
    pub duration: f64,
    /// Signed speed at its start.
    pub v0: f64,
    /// Signed acceleration.
    pub a: f64,
    /// Signed travel.
    pub distance: f64,
}

impl ProfileSegment {
    /// The time after which it has travelled `distance` (signed like the segment), seconds; 0 if it starts beyond.
    pub(super) fn time_to_distance(&self, distance: f64) -> f64 {
        let (d, v, a) = (
            distance.abs(),
            self.v0.abs(),
            self.a * self.distance.signum(),
        );
        if distance * self.distance <= 0.0 {
            return 0.0;
        }
        let root = (v * v + 2.0 * a * d).max(0.0).sqrt();
        (2.0 * d / (v + root)).min(self.duration)
    }
}

/// Shorter travel is ignored, counts.
const MIN_TRAVEL: f64 = 1e-9;

/// Distance needed to brake from `v` to the base speed (ptu-d46 section 9).
pub(super) fn brake_distance(v: f64, ramp: &SpeedRamp) -> f64 {
    if v.abs() > ramp.base {
        (v * v - ramp.base * ramp.base) / (2.0 * ramp.acceleration)
    } else {
        0.0
    }
}

/// The segments from position `p` at speed `v` to rest at `target`.
pub(super) fn plan(p: f64, v: f64, target: f64, ramp: &SpeedRamp) -> Vec<ProfileSegment> {
    let mut segments = Vec::with_capacity(4);
    let (mut p, mut v) = (p, v);
    let brake = brake_distance(v, ramp);
    let away = (target - p) * v <= 0.0;
    if brake > 0.0 && (away || (target - p).abs() < brake - MIN_TRAVEL) {
        push_ramp(
            &mut segments,
            v.signum(),
            v.abs(),
            ramp.base,
            ramp.acceleration,
        );
        p += v.signum() * brake;
        v = 0.0;
    }
    let travel = target - p;
    if travel.abs() > MIN_TRAVEL {
        push_approach(
            &mut segments,
            travel.signum(),
            travel.abs(),
            (v * travel.signum()).max(0.0),
            ramp,
        );
    }
    segments
}

/// Adds the segments over `distance` in direction `dir`, entered at a speed `v >= 0` that leaves room to brake.
fn push_approach(
    segments: &mut Vec<ProfileSegment>,
    dir: f64,
    distance: f64,
    v: f64,
    ramp: &SpeedRamp,
) {
    let SpeedRamp {
        speed,
        base,
        acceleration,
    } = *ramp;
    if speed <= base {
        if v > base {
            push_ramp(segments, dir, v, base, acceleration);
        }
        push_cruise(segments, dir, speed, distance - brake_distance(v, ramp));
        return;
    }
    let entry = v.max(base);
    let peak = if entry <= speed {
        speed
            .min(
                ((2.0 * acceleration * distance + entry * entry + base * base) / 2.0)
                    .max(0.0)
                    .sqrt(),
            )
            .max(entry)
    } else {
        speed
    };
    let up = (peak * peak - entry * entry).abs() / (2.0 * acceleration);
    let down = (peak * peak - base * base) / (2.0 * acceleration);
    push_ramp(segments, dir, entry, peak, acceleration);
    push_cruise(segments, dir, peak, distance - up - down);
    push_ramp(segments, dir, peak, base, acceleration);
}

fn push_ramp(segments: &mut Vec<ProfileSegment>, dir: f64, from: f64, to: f64, acceleration: f64) {
    if from != to {
        let duration = (to - from).abs() / acceleration;
        let a = (to - from).signum() * acceleration;
        segments.push(ProfileSegment {
            duration,
            v0: dir * from,
            a: dir * a,
            distance: dir * (from + to) / 2.0 * duration,
        });
    }
}

fn push_cruise(segments: &mut Vec<ProfileSegment>, dir: f64, speed: f64, distance: f64) {
    if distance > MIN_TRAVEL {
        segments.push(ProfileSegment {
            duration: distance / speed,
            v0: dir * speed,
            a: 0.0,
            distance: dir * distance,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn total(segments: &[ProfileSegment]) -> (f64, f64) {
        segments
            .iter()
            .fold((0.0, 0.0), |(t, d), l| (t + l.duration, d + l.distance))
    }

    fn at(segments: &[ProfileSegment], t: f64) -> f64 {
        let (mut left, mut p) = (t, 0.0);
        for segment in segments {
            if left < segment.duration {
                return p + segment.v0 * left + segment.a * left * left / 2.0;
            }
            left -= segment.duration;
            p += segment.distance;
        }
        p
    }

    #[test]
    fn closed_form_examples() {
        let ramp = SpeedRamp {
            speed: 1900.0,
            base: 1000.0,
            acceleration: 2000.0,
        };
        let (t, d) = total(&plan(0.0, 0.0, 2600.0, &ramp));
        // tr = 0.45 s over 652.5 each way, the other 1295 at 1900.
        assert!(
            (t - (0.9 + 1295.0 / 1900.0)).abs() < 1e-12
                && (t - 1.58).abs() < 0.002
                && (d - 2600.0).abs() < 1e-9
        );
        let (t, _) = total(&plan(
            0.0,
            0.0,
            -500.0,
            &SpeedRamp {
                speed: 97.0,
                ..ramp
            },
        ));
        assert!(
            (t - 500.0 / 97.0).abs() < 1e-12,
            "below base there is no ramp"
        );
        let (t, d) = total(&plan(0.0, 0.0, 600.0, &ramp));
        let peak = f64::sqrt(1000.0 * 1000.0 + 2000.0 * 600.0);
        assert!((t - 2.0 * (peak - 1000.0) / 2000.0).abs() < 1e-12 && (d - 600.0).abs() < 1e-9);
    }

    #[test]
    fn too_late_to_brake_overshoots_and_returns() {
        let ramp = SpeedRamp {
            speed: 2000.0,
            base: 100.0,
            acceleration: 1000.0,
        };
        let segments = plan(0.0, 2000.0, 500.0, &ramp);
        assert!((total(&segments).1 - 500.0).abs() < 1e-9);
        let furthest = (0..400)
            .map(|i| at(&segments, f64::from(i) * 0.01))
            .fold(0.0, f64::max);
        assert!(
            (furthest - 1995.0).abs() < 1.0,
            "brakes over (v^2-b^2)/2a, got {furthest}"
        );
    }

    /// The rule of ptu-d46 section 9, tick by tick: brake when the remaining travel is the brake distance or the sign is wrong.
    fn integrate(v0: f64, target: f64, ramp: &SpeedRamp, until: f64, tick: f64) -> Vec<f64> {
        let (mut p, mut v) = (0.0_f64, v0);
        let mut trace = vec![p];
        let mut committed =
            v.abs() > ramp.base && ((target * v <= 0.0) || target.abs() < brake_distance(v, ramp));
        for _ in 0..(until / tick) as usize {
            let dir = (target - p).signum();
            if committed {
                let slower = v.abs() - ramp.acceleration * tick;
                v = v.signum() * slower.max(ramp.base);
                if slower <= ramp.base {
                    p += v * tick;
                    committed = false;
                    v = 0.0;
                    trace.push(p);
                    continue;
                }
            } else if (target - p).abs() > 1e-9 {
                let along = (v * dir).max(0.0);
                let wanted = if (target - p).abs() <= brake_distance(along, ramp) {
                    ramp.base.min(ramp.speed)
                } else {
                    ramp.speed
                };
                let entry = along.max(ramp.base.min(ramp.speed));
                let next = if along > ramp.base || wanted > ramp.base {
                    if wanted > entry {
                        (entry + ramp.acceleration * tick).min(wanted)
                    } else {
                        (entry - ramp.acceleration * tick).max(wanted)
                    }
                } else {
                    wanted
                };
                v = dir * next;
            }
            let next = p + v * tick;
            if !committed && (target - p) * (target - next) <= 0.0 {
                p = target;
                v = 0.0;
            } else {
                p = next;
            }
            trace.push(p);
        }
        trace
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn closed_form_agrees_with_ticks(speed in 31.0..2902.0_f64, base in 57.0..1500.0_f64, acceleration in 500.0..4000.0_f64,
                                        target in -3000.0..3000.0_f64, entry in -1.0..1.0_f64) {
            let ramp = SpeedRamp { speed, base, acceleration };
            let v0 = entry * 2902.0;
            let segments = plan(0.0, v0, target, &ramp);
            let (t, d) = total(&segments);
            prop_assert!((d - target).abs() < 1e-6);
            let tick = 2e-5;
            for (i, p) in integrate(v0, target, &ramp, t.min(20.0) + 0.1, tick).iter().enumerate() {
                let exact = at(&segments, i as f64 * tick);
                prop_assert!((p - exact).abs() <= 1.0, "t={} ticks {} closed {}", i as f64 * tick, p, exact);
            }
        }

        #[test]
        fn speed_never_jumps_above_base(speed in 31.0..2902.0_f64, base in 57.0..1500.0_f64, target in -3000.0..3000.0_f64, v0 in -2902.0..2902.0_f64) {
            let ramp = SpeedRamp { speed, base, acceleration: 2000.0 };
            let mut v = v0;
            for segment in plan(0.0, v0, target, &ramp) {
                prop_assert!(segment.duration >= 0.0 && segment.duration.is_finite());
                if (v - segment.v0).abs() > 1e-6 {
                    prop_assert!(v.abs() <= base + 1e-6 && segment.v0.abs() <= base + 1e-6, "jump from {} to {}", v, segment.v0);
                }
                v = segment.v0 + segment.a * segment.duration;
            }
            prop_assert!(v.abs() <= base + 1e-6);
        }
    }
}
