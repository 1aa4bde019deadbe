//! Steps lost silently are seen from the scene: told, homed, swept again, and the second sweep gives the verdict.

use super::patrol::{Patrol, settings, taught, world};
use patrold_engine::novelty::Verdict;
use patrold_sim::emulator::EmulationOptions;
use std::ops::Range;

fn patrol(seed: u64) -> Patrol {
    Patrol::that_knows(&taught(), seed)
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
    found(20, &[10, -10, -150], &[0.0, 5.0, 9.0, 13.0]);
}

#[test]
#[ignore = "minutes; the rest of the cases above"]
fn more_is_found_and_at_more_instants() {
    found(
        20,
        &[10, -10, 20, -30, 60, -150],
        &[0.0, 5.0, 7.0, 9.0, 11.0, 13.0],
    );
}

#[test]
fn steps_lost_between_or_in_the_legs_of_several_pans_are_found() {
    let mut settings = settings();
    settings.sweep.pans_rad = vec![-0.5, 0.5];
    let mut teacher = Patrol::new(settings, EmulationOptions::seeded(1), "storeroom.toml");
    teacher.teach();
    let taught = teacher.taught().expect("taught");
    let patrol = || Patrol::that_knows(&taught, 22);
    let mut plain = patrol();
    let seen = plain.visit();
    assert_eq!(
        (seen.verdict, plain.sweeps),
        (Verdict::Quiet, 1),
        "{:?}",
        plain.log
    );
    // The first leg is over 13.7 s after the visit begins; at 15 s the second is about to begin.
    for (axis, steps, at_s) in [
        ("pan", 10, 0.0),
        ("pan", -10, 15.0),
        ("tilt", 10, 9.0),
        ("tilt", -10, 15.0),
        ("tilt", 10, 22.0),
    ] {
        let mut patrol = patrol();
        patrol.inject(&format!(
            "ptu.lost-steps:at={at_s},axis={axis},steps={steps}"
        ));
        let seen = patrol.visit();
        let what = format!("{axis} {steps} at {at_s}: {seen:?} {:?}", patrol.log);
        assert_eq!((seen.verdict, patrol.sweeps), (Verdict::Quiet, 2), "{what}");
    }
}

/// Loses `steps` counts of 0.0514 deg of either axis `at_s` seconds after a visit begins: 0 is before its sweep, in which the head
/// tilts from 1.3 to 13.3 s.
fn found(seed: u64, steps: &[i32], at_s: &[f64]) {
    let mut missed = Vec::new();
    for axis in ["tilt", "pan"] {
        for steps in steps {
            for at_s in at_s {
                let mut patrol = patrol(seed);
                patrol.inject(&format!(
                    "ptu.lost-steps:at={at_s},axis={axis},steps={steps}"
                ));
                let seen = patrol.visit();
                let told = patrol.log.iter().any(|text| text.contains("swept again"));
                if (seen.verdict, patrol.sweeps, told) != (Verdict::Quiet, 2, true) {
                    missed.push(format!(
                        "{axis} {steps} at {at_s}: {seen:?} {:?}",
                        patrol.log
                    ));
                }
            }
        }
    }
    assert!(missed.is_empty(), "{missed:#?}");
}
