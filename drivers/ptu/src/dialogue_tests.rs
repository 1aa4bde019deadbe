//! Dialogues with a connected unit, fed byte by byte.

use std::time::Duration;

use crate::test_rig::{BYTE_TIME, PtuTestRig};
use crate::{Axis, AxisLimits, HeadError, PtuEvent, RequestError};

#[test]
fn a_poll_carries_both_its_instants() {
    let (mut rig, _) = PtuTestRig::connected();
    let asked = rig.now;
    rig.driver
        .poll_position(Axis::Tilt, asked)
        .expect("connected");
    assert_eq!(rig.take_sent(), ["TP "]);
    rig.now += Duration::from_millis(5);
    rig.feed(b"* -1234\r\n");
    let first_byte_at = asked + Duration::from_millis(5) + BYTE_TIME;
    let PtuEvent::Position {
        axis,
        steps,
        sent_at,
        first_byte_at: first,
    } = rig.only_event()
    else {
        panic!("no position")
    };
    assert_eq!((axis, steps, first), (Axis::Tilt, -1234, first_byte_at));
    assert_eq!(
        sent_at - asked,
        Duration::from_secs(30) / 9600,
        "three bytes at 9600 baud"
    );

    rig.driver
        .poll_position(Axis::Tilt, rig.now)
        .expect("connected");
    rig.take_sent();
    rig.feed(b"* 5\r\n");
    let PtuEvent::Position {
        sent_at,
        first_byte_at,
        ..
    } = rig.only_event()
    else {
        panic!("no position")
    };
    assert_eq!(sent_at, first_byte_at, "never after the reply");
}

#[test]
fn one_command_is_in_flight_and_the_rest_wait() {
    let (mut rig, mut replies) = PtuTestRig::connected();
    for target in 0..3 {
        rig.driver
            .move_to(Axis::Pan, target, rig.now)
            .expect("connected");
    }
    assert_eq!(rig.take_sent(), ["PP0 "]);
    assert_eq!(rig.driver.pending(), 3);
    rig.driver.halt(rig.now).expect("connected");
    rig.feed(b"*\r\n");
    assert_eq!(
        rig.take_sent(),
        ["H "],
        "a halt goes before waiting moves and drops them"
    );
    rig.feed(b"*\r\n");
    assert!(rig.take_sent().is_empty());
    assert!(matches!(
        rig.events[..],
        [
            PtuEvent::MoveAccepted {
                target_steps: 0,
                ..
            },
            PtuEvent::Halted
        ]
    ));

    let full = (0..100).find_map(|n| rig.driver.set_speed(Axis::Pan, 31 + n, rig.now).err());
    assert_eq!(full, Some(RequestError::QueueFull { waiting: 32 }));
    rig.events.clear();
    rig.take_sent();
    rig.feed(b"*\r\n");
    rig.answer_all(&mut replies);
    assert_eq!(rig.events.len(), 33);
    rig.events.clear();
    rig.driver.hold_power_low(rig.now).expect("connected");
    assert_eq!(rig.answer_all(&mut replies), ["PHL", "THL"]);
    assert_eq!(rig.events, [PtuEvent::HoldPowerLow]);
}

#[test]
fn a_query_without_reply_is_repeated() {
    let (mut rig, _) = PtuTestRig::connected();
    rig.driver
        .poll_position(Axis::Pan, rig.now)
        .expect("connected");
    assert_eq!(rig.next_send(), "PP ");
    assert_eq!(rig.next_send(), " ", "half a second later: a space");
    assert_eq!(rig.next_send(), "PP ");
    rig.feed(b"* 22\r\n");
    assert!(matches!(
        rig.only_event(),
        PtuEvent::Position { steps: 22, .. }
    ));
}

#[test]
fn a_late_reply_is_not_taken_for_the_next_one() {
    let (mut rig, _) = PtuTestRig::connected();
    rig.driver
        .poll_position(Axis::Pan, rig.now)
        .expect("connected");
    rig.driver
        .poll_position(Axis::Tilt, rig.now)
        .expect("connected");
    assert_eq!(rig.next_send(), "PP ");
    rig.pass_deadline();
    rig.feed(b"* 11\r\n");
    assert_eq!(rig.next_send(), " ");
    assert_eq!(rig.next_send(), "PP ");
    rig.feed(b"* 22\r\n");
    assert_eq!(rig.next_send(), "TP ");
    rig.feed(b"* 33\r\n");
    rig.take_sent();
    let positions: Vec<(Axis, i32)> = rig
        .events
        .iter()
        .map(|e| match e {
            PtuEvent::Position { axis, steps, .. } => (*axis, *steps),
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(positions, [(Axis::Pan, 22), (Axis::Tilt, 33)]);
}

#[test]
fn half_a_reply_is_no_part_of_the_next() {
    let (mut rig, _) = PtuTestRig::connected();
    rig.driver
        .poll_position(Axis::Pan, rig.now)
        .expect("connected");
    assert_eq!(rig.next_send(), "PP ");
    rig.feed(b"* 12");
    assert_eq!(rig.next_send(), " ");
    assert_eq!(rig.next_send(), "PP ");
    rig.feed(b"* 22\r\n");
    assert!(matches!(
        rig.only_event(),
        PtuEvent::Position { steps: 22, .. }
    ));
}

#[test]
fn an_unsolicited_line_causes_a_resynchronisation() {
    let (mut rig, _) = PtuTestRig::connected();
    rig.feed(b"* 5\r\n");
    rig.driver
        .poll_position(Axis::Pan, rig.now)
        .expect("connected");
    assert_eq!(rig.next_send(), " ");
    rig.feed(b"* 6\r\n");
    assert_eq!(rig.next_send(), "PP ");
    rig.feed(b"* 7\r\n");
    assert!(matches!(
        rig.only_event(),
        PtuEvent::Position { steps: 7, .. }
    ));
}

#[test]
fn a_unit_that_falls_silent_ends_the_connection() {
    let (mut rig, _) = PtuTestRig::connected();
    rig.driver
        .poll_position(Axis::Pan, rig.now)
        .expect("connected");
    while rig.driver.deadline().is_some() {
        rig.take_sent();
        rig.pass_deadline();
    }
    let fault = HeadError::NoReply {
        command: "PP".into(),
        tries: 3,
        heard: String::new(),
    };
    assert_eq!(rig.only_event(), PtuEvent::Fault(fault));
    assert!(!rig.driver.is_connected());
}

#[test]
fn a_limit_event_in_the_middle_of_a_reply() {
    let (mut rig, mut replies) = PtuTestRig::connected();
    rig.driver.reset(rig.now).expect("connected");
    rig.feed(b"!T!T!P!P*\r\n");
    rig.answer_all(&mut replies);
    rig.events.clear();
    rig.driver
        .poll_position(Axis::Pan, rig.now)
        .expect("connected");
    rig.take_sent();
    rig.feed(b"* 3!P0!T90\r\n");
    rig.take_sent();
    assert!(matches!(
        rig.events[..],
        [
            PtuEvent::LimitHit(Axis::Pan),
            PtuEvent::LimitHit(Axis::Tilt),
            PtuEvent::Position { steps: 3090, .. }
        ]
    ));
    rig.events.clear();
    rig.feed(b"!D");
    assert_eq!(rig.only_event(), PtuEvent::CableLost);
}

#[test]
fn a_refusal_changes_nothing_and_carries_the_units_text() {
    let (mut rig, _) = PtuTestRig::connected();
    rig.driver
        .move_to(Axis::Pan, 4000, rig.now)
        .expect("connected");
    assert_eq!(rig.take_sent(), ["PP4000 "]);
    rig.feed(b"! Maximum allowable Pan position is 3090\r\n");
    let text = "Maximum allowable Pan position is 3090".to_owned();
    assert_eq!(
        rig.only_event(),
        PtuEvent::Refused {
            command: "PP4000".into(),
            text
        }
    );
    assert!(rig.driver.is_connected());
}

#[test]
fn a_reset_takes_any_order_of_stops_and_reads_the_limits_anew() {
    for reply in ["!T!T!P!P*\r\n", "!P!P!T!T!T*\r\n", "*\r\n", "!T!T*\r"] {
        let (mut rig, mut replies) = PtuTestRig::connected();
        rig.driver.reset(rig.now).expect("connected");
        assert_eq!(rig.take_sent(), ["R "]);
        rig.now += Duration::from_secs(30);
        rig.driver.handle_deadline(rig.now);
        assert!(rig.take_sent().is_empty());
        rig.feed(reply.as_bytes());
        assert_eq!(rig.answer_all(&mut replies), ["PN", "PX", "TN", "TX", "L"]);
        assert!(matches!(
            rig.only_event(),
            PtuEvent::HomeDone {
                tilt: AxisLimits {
                    min_steps: -907,
                    max_steps: 604
                },
                ..
            }
        ));
    }
}

#[test]
fn a_reset_with_a_notice_that_is_not_one_of_its_stops_has_failed() {
    // The cable at any time; a limit only after the end.
    for (during, after) in [
        ("!T!D!T!P!P*\r\n", ""),
        ("!T!T!P!P*\r\n", "!P"),
        ("*\r\n", "!T0!D"),
    ] {
        let (mut rig, mut replies) = PtuTestRig::connected();
        rig.driver.reset(rig.now).expect("connected");
        rig.take_sent();
        rig.feed(during.as_bytes());
        rig.feed(after.as_bytes());
        rig.answer_all(&mut replies);
        assert!(
            matches!(
                rig.events.last(),
                Some(PtuEvent::Fault(HeadError::ResetFailed { .. }))
            ),
            "{during:?} {after:?}: {:?}",
            rig.events
        );
        assert!(rig.driver.is_connected());
        rig.events.clear();
        rig.driver.reset(rig.now).expect("connected");
        rig.feed(b"!T!T!P!P*\r\n");
        rig.answer_all(&mut replies);
        assert!(matches!(rig.only_event(), PtuEvent::HomeDone { .. }));
    }
}

#[test]
fn a_reset_that_fails_or_never_ends() {
    let (mut rig, _) = PtuTestRig::connected();
    rig.driver.reset(rig.now).expect("connected");
    rig.take_sent();
    rig.feed(b"!T! Axis Error\r\n");
    assert_eq!(
        rig.only_event(),
        PtuEvent::Fault(HeadError::ResetFailed {
            text: "Axis Error".into()
        })
    );
    assert!(rig.driver.is_connected());

    // What spoilt one reset does not spoil the next.
    let (mut rig, mut replies) = PtuTestRig::connected();
    for (answer, succeeds) in [("!D! Axis Error\r\n", false), ("!T!T!P!P*\r\n", true)] {
        rig.driver.reset(rig.now).expect("connected");
        rig.take_sent();
        rig.feed(answer.as_bytes());
        rig.answer_all(&mut replies);
        let last = rig.events.last();
        let homed = matches!(last, Some(PtuEvent::HomeDone { .. }));
        assert_eq!(homed, succeeds, "{last:?}");
    }
    rig.events.clear();

    rig.driver.reset(rig.now).expect("connected");
    rig.take_sent();
    rig.pass_deadline();
    assert_eq!(
        rig.only_event(),
        PtuEvent::Fault(HeadError::ResetTimedOut { waited_s: 60 })
    );
}

#[test]
fn lost_settings_are_detected_and_restored() {
    for (echo, verbose, wanted) in [
        (true, false, PtuEvent::EchoReturned),
        (false, true, PtuEvent::VerboseReturned),
    ] {
        let (mut rig, mut replies) = PtuTestRig::connected();
        (replies.echo, replies.verbose) = (echo, verbose);
        rig.driver
            .poll_position(Axis::Pan, rig.now)
            .expect("connected");
        rig.answer_all(&mut replies);
        assert_eq!(rig.events.len(), 2, "{:?}", rig.events);
        assert_eq!(rig.events[0], wanted);
        assert!(matches!(rig.events[1], PtuEvent::Connected(_)));
    }
    let (mut rig, mut replies) = PtuTestRig::connected();
    rig.feed(b"\r\n### PAN-TILT CONTROLLER\r\n### v2\r\nInitializing...*\r\n");
    rig.answer_all(&mut replies);
    assert!(matches!(
        rig.events[..],
        [PtuEvent::Restarted, PtuEvent::Connected(_)]
    ));
}

#[test]
fn damaged_numbers_are_queried_again_and_noise_is_ignored() {
    let (mut rig, _) = PtuTestRig::connected();
    rig.driver
        .poll_position(Axis::Pan, rig.now)
        .expect("connected");
    rig.take_sent();
    rig.feed(b"* 1\xff00\r\n");
    assert_eq!(rig.next_send(), " ");
    assert_eq!(rig.next_send(), "PP ");
    rig.feed(b"\xff\xfe\r\n\x00* 100\r\n");
    assert!(matches!(
        rig.only_event(),
        PtuEvent::Position { steps: 100, .. }
    ));
}

#[test]
fn health_is_read_and_a_unit_without_it_is_reported() {
    let (mut rig, _) = PtuTestRig::connected();
    rig.driver.query_health(rig.now).expect("connected");
    rig.take_sent();
    rig.feed(b"* 29.8,104,95,93\r\n");
    assert!(matches!(rig.only_event(), PtuEvent::Health(h) if h.temperatures_c.len() == 3));
    rig.driver.query_health(rig.now).expect("connected");
    rig.take_sent();
    rig.feed(b"! Illegal command\r\n");
    assert!(matches!(rig.only_event(), PtuEvent::Refused { command, .. } if command == "O"));
}
