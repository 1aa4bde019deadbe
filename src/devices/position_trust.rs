//! Whether the head's counts are angles. The head has no encoders: its counts are what was commanded since the last
//! calibration, as long as nothing contradicts them.
//!
//! This is the only place that knows. Everything that happens to the head is a [`TrustEvent`]; [`TrustState::after`] is the
//! table of transitions. One [`PositionTrust`] goes with one head for as long as the process lives, over all stations.

use super::constants::MAX_LIMIT_CHANGE_STEPS;
use super::power_marker::PowerMarker;
use ptu::{Axis, AxisLimits, HeadIdentity};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What is known about the position.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum TrustState {
    /// No head was connected yet.
    #[default]
    NotSeen,
    /// Counts are angles.
    Trusted,
    /// Its port was lost while its counts were angles; they still are if it kept its power.
    OutOfSight,
    /// Not before the next calibration; the reason.
    Untrusted(&'static str),
}

/// Something that happened to the head.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TrustEvent {
    /// It was connected and identified.
    Connected {
        /// A calibration was seen to end while it connected.
        calibrated: bool,
        /// Its limits are those of the first connection.
        limits_kept: bool,
        /// It has the settings that were left in it.
        power_kept: bool,
        /// The configuration says not to home a head that is found.
        trust_as_found: bool,
    },
    /// Its port was lost, or its driver gave up.
    PortLost,
    /// The station that watched it was closed; whether that one had ever been open.
    StationClosed { was_open: bool },
    /// A calibration was commanded.
    HomingStarted,
    /// The calibration ended.
    HomeDone {
        /// The limits are those of the first connection.
        limits_kept: bool,
    },
    /// Counts are no angles any more; the reason.
    Contradicted(&'static str),
}

const LIMITS_MOVED: &str =
    "its limits moved with the calibration: check whether something is in its way";
const NOT_HOMED: &str = "not homed since it was connected";
const HOMING_UNFINISHED: &str = "its calibration did not end";
const POWER_LOST: &str = "it lost its power";
const UNWATCHED: &str = "nobody watched it while its port was closed";

impl TrustState {
    /// The table of transitions.
    fn after(self, event: TrustEvent) -> Self {
        use TrustEvent as E;
        match (self, event) {
            (
                _,
                E::Connected {
                    calibrated: true,
                    limits_kept,
                    ..
                }
                | E::HomeDone { limits_kept },
            ) => {
                if limits_kept {
                    Self::Trusted
                } else {
                    Self::Untrusted(LIMITS_MOVED)
                }
            }
            (Self::NotSeen, E::Connected { trust_as_found, .. }) => {
                if trust_as_found {
                    Self::Trusted
                } else {
                    Self::Untrusted(NOT_HOMED)
                }
            }
            (
                Self::Trusted | Self::OutOfSight,
                E::Connected {
                    limits_kept,
                    power_kept,
                    ..
                },
            ) => match (power_kept, limits_kept) {
                (true, true) => Self::Trusted,
                (true, false) => Self::Untrusted(LIMITS_MOVED),
                (false, _) => Self::Untrusted(POWER_LOST),
            },
            (state @ Self::Untrusted(_), E::Connected { .. }) => state,
            (Self::Trusted, E::PortLost) => Self::OutOfSight,
            // A station that never opened has not moved it.
            (Self::Trusted | Self::OutOfSight, E::StationClosed { was_open: false }) => {
                Self::NotSeen
            }
            (Self::Trusted | Self::OutOfSight, E::StationClosed { was_open: true }) => {
                Self::Untrusted(UNWATCHED)
            }
            (state, E::PortLost | E::StationClosed { .. }) => state,
            (_, E::HomingStarted) => Self::Untrusted(HOMING_UNFINISHED),
            (_, E::Contradicted(why)) => Self::Untrusted(why),
        }
    }
}

/// Whether the counts of one head are angles, over all stations of this process. Clones share it.
#[derive(Debug, Clone, Default)]
pub struct PositionTrust(Arc<Mutex<TrackedHead>>);

#[derive(Debug, Default)]
struct TrackedHead {
    state: TrustState,
    /// Limits at the first connection.
    limits: Option<Limits>,
    power_marker: PowerMarker,
    homings: u64,
}

#[derive(Debug, Clone, PartialEq)]
struct Limits {
    version: String,
    /// Pan, tilt.
    steps: [AxisLimits; 2],
}

impl PositionTrust {
    fn lock(&self) -> MutexGuard<'_, TrackedHead> {
        // No holder of the lock panics.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether counts are angles.
    pub fn is_trusted(&self) -> bool {
        self.lock().state == TrustState::Trusted
    }

    /// Whether its port was lost while counts were angles.
    pub(super) fn is_out_of_sight(&self) -> bool {
        self.lock().state == TrustState::OutOfSight
    }

    /// Calibrations after which counts were angles.
    pub fn homings(&self) -> u64 {
        self.lock().homings
    }

    /// Why counts are no angles.
    pub(super) fn reason(&self) -> &'static str {
        match self.lock().state {
            TrustState::Untrusted(why) => why,
            TrustState::NotSeen | TrustState::Trusted | TrustState::OutOfSight => {
                "it is not connected"
            }
        }
    }

    /// `unit` was connected.
    pub(super) fn connected(&self, unit: &HeadIdentity, trust_as_found: bool) {
        let mut head = self.lock();
        let limits_kept = head.keeps_limits(unit);
        let power_kept = head.power_marker.is_intact(unit);
        if !power_kept {
            head.power_marker = PowerMarker::new(unit);
        }
        head.apply(TrustEvent::Connected {
            calibrated: unit.calibration_seen,
            limits_kept,
            power_kept,
            trust_as_found,
        });
    }

    /// A calibration ended; `unit` with its new limits, if it is known.
    pub(super) fn home_done(&self, unit: Option<&HeadIdentity>) {
        let mut head = self.lock();
        let limits_kept = unit.is_none_or(|unit| head.keeps_limits(unit));
        head.apply(TrustEvent::HomeDone { limits_kept });
        head.homings += u64::from(limits_kept);
    }

    /// Anything else.
    pub(super) fn note(&self, event: TrustEvent) {
        self.lock().apply(event);
    }

    /// The head accepted a speed.
    pub(super) fn record_speed(&self, axis: Axis, steps_per_s: i32) {
        self.lock().power_marker.record_speed(axis, steps_per_s);
    }

    /// Speed settings that show later whether `unit` kept its power: pan, tilt, in counts per second.
    pub(super) fn marker_speeds(&self, unit: &HeadIdentity) -> [i32; 2] {
        self.lock().power_marker.marker_speeds(unit)
    }
}

impl TrackedHead {
    fn apply(&mut self, event: TrustEvent) {
        self.state = self.state.after(event);
    }

    /// Whether the limits of `unit` are those of the first connection. A unit with another version string counts as a new
    /// one.
    fn keeps_limits(&mut self, unit: &HeadIdentity) -> bool {
        let now = Limits {
            version: unit.version.clone(),
            steps: [unit.pan.limits, unit.tilt.limits],
        };
        let first = self.limits.get_or_insert_with(|| now.clone());
        if first.version != now.version {
            *first = now;
            return true;
        }
        let near = |a: i32, b: i32| a.abs_diff(b) <= MAX_LIMIT_CHANGE_STEPS;
        first.steps.iter().zip(&now.steps).all(|(then, now)| {
            near(then.min_steps, now.min_steps) && near(then.max_steps, now.max_steps)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::TrustEvent::{
        Connected, Contradicted, HomeDone, HomingStarted, PortLost, StationClosed,
    };
    use super::TrustState::{NotSeen, OutOfSight, Trusted, Untrusted};
    use super::{
        HOMING_UNFINISHED, LIMITS_MOVED, MAX_LIMIT_CHANGE_STEPS, NOT_HOMED, POWER_LOST,
        PositionTrust, UNWATCHED,
    };
    use crate::devices::lockstep::rig::TestRig;
    use patrold_sim::emulator::EmulationOptions;
    use ptu::Axis;

    #[test]
    fn a_homing_counts_if_the_limits_are_where_they_were() {
        let rig = TestRig::ready(EmulationOptions::seeded(1));
        let found = rig.identity.expect("connected");
        let change = MAX_LIMIT_CHANGE_STEPS as i32;
        for (moved_steps, counts) in [(change, true), (change + 1, false)] {
            for axis in [Axis::Pan, Axis::Tilt] {
                let trust = PositionTrust::default();
                trust.connected(&found, false);
                for homings in 1..=2 {
                    trust.home_done(Some(&found));
                    assert_eq!((trust.homings(), trust.is_trusted()), (homings, true));
                }
                let mut unit = found.clone();
                let moved = match axis {
                    Axis::Pan => &mut unit.pan,
                    Axis::Tilt => &mut unit.tilt,
                };
                moved.limits.max_steps += moved_steps;
                trust.home_done(Some(&unit));
                let now = (trust.homings(), trust.is_trusted());
                assert_eq!(
                    now,
                    (2 + u64::from(counts), counts),
                    "{axis:?} {moved_steps}"
                );
                trust.home_done(None);
                assert_eq!(trust.homings(), 3 + u64::from(counts));
            }
        }
    }

    /// The whole table: every state with every event, one row each.
    #[test]
    fn every_state_and_event_has_its_row() {
        let connected = |calibrated, limits_kept, power_kept, trust_as_found| Connected {
            calibrated,
            limits_kept,
            power_kept,
            trust_as_found,
        };
        let why = "a reason";
        let states = [NotSeen, Trusted, OutOfSight, Untrusted(why)];
        let rows = [
            // A head that is found: without homing only the first, and only if the configuration says so.
            (
                connected(false, true, false, true),
                [
                    Trusted,
                    Untrusted(POWER_LOST),
                    Untrusted(POWER_LOST),
                    Untrusted(why),
                ],
            ),
            (
                connected(false, true, false, false),
                [
                    Untrusted(NOT_HOMED),
                    Untrusted(POWER_LOST),
                    Untrusted(POWER_LOST),
                    Untrusted(why),
                ],
            ),
            (
                connected(false, true, true, false),
                [Untrusted(NOT_HOMED), Trusted, Trusted, Untrusted(why)],
            ),
            (
                connected(false, false, true, false),
                [
                    Untrusted(NOT_HOMED),
                    Untrusted(LIMITS_MOVED),
                    Untrusted(LIMITS_MOVED),
                    Untrusted(why),
                ],
            ),
            (connected(true, true, false, false), [Trusted; 4]),
            (
                connected(true, false, true, true),
                [Untrusted(LIMITS_MOVED); 4],
            ),
            (PortLost, [NotSeen, OutOfSight, OutOfSight, Untrusted(why)]),
            (
                StationClosed { was_open: false },
                [NotSeen, NotSeen, NotSeen, Untrusted(why)],
            ),
            (
                StationClosed { was_open: true },
                [
                    NotSeen,
                    Untrusted(UNWATCHED),
                    Untrusted(UNWATCHED),
                    Untrusted(why),
                ],
            ),
            (HomingStarted, [Untrusted(HOMING_UNFINISHED); 4]),
            (HomeDone { limits_kept: true }, [Trusted; 4]),
            (
                HomeDone { limits_kept: false },
                [Untrusted(LIMITS_MOVED); 4],
            ),
            (Contradicted("another"), [Untrusted("another"); 4]),
        ];
        for (event, after) in rows {
            for (state, after) in states.into_iter().zip(after) {
                assert_eq!(state.after(event), after, "{state:?} {event:?}");
            }
        }
    }
}
