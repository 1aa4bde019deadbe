//! Every fault of both devices, and what a visit makes of it; in groups, so that all cores share them.

use ExpectedOutcome::{NotObserved, Tolerated};

/// Outcome of the visit with the fault.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum ExpectedOutcome {
    /// The sweep is complete and the verdict right.
    Tolerated,
    /// The reason contains this text.
    NotObserved(&'static str),
}

pub(super) struct FaultCase {
    pub(super) fault: &'static str,
    pub(super) connecting: ExpectedOutcome,
    pub(super) sweeping: ExpectedOutcome,
}

const fn case(
    fault: &'static str,
    connecting: ExpectedOutcome,
    sweeping: ExpectedOutcome,
) -> FaultCase {
    FaultCase {
        fault,
        connecting,
        sweeping,
    }
}

pub(super) const LASER_PORT: [FaultCase; 3] = [
    case(
        "laser.unplug:for=3",
        NotObserved("laser.port"),
        NotObserved("has gone"),
    ),
    case(
        "laser.unplug:for=3,power=kept",
        NotObserved("laser.port"),
        NotObserved("has gone"),
    ),
    case("laser.brown-out", Tolerated, NotObserved("restarted")),
];

pub(super) const LASER_LINES: [FaultCase; 8] = [
    case(
        "laser.bad-sum:count=4",
        Tolerated,
        NotObserved("gap in the sweep"),
    ),
    case("laser.dropped-byte:count=2", Tolerated, Tolerated),
    case("laser.bit-flip:count=2", Tolerated, Tolerated),
    case(
        "laser.garbage:count=3",
        Tolerated,
        NotObserved("gap in the sweep"),
    ),
    case("laser.flood:count=20", Tolerated, NotObserved("timer")),
    case(
        "laser.endless-line:count=20",
        Tolerated,
        NotObserved("timer"),
    ),
    case(
        "laser.truncated-scan:count=2",
        Tolerated,
        NotObserved("gap in the sweep"),
    ),
    case(
        "laser.truncated-scan:count=30",
        NotObserved("timer"),
        NotObserved("timer"),
    ),
];

pub(super) const LASER_SCANS: [FaultCase; 8] = [
    case(
        "laser.repeated-stamp",
        NotObserved("stamp"),
        NotObserved("stamp"),
    ),
    case(
        "laser.older-stamp",
        NotObserved("timer"),
        NotObserved("timer"),
    ),
    case(
        "laser.frozen-data",
        NotObserved("frozen"),
        NotObserved("frozen"),
    ),
    case(
        "laser.frozen-data:count=6,for=20",
        NotObserved("frozen"),
        NotObserved("frozen"),
    ),
    case(
        "laser.covered:for=25",
        NotObserved("blind"),
        NotObserved("blind"),
    ),
    case("laser.covered:for=2", Tolerated, NotObserved("blind")),
    case(
        "laser.half-covered:for=25",
        NotObserved("blind"),
        NotObserved("blind"),
    ),
    case("laser.half-covered:for=2", Tolerated, NotObserved("blind")),
];

pub(super) const LASER_STATES: [FaultCase; 13] = [
    case(
        "laser.silence",
        NotObserved("cable"),
        NotObserved("brought it back"),
    ),
    case(
        "laser.silence:for=2",
        Tolerated,
        NotObserved("incomplete sweep"),
    ),
    case(
        "laser.verify:status=21",
        Tolerated,
        NotObserved("incomplete sweep"),
    ),
    case(
        "laser.verify:status=49,for=3",
        Tolerated,
        NotObserved("incomplete sweep"),
    ),
    case(
        "laser.hardware",
        NotObserved("reports a fault"),
        NotObserved("hardware trouble"),
    ),
    case(
        "laser.hardware:status=97,for=2",
        Tolerated,
        NotObserved("hardware trouble"),
    ),
    case(
        "laser.trouble-stat",
        NotObserved("reports a fault"),
        Tolerated,
    ),
    case("laser.odd-version", Tolerated, Tolerated),
    case("laser.torn-version", Tolerated, Tolerated),
    case("laser.left-streaming", Tolerated, Tolerated),
    case(
        "laser.left-in-time-adjust",
        Tolerated,
        NotObserved("brought it back"),
    ),
    case("laser.firmware-update", Tolerated, NotObserved("timer")),
    case("laser.deafened", Tolerated, Tolerated),
];

pub(super) const LASER_TIMER: [FaultCase; 5] = [
    case("laser.timer-jump", Tolerated, NotObserved("timer")),
    case("laser.timer-jump:by=-0.1", Tolerated, NotObserved("timer")),
    case("laser.timer-jump:by=0.04", Tolerated, NotObserved("timer")),
    case("laser.timer-set", Tolerated, NotObserved("timer")),
    case("laser.timer-set:to=16775", Tolerated, NotObserved("timer")),
];

pub(super) const HEAD_PORT: [FaultCase; 9] = [
    case(
        "ptu.unplug:for=3",
        NotObserved("ptu.port"),
        NotObserved("has gone"),
    ),
    case(
        "ptu.unplug:for=3,power=kept",
        NotObserved("ptu.port"),
        NotObserved("has gone"),
    ),
    case(
        "ptu.silence:for=30",
        NotObserved("is silent"),
        NotObserved("no valid reply"),
    ),
    case(
        "ptu.silence:deaf=true,for=20",
        NotObserved("is silent"),
        NotObserved("no valid reply"),
    ),
    case("ptu.silence:for=1", Tolerated, Tolerated),
    case("ptu.reset-fails", Tolerated, Tolerated),
    case("ptu.power-cycle", Tolerated, NotObserved("restarted")),
    case("ptu.power-cycle:for=1", Tolerated, NotObserved("restarted")),
    case(
        "ptu.wrong-baud:for=5",
        Tolerated,
        NotObserved("no valid reply"),
    ),
];

pub(super) const HEAD_MOTION: [FaultCase; 10] = [
    case("ptu.lost-steps:axis=tilt,steps=20", Tolerated, Tolerated),
    case("ptu.lost-steps:axis=tilt,steps=-60", Tolerated, Tolerated),
    case("ptu.lost-steps:axis=pan,steps=20", Tolerated, Tolerated),
    case("ptu.lost-steps:axis=pan,steps=200", Tolerated, Tolerated),
    case(
        "ptu.stuck:axis=tilt,for=3",
        Tolerated,
        NotObserved("stopped at"),
    ),
    case(
        "ptu.stuck:axis=tilt,hidden=true,for=1",
        Tolerated,
        Tolerated,
    ),
    case(
        "ptu.stuck:axis=tilt,hidden=true,for=40",
        NotObserved("not trusted"),
        NotObserved("not trusted"),
    ),
    case("ptu.stuck:axis=pan,for=40", Tolerated, Tolerated),
    case(
        "ptu.slow:axis=tilt,factor=0.5,for=40",
        NotObserved("did not finish"),
        NotObserved("did not finish"),
    ),
    case(
        "ptu.overshoot:axis=tilt,steps=30,for=40",
        Tolerated,
        Tolerated,
    ),
];

pub(super) const HEAD_BYTES: [FaultCase; 9] = [
    case("ptu.event:which=P", Tolerated, NotObserved("limit")),
    case("ptu.event:which=T", Tolerated, NotObserved("limit")),
    case("ptu.event:which=D", Tolerated, NotObserved("cable")),
    case(
        "ptu.event:which=T,within=3",
        Tolerated,
        NotObserved("limit"),
    ),
    case("ptu.text", Tolerated, Tolerated),
    case("ptu.lost-byte", Tolerated, Tolerated),
    case(
        "ptu.lost-byte:count=50",
        NotObserved("is silent"),
        NotObserved("no valid reply"),
    ),
    case("ptu.garbage-byte", Tolerated, Tolerated),
    case(
        "ptu.garbage-byte:count=50",
        NotObserved("heard \""),
        NotObserved("no valid reply"),
    ),
];

pub(super) const HEAD_MODES: [FaultCase; 11] = [
    case("ptu.echo", Tolerated, NotObserved("restarted")),
    case("ptu.verbose", Tolerated, NotObserved("restarted")),
    case("ptu.velocity", Tolerated, NotObserved("did not finish")),
    case("ptu.slaved", Tolerated, Tolerated),
    case("ptu.limits-off", Tolerated, Tolerated),
    case("ptu.monitor", Tolerated, NotObserved("stopped at")),
    case("ptu.moving", Tolerated, NotObserved("stopped at")),
    case(
        "ptu.unit-id",
        NotObserved("is silent"),
        NotObserved("no valid reply"),
    ),
    case("ptu.baud", Tolerated, Tolerated),
    case("ptu.axis-error", Tolerated, Tolerated),
    case("ptu.supply", Tolerated, Tolerated),
];

pub(super) const ALL: [&[FaultCase]; 9] = [
    &LASER_PORT,
    &LASER_LINES,
    &LASER_SCANS,
    &LASER_STATES,
    &LASER_TIMER,
    &HEAD_PORT,
    &HEAD_MOTION,
    &HEAD_BYTES,
    &HEAD_MODES,
];

/// Faults that end with the power only, as their messages say.
pub(super) const LASTING: [&str; 6] = [
    "laser.silence",
    "laser.hardware",
    "laser.trouble-stat",
    "laser.repeated-stamp",
    "laser.frozen-data",
    "ptu.unit-id",
];
