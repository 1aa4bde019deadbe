//! Steps lost silently are seen from the scene: told, homed, swept again, and the second sweep gives the verdict.

use super::patrol::{Patrol, taught, world};
use crate::devices::EmulationOptions;
use crate::novelty::Verdict;
use std::ops::Range;

fn patrol(seed: u64) -> Patrol {
    let mut patrol = Patrol::that_knows(&taught(), EmulationOptions::seeded(seed));
    patrol.until_ready(true).expect("ready");
    patrol
}

#[test]
fn without_loss_one_sweep_is_enough() {
    one_sweep_is_enough(10..16);
}

#[test]
#[ignore = "minutes; further visits like those above"]
fn without_loss_one_sweep_is_enough_at_more_visits() {
    one_sweep_is_enough(16..20);
}

fn one_sweep_is_enough(seeds: Range<u64>) {
    for (scene, verdict) in [
        ("storeroom.toml", Verdict::Quiet),
        ("storeroom-box-left.toml", Verdict::Changed),
        ("storeroom-taken.toml", Verdict::Changed),
    ] {
        for seed in seeds.clone() {
            let mut patrol = patrol(seed);
            patrol.devices.with(|e| e.set_world(world(scene)));
            let seen = patrol.visit();
            assert_eq!(
                (seen.verdict, patrol.sweeps),
                (verdict, 1),
                "{scene} {seed}: {:?}",
                patrol.log
            );
        }
    }
}

#[test]
fn half_a_degree_of_pan_or_tilt_is_found_whenever_it_is_lost() {
    found(&[10, -10, -150], &[0.0, 5.0, 9.0, 13.0]);
}

#[test]
#[ignore = "minutes; the rest of the cases above"]
fn more_is_found_and_at_more_instants() {
    found(
        &[10, -10, 20, -30, 60, -150],
        &[0.0, 5.0, 7.0, 9.0, 11.0, 13.0],
    );
}

/// Loses `steps` counts of 0.0514 deg of either axis `at_s` seconds after a visit begins: 0 is before its sweep, in which the head
/// tilts from 4 to 16 s.
fn found(steps: &[i32], at_s: &[f64]) {
    for axis in ["tilt", "pan"] {
        for steps in steps {
            for at_s in at_s {
                let mut patrol = patrol(20);
                patrol.inject(&format!(
                    "ptu.lost-steps:at={at_s},axis={axis},steps={steps}"
                ));
                let seen = patrol.visit();
                let told = patrol.log.iter().find(|text| text.contains("swept again"));
                let what = format!("{axis} {steps} at {at_s}: {seen:?} {:?}", patrol.log);
                assert_eq!((seen.verdict, patrol.sweeps), (Verdict::Quiet, 2), "{what}");
                assert!(told.is_some(), "{what}");
            }
        }
    }
}
