//! Whether a head that comes back kept its power: the speeds it was told last are lost with it (ptu-d46 section 5), as its
//! counts are. Pure.

use super::constants::POWER_UP_SPEED;
use ptu::{Axis, AxisIdentity, HeadIdentity};

/// Set speeds of both axes as evidence, in counts per second; pan, tilt.
#[derive(Debug, Clone, Default)]
pub(super) struct PowerMark {
    version: String,
    /// As found at connecting: perhaps those of this unit's power-up, which `DS` can have changed.
    found: [i32; 2],
    /// As taken by the unit since.
    taken: [Option<i32>; 2],
}

impl PowerMark {
    /// Of a unit of which nothing is known yet.
    pub(super) fn new(unit: &HeadIdentity) -> Self {
        Self {
            version: unit.version.clone(),
            found: speeds(unit),
            taken: [None; 2],
        }
    }

    /// The unit took a speed.
    pub(super) fn taken(&mut self, axis: Axis, steps_per_s: i32) {
        self.taken[usize::from(axis == Axis::Tilt)] = Some(steps_per_s);
    }

    /// Whether `unit`, just connected, is as it was left, and not as a power-up would have left it.
    pub(super) fn stands(&self, unit: &HeadIdentity) -> bool {
        let [Some(pan), Some(tilt)] = self.taken else {
            return false;
        };
        let left = [pan, tilt];
        let telling = left != self.found && left != [POWER_UP_SPEED; 2];
        telling && unit.version == self.version && speeds(unit) == left
    }

    /// Speeds near those found that no power-up of this unit sets, for both axes.
    pub(super) fn to_leave(&self, unit: &HeadIdentity) -> [i32; 2] {
        let near = |found: i32, axis: &AxisIdentity| {
            [1, 2, -1, -2]
                .map(|off| found.saturating_add(off))
                .into_iter()
                .find(|speed| {
                    *speed != POWER_UP_SPEED && *speed >= axis.speed_min && *speed <= axis.speed_max
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
    use super::PowerMark;
    use crate::devices::lockstep::bench::Bench;
    use patrold_sim::emulator::EmulationOptions;
    use ptu::{Axis, HeadIdentity};

    fn unit(pan: i32, tilt: i32) -> HeadIdentity {
        let bench = Bench::ready(EmulationOptions::seeded(1));
        let mut unit = bench.identity.expect("connected");
        (unit.pan.speed, unit.tilt.speed) = (pan, tilt);
        unit
    }

    fn left(found: [i32; 2], told: [i32; 2]) -> PowerMark {
        let mut mark = PowerMark::new(&unit(found[0], found[1]));
        mark.taken(Axis::Pan, told[0]);
        mark.taken(Axis::Tilt, told[1]);
        mark
    }

    #[test]
    fn a_unit_with_the_speeds_it_was_told_kept_its_power() {
        let mark = left([1000, 1000], [1001, 400]);
        assert!(mark.stands(&unit(1001, 400)));
        assert!(!mark.stands(&unit(1000, 1000)), "as after a power-up");
        assert!(!mark.stands(&unit(1001, 1000)), "half is not enough");
        let mut other = unit(1001, 400);
        other.version.push('x');
        assert!(!mark.stands(&other), "another unit");
    }

    #[test]
    fn speeds_that_a_power_up_sets_tell_nothing() {
        assert!(!left([1001, 1002], [1000, 1000]).stands(&unit(1000, 1000)));
        assert!(!left([640, 650], [640, 650]).stands(&unit(640, 650)));
        assert!(
            !PowerMark::new(&unit(7, 8)).stands(&unit(7, 8)),
            "nothing told"
        );
    }

    #[test]
    fn what_is_left_behind_is_telling_and_allowed() {
        for found in [[1000, 1000], [999, 31], [2902, 998], [31, 2902]] {
            let unit = unit(found[0], found[1]);
            let told = PowerMark::new(&unit).to_leave(&unit);
            assert!(
                left(found, told).stands(&super::tests::unit(told[0], told[1])),
                "{found:?} {told:?}"
            );
            for (speed, axis) in told.into_iter().zip([&unit.pan, &unit.tilt]) {
                assert!((axis.speed_min..=axis.speed_max).contains(&speed));
            }
        }
    }
}
