//! Steps of a sweep that both emulated devices do not lead to.

use super::{PortNames, SweepAction, SweepPhase, SweepRun};
use crate::config::{Settings, SweepMode};
use crate::devices::constants::WARM_UP_SCANS;
use crate::devices::head::HeadCommand;
use crate::devices::lockstep::rig::TestRig;
use patrold_sim::emulator::EmulationOptions;
use ptu::Axis;
use scip::{LaserEvent, LaserScan, RecoveryCause, RecoveryStep, ValueCoding};
use std::time::Duration;

fn scan(number: u32, at: Duration) -> LaserEvent {
    LaserEvent::Scan {
        scan: LaserScan {
            first_step: 44,
            cluster: 1,
            coding: ValueCoding::ThreeCharacter,
            ranges: Vec::new(),
            intensities: Vec::new(),
            stamp_ms: 1000 + 100 * number,
            remaining: 0,
        },
        first_byte_at: at,
        last_byte_at: at,
    }
}

#[test]
fn a_laser_that_stops_while_it_warms_up_warms_up_anew() {
    let rig = TestRig::ready(EmulationOptions::seeded(1));
    let request = TestRig::request(SweepMode::Continuous);
    let ptu = Settings::defaults().ptu;
    let ports = PortNames {
        laser: "laser".to_owned(),
        head: "ptu".to_owned(),
    };
    for stopped in [
        LaserEvent::Recovering {
            cause: RecoveryCause::Silence,
            step: RecoveryStep::Quit,
        },
        LaserEvent::Verifying { status: 21 },
    ] {
        let plan = rig.plan(&request, &ptu).expect("within reach");
        let mut run = SweepRun::new(plan, ports.clone(), rig.now);
        while run.poll_action().is_some() {}
        run.phase = SweepPhase::WarmingUp(0);
        let mut tilts_after = |event: LaserEvent| {
            run.on_laser(event, rig.now);
            std::iter::from_fn(|| run.poll_action()).any(|action| {
                matches!(
                    action,
                    SweepAction::Head(HeadCommand::MoveTo(Axis::Tilt, _))
                )
            })
        };
        for number in 1..WARM_UP_SCANS {
            assert!(!tilts_after(scan(number, rig.now)));
        }
        assert!(!tilts_after(stopped.clone()));
        for number in 1..WARM_UP_SCANS {
            let tilts = tilts_after(scan(10 + number, rig.now));
            assert!(!tilts, "{stopped:?}: {number}");
        }
        assert!(tilts_after(scan(20, rig.now)), "{stopped:?}");
    }
}
