//! Every fault of both devices, played into whole visits: no alarm, no quiet verdict from it, and a clean visit
//! afterwards.

use super::patrol::{Patrol, taught};
use Ends::{Blind, RiddenOut};
use patrold_engine::novelty::Verdict;
use std::time::Duration;

/// When a fault comes.
#[derive(Debug, Clone, Copy, PartialEq)]
enum When {
    /// Before the devices are opened anew.
    Connecting,
    /// Seven seconds after the visit is asked for: the head tilts.
    Sweeping,
}

/// How a visit with the fault may end.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Ends {
    /// The sweep is whole in spite of it: the verdict is the right one.
    RiddenOut,
    /// Not observed; the reason holds this word.
    Blind(&'static str),
}

struct Case {
    fault: &'static str,
    connecting: Ends,
    sweeping: Ends,
}

const fn case(fault: &'static str, connecting: Ends, sweeping: Ends) -> Case {
    Case {
        fault,
        connecting,
        sweeping,
    }
}

const LASER: [Case; 37] = [
    case("laser.unplug:for=3", Blind("laser.port"), Blind("has gone")),
    case(
        "laser.unplug:for=3,power=kept",
        Blind("laser.port"),
        Blind("has gone"),
    ),
    case("laser.brown-out", RiddenOut, Blind("restarted")),
    case(
        "laser.bad-sum:count=4",
        RiddenOut,
        Blind("gap in the sweep"),
    ),
    case("laser.dropped-byte:count=2", RiddenOut, RiddenOut),
    case("laser.bit-flip:count=2", RiddenOut, RiddenOut),
    case(
        "laser.garbage:count=3",
        RiddenOut,
        Blind("gap in the sweep"),
    ),
    case("laser.flood:count=20", RiddenOut, Blind("timer")),
    case("laser.endless-line:count=20", RiddenOut, Blind("timer")),
    case(
        "laser.truncated-scan:count=2",
        RiddenOut,
        Blind("gap in the sweep"),
    ),
    case(
        "laser.truncated-scan:count=30",
        Blind("timer"),
        Blind("timer"),
    ),
    case("laser.repeated-stamp", Blind("stamp"), Blind("stamp")),
    case("laser.older-stamp", Blind("timer"), Blind("timer")),
    case("laser.frozen-data", Blind("frozen"), Blind("frozen")),
    case(
        "laser.frozen-data:count=6,for=20",
        Blind("frozen"),
        Blind("frozen"),
    ),
    case("laser.silence", Blind("cable"), Blind("brought it back")),
    case("laser.silence:for=2", RiddenOut, Blind("incomplete sweep")),
    case(
        "laser.verify:status=21",
        RiddenOut,
        Blind("incomplete sweep"),
    ),
    case(
        "laser.verify:status=49,for=3",
        RiddenOut,
        Blind("incomplete sweep"),
    ),
    case(
        "laser.hardware",
        Blind("reports a fault"),
        Blind("hardware trouble"),
    ),
    case(
        "laser.hardware:status=97,for=2",
        RiddenOut,
        Blind("hardware trouble"),
    ),
    case("laser.trouble-stat", Blind("reports a fault"), RiddenOut),
    case("laser.odd-version", RiddenOut, RiddenOut),
    case("laser.torn-version", RiddenOut, RiddenOut),
    case("laser.left-streaming", RiddenOut, RiddenOut),
    case(
        "laser.left-in-time-adjust",
        RiddenOut,
        Blind("brought it back"),
    ),
    case("laser.firmware-update", RiddenOut, Blind("timer")),
    case("laser.deafened", RiddenOut, RiddenOut),
    case("laser.covered:for=25", Blind("blind"), Blind("blind")),
    case("laser.covered:for=2", RiddenOut, Blind("blind")),
    case("laser.half-covered:for=25", Blind("blind"), Blind("blind")),
    case("laser.half-covered:for=2", RiddenOut, Blind("blind")),
    case("laser.timer-jump", RiddenOut, Blind("timer")),
    case("laser.timer-jump:by=-0.1", RiddenOut, Blind("timer")),
    case("laser.timer-jump:by=0.04", RiddenOut, Blind("timer")),
    case("laser.timer-set", RiddenOut, Blind("timer")),
    case("laser.timer-set:to=16775", RiddenOut, Blind("timer")),
];

const HEAD: [Case; 39] = [
    case("ptu.unplug:for=3", Blind("ptu.port"), Blind("has gone")),
    case(
        "ptu.unplug:for=3,power=kept",
        Blind("ptu.port"),
        Blind("has gone"),
    ),
    case("ptu.lost-steps:axis=tilt,steps=20", RiddenOut, RiddenOut),
    case("ptu.lost-steps:axis=tilt,steps=-60", RiddenOut, RiddenOut),
    case("ptu.lost-steps:axis=pan,steps=20", RiddenOut, RiddenOut),
    case("ptu.lost-steps:axis=pan,steps=200", RiddenOut, RiddenOut),
    case("ptu.stuck:axis=tilt,for=3", RiddenOut, Blind("stopped at")),
    case(
        "ptu.stuck:axis=tilt,hidden=true,for=1",
        RiddenOut,
        RiddenOut,
    ),
    case(
        "ptu.stuck:axis=tilt,hidden=true,for=40",
        Blind("not trusted"),
        Blind("not trusted"),
    ),
    case("ptu.stuck:axis=pan,for=40", RiddenOut, RiddenOut),
    case(
        "ptu.slow:axis=tilt,factor=0.5,for=40",
        Blind("did not finish"),
        Blind("did not finish"),
    ),
    case(
        "ptu.overshoot:axis=tilt,steps=30,for=40",
        RiddenOut,
        RiddenOut,
    ),
    case("ptu.event:which=P", RiddenOut, Blind("limit")),
    case("ptu.event:which=T", RiddenOut, Blind("limit")),
    case("ptu.event:which=D", RiddenOut, Blind("cable")),
    case("ptu.event:which=T,within=3", RiddenOut, Blind("limit")),
    case("ptu.text", RiddenOut, RiddenOut),
    case("ptu.echo", RiddenOut, Blind("restarted")),
    case("ptu.verbose", RiddenOut, Blind("restarted")),
    case("ptu.velocity", RiddenOut, Blind("did not finish")),
    case("ptu.slaved", RiddenOut, RiddenOut),
    case("ptu.limits-off", RiddenOut, RiddenOut),
    case("ptu.monitor", RiddenOut, Blind("stopped at")),
    case("ptu.moving", RiddenOut, Blind("stopped at")),
    case("ptu.unit-id", Blind("is silent"), Blind("no fitting reply")),
    case("ptu.baud", RiddenOut, RiddenOut),
    case("ptu.axis-error", RiddenOut, RiddenOut),
    case("ptu.supply", RiddenOut, RiddenOut),
    case(
        "ptu.silence:for=30",
        Blind("is silent"),
        Blind("no fitting reply"),
    ),
    case(
        "ptu.silence:deaf=true,for=20",
        Blind("is silent"),
        Blind("no fitting reply"),
    ),
    case("ptu.silence:for=1", RiddenOut, RiddenOut),
    case("ptu.lost-byte", RiddenOut, RiddenOut),
    case(
        "ptu.lost-byte:count=50",
        Blind("is silent"),
        Blind("no fitting reply"),
    ),
    case("ptu.garbage-byte", RiddenOut, RiddenOut),
    case(
        "ptu.garbage-byte:count=50",
        Blind("answers, but not as"),
        Blind("no fitting reply"),
    ),
    case("ptu.reset-fails", RiddenOut, RiddenOut),
    case("ptu.power-cycle", RiddenOut, Blind("restarted")),
    case("ptu.power-cycle:for=1", RiddenOut, Blind("restarted")),
    case("ptu.wrong-baud:for=5", RiddenOut, Blind("no fitting reply")),
];

/// Plays the fault into a visit, and a clean visit after it; what is wrong, if anything.
fn play(case: &Case, when: When) -> Result<(), String> {
    let mut patrol = Patrol::that_knows(&taught(), 7);
    let (device, rest) = case.fault.split_once('.').expect("device.kind");
    let (fault, expected) = match when {
        When::Connecting => (case.fault.to_owned(), case.connecting),
        When::Sweeping => {
            let (kind, keys) = rest.split_once(':').unwrap_or((rest, ""));
            (format!("{device}.{kind}:at=7,{keys}"), case.sweeping)
        }
    };
    if when == When::Connecting {
        // Pulled; the fault is there when it is put in again.
        patrol.inject(&format!("{device}.unplug:for=2"));
        patrol.until_ready(false).expect("noticed");
        patrol.until_plugged_in();
    }
    patrol.inject(&fault);
    let seen = patrol.visit();
    let told = format!("{fault} {when:?}: {:?}: {}", seen.verdict, seen.reason);
    let right = match expected {
        RiddenOut => seen.verdict == Verdict::Quiet,
        Blind(word) => seen.verdict == Verdict::NotObserved && seen.reason.contains(word),
    };
    if !right || seen.reason.contains('\n') {
        return Err(told);
    }
    // Whoever minds the robot puts right what does not heal by itself.
    patrol.inject("laser.unplug:for=1");
    patrol.inject("ptu.unplug:for=1");
    patrol.idle(Duration::from_secs(60));
    if patrol.until_ready(true).is_none() {
        return Err(format!("{told}; not ready again: {:?}", patrol.log));
    }
    let clean = patrol.visit();
    if clean.verdict != Verdict::Quiet {
        return Err(format!("{told}; after it: {clean:?}"));
    }
    Ok(())
}

fn play_all(cases: &[Case]) {
    let plays = cases
        .iter()
        .flat_map(|case| [When::Connecting, When::Sweeping].map(|when| play(case, when).err()));
    let wrong: Vec<String> = plays.flatten().collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn no_fault_of_the_laser_is_quiet_or_an_alarm() {
    play_all(&LASER);
}

#[test]
fn no_fault_of_the_head_is_quiet_or_an_alarm() {
    play_all(&HEAD);
}

#[test]
fn every_kind_of_fault_is_played() {
    let laser = scip::twin::Fault::kinds().map(|kind| format!("laser.{kind}"));
    let head = ptu::twin::FaultKind::kinds().map(|kind| format!("ptu.{kind}"));
    for kind in laser.chain(head) {
        let played = |case: &Case| case.fault.split(':').next() == Some(&kind);
        assert!(LASER.iter().chain(&HEAD).any(played), "{kind}");
    }
}
