//! Faults that wait, strike and last.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{FaultKind, FaultSpec};
use crate::twin::Instant;
use crate::twin::constants::{FAULTS, MIN_PERIOD};
use crate::twin::names::AxisName;

/// A one-time effect that is due.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::twin) enum Strike {
    /// The rotor of an axis jumps.
    Lose(AxisName, i32),
    /// `!` and this letter.
    Event(char),
    /// A line.
    Text(String),
    /// Echo on.
    Echo,
    /// Verbose on.
    Verbose,
    /// As a command of somebody else would have it.
    Meddle(FaultKind),
    /// Power off until the instant.
    PowerCycle(Instant),
}

#[derive(Debug)]
struct Pending {
    spec: FaultSpec,
    /// Next strike of a one-time fault, or the start of a lasting one.
    at: Instant,
    /// End of a lasting one.
    until: Instant,
    left: u32,
    skipped: u32,
}

/// All faults of one twin.
#[derive(Debug, Default)]
pub(in crate::twin) struct Board {
    faults: Vec<Pending>,
}

fn one_time(kind: &FaultKind) -> bool {
    matches!(
        kind,
        FaultKind::LostSteps { .. }
            | FaultKind::Event { within: None, .. }
            | FaultKind::Text(_)
            | FaultKind::Echo
            | FaultKind::Verbose
            | FaultKind::Velocity
            | FaultKind::Slaved
            | FaultKind::LimitsOff
            | FaultKind::Monitor
            | FaultKind::Moving(_)
            | FaultKind::UnitId(_)
            | FaultKind::Baud(_)
            | FaultKind::AxisError
            | FaultKind::PowerCycle
    )
}

impl Board {
    /// Adds a fault.
    pub(in crate::twin) fn add(&mut self, mut spec: FaultSpec, now: Instant) {
        spec.every = spec.every.max(MIN_PERIOD);
        if self.faults.len() < FAULTS {
            let at = spec.at.unwrap_or(now).max(now);
            let until = spec.lasting.map_or(Instant::MAX, |d| at.saturating_add(d));
            let left = spec.count;
            self.faults.push(Pending {
                spec,
                at,
                until,
                left,
                skipped: 0,
            });
        }
    }

    /// When something begins, strikes or ends next, after `now` or, for what is due, at once.
    pub(in crate::twin) fn next_at(&self, now: Instant) -> Option<Instant> {
        self.faults
            .iter()
            .map(|f| {
                if one_time(&f.spec.kind) || f.at > now {
                    f.at
                } else {
                    f.until
                }
            })
            .filter(|at| *at != Instant::MAX)
            .min()
    }

    /// The strikes that are due; forgets what is over.
    pub(in crate::twin) fn strike(&mut self, now: Instant) -> Vec<Strike> {
        let mut strikes = Vec::new();
        for fault in &mut self.faults {
            if !one_time(&fault.spec.kind) || fault.at > now {
                continue;
            }
            match &fault.spec.kind {
                _ if fault.left == 0 => {}
                FaultKind::LostSteps { axes, steps } => {
                    strikes.extend(axes.iter().map(|a| Strike::Lose(*a, *steps)))
                }
                FaultKind::Event { which, .. } => strikes.push(Strike::Event(*which)),
                FaultKind::Text(text) => strikes.push(Strike::Text(text.clone())),
                FaultKind::Echo => strikes.push(Strike::Echo),
                FaultKind::Verbose => strikes.push(Strike::Verbose),
                FaultKind::PowerCycle => strikes.push(Strike::PowerCycle(
                    fault.spec.lasting.map_or(now, |_| fault.until),
                )),
                meddling => strikes.push(Strike::Meddle(meddling.clone())),
            }
            fault.left = fault.left.saturating_sub(1);
            fault.at = fault.at.saturating_add(fault.spec.every);
        }
        self.faults
            .retain(|f| f.left > 0 && (one_time(&f.spec.kind) || f.until > now));
        strikes
    }

    fn active(&self, now: Instant) -> impl Iterator<Item = &FaultKind> {
        self.faults
            .iter()
            .filter(move |f| f.at <= now && now < f.until)
            .map(|f| &f.spec.kind)
    }

    /// What hinders one axis: stalled, blocked, factor on speed.
    pub(in crate::twin) fn hindrance(&self, axis: AxisName, now: Instant) -> (bool, bool, f64) {
        let (mut stalled, mut blocked, mut pace) = (false, false, 1.0);
        for kind in self.active(now) {
            match kind {
                FaultKind::Stuck { axes, hidden } if axes.contains(&axis) => {
                    stalled |= !hidden;
                    blocked |= hidden;
                }
                FaultKind::Slow { axes, factor } if axes.contains(&axis) => pace *= factor,
                _ => {}
            }
        }
        (stalled, blocked, f64::max(pace, 1e-3))
    }

    /// How far an axis runs past its targets, counts.
    pub(in crate::twin) fn overshoot(&self, axis: AxisName, now: Instant) -> i32 {
        self.active(now)
            .find_map(|kind| match kind {
                FaultKind::Overshoot { axes, steps } if axes.contains(&axis) => Some(*steps),
                _ => None,
            })
            .unwrap_or(0)
    }

    /// What `O` is made to tell: volts, degrees Fahrenheit.
    pub(in crate::twin) fn supply(&self, now: Instant) -> Option<(f64, f64)> {
        self.active(now).find_map(|kind| match kind {
            FaultKind::Supply { volts, degf } => Some((*volts, *degf)),
            _ => None,
        })
    }

    /// The event that stands before the next output byte, if one waits for its place there; counts the byte.
    pub(in crate::twin) fn intrude(&mut self, now: Instant) -> Option<[u8; 2]> {
        for fault in &mut self.faults {
            let FaultKind::Event {
                which,
                within: Some(within),
            } = fault.spec.kind
            else {
                continue;
            };
            if fault.at > now || now >= fault.until || fault.left == 0 {
                continue;
            }
            if fault.skipped < within {
                fault.skipped += 1;
                continue;
            }
            // The byte it stands before is the first of those that pass before the next one.
            fault.skipped = 1;
            fault.left -= 1;
            return Some([b'!', which as u8]);
        }
        None
    }

    /// Whether the next calibration fails; counts it.
    pub(in crate::twin) fn reset_fails(&mut self, now: Instant) -> bool {
        let failing = |f: &&mut Pending| {
            f.spec.kind == FaultKind::ResetFails && f.at <= now && now < f.until && f.left > 0
        };
        let Some(fault) = self.faults.iter_mut().find(failing) else {
            return false;
        };
        fault.left -= 1;
        true
    }

    /// A byte from the host, as it arrives; `None` if it does not.
    pub(in crate::twin) fn hear(&self, byte: u8, now: Instant, rng: &mut ChaCha8Rng) -> Option<u8> {
        let mut heard = byte;
        for kind in self.active(now) {
            match kind {
                FaultKind::Silence { deaf: true } => return None,
                FaultKind::WrongBaud => heard = rng.random(),
                _ => {}
            }
        }
        Some(heard)
    }

    /// A byte of the unit, as it reaches the host; `None` if it does not.
    pub(in crate::twin) fn say(
        &mut self,
        byte: u8,
        now: Instant,
        rng: &mut ChaCha8Rng,
    ) -> Option<u8> {
        let mut said = Some(byte);
        for fault in self
            .faults
            .iter_mut()
            .filter(|f| f.at <= now && now < f.until)
        {
            match fault.spec.kind {
                FaultKind::Silence { .. } => return None,
                FaultKind::WrongBaud => said = said.map(|_| rng.random()),
                FaultKind::LostByte { skip } | FaultKind::GarbageByte { skip }
                    if fault.left > 0 =>
                {
                    if fault.skipped < skip {
                        fault.skipped += 1;
                        continue;
                    }
                    fault.skipped = 0;
                    fault.left -= 1;
                    let lost = matches!(fault.spec.kind, FaultKind::LostByte { .. });
                    said = if lost {
                        None
                    } else {
                        said.map(|b| b ^ rng.random_range(1..=255_u8))
                    };
                }
                _ => {}
            }
        }
        said
    }
}
