//! Detects whether a reconnected head kept its power. The speed settings are lost with the power (ptu-d46 section 5), and so
//! is the position: unusual speeds are set before and compared after.

use super::constants::POWER_UP_STEPS_S;
use ptu::{Axis, AxisIdentity, HeadIdentity};

/// Speed settings, counts per second; pan, tilt.
#[derive(Debug, Clone, Default)]
pub(crate) struct PowerMarker {
    version: String,
    /// As read at connecting; perhaps the power-up values, which `DS` may have changed.
    found: [i32; 2],
    /// As set since.
    set: [Option<i32>; 2],
}

impl PowerMarker {
    pub(super) fn new(unit: &HeadIdentity) -> Self {
        Self {
            version: unit.version.clone(),
            found: speeds(unit),
            set: [None; 2],
        }
    }

    /// The unit accepted a speed.
    pub(super) fn record_speed(&mut self, axis: Axis, steps_per_s: i32) {
        self.set[usize::from(axis == Axis::Tilt)] = Some(steps_per_s);
    }

    /// Whether `unit`, just connected, has the speeds set last, and these differ from its power-up values.
    pub(super) fn is_intact(&self, unit: &HeadIdentity) -> bool {
        let [Some(pan), Some(tilt)] = self.set else {
            return false;
        };
        let last_set = [pan, tilt];
        let is_distinctive = last_set != self.found && last_set != [POWER_UP_STEPS_S; 2];
        is_distinctive && unit.version == self.version && speeds(unit) == last_set
    }

    /// Speeds near those found at connecting that are no power-up values.
    pub(super) fn marker_speeds(&self, unit: &HeadIdentity) -> [i32; 2] {
        let near = |found: i32, axis: &AxisIdentity| {
            [1, 2, -1, -2]
                .map(|off| found.saturating_add(off))
                .into_iter()
                .find(|speed| {
                    *speed != POWER_UP_STEPS_S
                        && *speed >= axis.speed_min
                        && *speed <= axis.speed_max
                })
                .unwrap_or(found)
        };
        [
            near(self.found[0], &unit.pan),
            near(self.found[1], &unit.tilt),
        ]
    }
}

fn speeds(unit: &HeadIdentity) -> [i32; 2] {
    [unit.pan.speed, unit.tilt.speed]
}

#[cfg(test)]
mod tests {
    use super::PowerMarker;
    use crate::devices::lockstep::rig::TestRig;
    use patrold_sim::emulator::EmulationOptions;
    use ptu::{Axis, HeadIdentity};

    fn unit(pan: i32, tilt: i32) -> HeadIdentity {
        let rig = TestRig::ready(EmulationOptions::seeded(1));
        let mut unit = rig.identity.expect("connected");
        (unit.pan.speed, unit.tilt.speed) = (pan, tilt);
        unit
    }

    fn marked(found: [i32; 2], set: [i32; 2]) -> PowerMarker {
        let mut mark = PowerMarker::new(&unit(found[0], found[1]));
        mark.record_speed(Axis::Pan, set[0]);
        mark.record_speed(Axis::Tilt, set[1]);
        mark
    }

    #[test]
    fn a_unit_with_the_speeds_set_last_kept_its_power() {
        let mark = marked([1000, 1000], [1001, 400]);
        assert!(mark.is_intact(&unit(1001, 400)));
        assert!(!mark.is_intact(&unit(1000, 1000)), "as after a power-up");
        assert!(!mark.is_intact(&unit(1001, 1000)), "half is not enough");
        let mut other = unit(1001, 400);
        other.version.push('x');
        assert!(!mark.is_intact(&other), "another unit");
    }

    #[test]
    fn power_up_speeds_prove_nothing() {
        assert!(!marked([1001, 1002], [1000, 1000]).is_intact(&unit(1000, 1000)));
        assert!(!marked([640, 650], [640, 650]).is_intact(&unit(640, 650)));
        assert!(
            !PowerMarker::new(&unit(7, 8)).is_intact(&unit(7, 8)),
            "nothing set"
        );
    }

    #[test]
    fn marker_speeds_are_distinctive_and_allowed() {
        for found in [[1000, 1000], [999, 31], [2902, 998], [31, 2902]] {
            let unit = unit(found[0], found[1]);
            let speeds = PowerMarker::new(&unit).marker_speeds(&unit);
            assert!(
                marked(found, speeds).is_intact(&super::tests::unit(speeds[0], speeds[1])),
                "{found:?} {speeds:?}"
            );
            for (speed, axis) in speeds.into_iter().zip([&unit.pan, &unit.tilt]) {
                assert!((axis.speed_min..=axis.speed_max).contains(&speed));
            }
        }
    }
}
