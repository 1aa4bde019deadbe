//! What the end of a connection and a new one leave behind: nothing.

use crate::test_rig::PtuTestRig;
use crate::{Axis, PtuDriver, PtuEvent, PtuOptions};
use std::time::Duration;

const BANNER: &[u8] = b"\r\n### PAN-TILT CONTROLLER\r\n### v2\r\nInitializing...*\r\n";

/// What a silent unit is sent until the driver gives up.
fn sent_into_silence(rig: &mut PtuTestRig) -> Vec<String> {
    rig.driver.connect(rig.now);
    let mut sent = Vec::new();
    while rig.driver.deadline().is_some() {
        sent.extend(rig.take_sent());
        rig.pass_deadline();
    }
    sent
}

#[test]
fn what_was_asked_of_a_unit_is_not_carried_out_after_its_restart() {
    for awaits_a_late_reply in [false, true] {
        let (mut rig, mut replies) = PtuTestRig::connected();
        rig.driver
            .move_to(Axis::Pan, 71, rig.now)
            .expect("connected");
        rig.driver
            .move_to(Axis::Tilt, 72, rig.now)
            .expect("connected");
        assert_eq!(rig.take_sent(), ["PP71 "]);
        if awaits_a_late_reply {
            // To be sent again after the drain.
            rig.pass_deadline();
        }
        rig.feed(BANNER);
        let seen = rig.answer_all(&mut replies);
        assert!(rig.driver.is_idle());
        let moved = |command: &String| command.ends_with("71") || command.ends_with("72");
        assert!(!seen.iter().any(moved), "{seen:?}");
    }
}

#[test]
fn what_was_asked_of_a_unit_that_falls_silent_is_dropped() {
    let (mut rig, mut replies) = PtuTestRig::connected();
    rig.driver
        .poll_position(Axis::Pan, rig.now)
        .expect("connected");
    rig.driver
        .move_to(Axis::Tilt, 72, rig.now)
        .expect("connected");
    while rig.driver.deadline().is_some() {
        rig.take_sent();
        rig.pass_deadline();
    }
    assert_eq!(rig.driver.pending(), 0);
    let seen = rig.connect_with(&mut replies);
    assert!(!seen.contains(&"TP72".to_owned()), "{seen:?}");

    // So is what the driver itself wanted to ask a unit that refuses to be set up.
    let mut rig = PtuTestRig::new();
    replies.overrides = vec![("PN", "! Axis Error")];
    rig.connect_with(&mut replies);
    assert!(matches!(rig.only_event(), PtuEvent::Fault(_)));
    assert_eq!(rig.driver.pending(), 0);
}

#[test]
fn half_a_line_does_not_survive_a_reopened_port() {
    let (mut rig, mut replies) = PtuTestRig::connected();
    rig.feed(b"### PAN-TI");
    rig.driver.connect(rig.now);
    rig.take_sent();
    // Alone it is no banner, hence no calibration to wait for.
    rig.feed(b"LT CONTROLLER\r\n");
    let began = rig.now;
    assert_eq!(rig.next_send(), "ED ");
    assert!(rig.now - began < Duration::from_secs(1));
    let answer = replies.answer("ED");
    rig.feed(answer.as_bytes());
    rig.answer_all(&mut replies);
    assert!(matches!(rig.only_event(), PtuEvent::Connected(_)));
}

#[test]
fn a_calibration_belongs_to_the_connection_that_saw_it() {
    let (mut rig, mut replies) = PtuTestRig::connected();
    rig.feed(BANNER);
    rig.answer_all(&mut replies);
    rig.connect_with(&mut replies);
    let seen = rig.events.iter().filter_map(|event| match event {
        PtuEvent::Connected(identity) => Some(identity.calibration_seen),
        _ => None,
    });
    assert_eq!(seen.collect::<Vec<_>>(), [true, false]);

    // One that the port was lost in is not waited for.
    let (mut waiting, mut fresh) = (PtuTestRig::new(), PtuTestRig::new());
    waiting.driver.connect(waiting.now);
    waiting.feed(b"!T");
    waiting.take_sent();
    let began = [waiting.now, fresh.now];
    assert_eq!(
        sent_into_silence(&mut waiting),
        sent_into_silence(&mut fresh)
    );
    assert_eq!(waiting.now - began[0], fresh.now - began[1]);
}

#[test]
fn each_connection_has_all_its_attempts() {
    let mut rig = PtuTestRig::new();
    rig.driver = PtuDriver::new(PtuOptions {
        network_rescue: true,
        ..PtuOptions::default()
    });
    let first = sent_into_silence(&mut rig);
    assert_eq!(first.iter().filter(|sent| *sent == "V ").count(), 4);
    assert_eq!(sent_into_silence(&mut rig), first);
}

#[test]
fn doubtful_replies_of_different_resets_do_not_add_up() {
    let (mut rig, mut unit) = PtuTestRig::connected();
    for round in 1..=6 {
        rig.driver.reset(rig.now).expect("connected");
        assert_eq!(rig.next_send(), "R ");
        rig.feed(b"!T!T!P!P*\r\n");
        // The first limit twice, the first time: all are read again.
        assert_eq!(rig.next_send(), " ");
        assert_eq!(rig.next_send(), "PN ");
        rig.feed(unit.answer("PN").repeat(2).as_bytes());
        rig.answer_all(&mut unit);
        let homed = |event: &&PtuEvent| matches!(event, PtuEvent::HomeDone { .. });
        assert_eq!(rig.events.iter().filter(homed).count(), round);
    }
}
