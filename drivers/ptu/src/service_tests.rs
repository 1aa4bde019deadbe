//! Dialogues of a connected unit, fed byte by byte.

use std::time::Duration;

use crate::bench::{BYTE, Bench};
use crate::{Axis, AxisLimits, Event, HeadError, RequestError};

#[test]
fn a_poll_carries_both_its_instants() {
    let (mut bench, _) = Bench::connected();
    let asked = bench.now;
    bench
        .head
        .poll_position(Axis::Tilt, asked)
        .expect("connected");
    assert_eq!(bench.sends(), ["TP "]);
    bench.now += Duration::from_millis(5);
    bench.feed(b"* -1234\r\n");
    let first_byte_at = asked + Duration::from_millis(5) + BYTE;
    let Event::Position {
        axis,
        steps,
        sent_at,
        first_byte_at: first,
    } = bench.event()
    else {
        panic!("no position")
    };
    assert_eq!((axis, steps, first), (Axis::Tilt, -1234, first_byte_at));
    assert_eq!(
        sent_at - asked,
        Duration::from_secs(30) / 9600,
        "three bytes at 9600 baud"
    );

    bench
        .head
        .poll_position(Axis::Tilt, bench.now)
        .expect("connected");
    bench.sends();
    bench.head.sent(bench.now + Duration::from_secs(1));
    bench.feed(b"* 5\r\n");
    let Event::Position {
        sent_at,
        first_byte_at,
        ..
    } = bench.event()
    else {
        panic!("no position")
    };
    assert_eq!(sent_at, first_byte_at, "never after the reply");
}

#[test]
fn one_command_is_in_flight_and_the_rest_wait() {
    let (mut bench, mut replies) = Bench::connected();
    for target in 0..3 {
        bench
            .head
            .move_to(Axis::Pan, target, bench.now)
            .expect("connected");
    }
    assert_eq!(bench.sends(), ["PP0 "]);
    assert_eq!(bench.head.pending(), 3);
    bench.head.halt(bench.now).expect("connected");
    bench.feed(b"*\r\n");
    assert_eq!(
        bench.sends(),
        ["H "],
        "a halt goes before waiting moves and drops them"
    );
    bench.feed(b"*\r\n");
    assert!(bench.sends().is_empty());
    assert!(matches!(
        bench.events[..],
        [
            Event::MoveAccepted {
                target_steps: 0,
                ..
            },
            Event::Halted
        ]
    ));

    let full = (0..100).find_map(|n| bench.head.set_speed(Axis::Pan, 31 + n, bench.now).err());
    assert_eq!(full, Some(RequestError::QueueFull { waiting: 32 }));
    bench.events.clear();
    bench.sends();
    bench.feed(b"*\r\n");
    bench.go_on(&mut replies);
    assert_eq!(bench.events.len(), 33);
    bench.events.clear();
    bench.head.hold_power_low(bench.now).expect("connected");
    assert_eq!(bench.go_on(&mut replies), ["PHL", "THL"]);
    assert_eq!(bench.events, [Event::HoldPowerLow]);
}

#[test]
fn a_lost_reply_is_asked_for_again() {
    let (mut bench, _) = Bench::connected();
    bench
        .head
        .poll_position(Axis::Pan, bench.now)
        .expect("connected");
    assert_eq!(bench.next_send(), "PP ");
    assert_eq!(bench.next_send(), " ", "half a second later: a space");
    assert_eq!(bench.next_send(), "PP ");
    bench.feed(b"* 22\r\n");
    assert!(matches!(bench.event(), Event::Position { steps: 22, .. }));
    assert_eq!(bench.head.counters().retries, 1);
}

#[test]
fn a_late_reply_is_not_taken_for_the_next_one() {
    let (mut bench, _) = Bench::connected();
    bench
        .head
        .poll_position(Axis::Pan, bench.now)
        .expect("connected");
    bench
        .head
        .poll_position(Axis::Tilt, bench.now)
        .expect("connected");
    assert_eq!(bench.next_send(), "PP ");
    bench.pass_deadline();
    bench.feed(b"* 11\r\n");
    assert_eq!(bench.next_send(), " ");
    assert_eq!(bench.next_send(), "PP ");
    bench.feed(b"* 22\r\n");
    assert_eq!(bench.next_send(), "TP ");
    bench.feed(b"* 33\r\n");
    bench.sends();
    let positions: Vec<(Axis, i32)> = bench
        .events
        .iter()
        .map(|e| match e {
            Event::Position { axis, steps, .. } => (*axis, *steps),
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(positions, [(Axis::Pan, 22), (Axis::Tilt, 33)]);
    assert_eq!(bench.head.counters().unmatched_lines, 1);
}

#[test]
fn an_unasked_line_brings_the_dialogue_back_into_step() {
    let (mut bench, _) = Bench::connected();
    bench.feed(b"* 5\r\n");
    bench
        .head
        .poll_position(Axis::Pan, bench.now)
        .expect("connected");
    assert_eq!(bench.next_send(), " ");
    bench.feed(b"* 6\r\n");
    assert_eq!(bench.next_send(), "PP ");
    bench.feed(b"* 7\r\n");
    assert!(matches!(bench.event(), Event::Position { steps: 7, .. }));
    assert_eq!(bench.head.counters().unmatched_lines, 2);
}

#[test]
fn a_unit_that_falls_silent_ends_the_connection() {
    let (mut bench, _) = Bench::connected();
    bench
        .head
        .poll_position(Axis::Pan, bench.now)
        .expect("connected");
    while bench.head.deadline().is_some() {
        bench.sends();
        bench.pass_deadline();
    }
    let fault = HeadError::NoReply {
        command: "PP".into(),
        tries: 3,
        heard: String::new(),
    };
    assert_eq!(bench.event(), Event::Fault(fault));
    assert!(!bench.head.is_connected());
}

#[test]
fn a_limit_event_in_the_middle_of_a_reply() {
    let (mut bench, mut replies) = Bench::connected();
    bench.head.reset(bench.now).expect("connected");
    bench.feed(b"!T!T!P!P*\r\n");
    bench.go_on(&mut replies);
    assert!(bench.head.position_trusted());
    bench.events.clear();
    bench
        .head
        .poll_position(Axis::Pan, bench.now)
        .expect("connected");
    bench.sends();
    bench.feed(b"* 3!P0!T90\r\n");
    bench.sends();
    assert!(matches!(
        bench.events[..],
        [
            Event::LimitHit(Axis::Pan),
            Event::LimitHit(Axis::Tilt),
            Event::Position { steps: 3090, .. }
        ]
    ));
    assert!(!bench.head.position_trusted());
    bench.events.clear();
    bench.feed(b"!D");
    assert_eq!(bench.event(), Event::CableLost);
}

#[test]
fn a_refusal_changes_nothing_and_carries_the_words() {
    let (mut bench, _) = Bench::connected();
    bench
        .head
        .move_to(Axis::Pan, 4000, bench.now)
        .expect("connected");
    assert_eq!(bench.sends(), ["PP4000 "]);
    bench.feed(b"! Maximum allowable Pan position is 3090\r\n");
    let text = "Maximum allowable Pan position is 3090".to_owned();
    assert_eq!(
        bench.event(),
        Event::Refused {
            command: "PP4000".into(),
            text
        }
    );
    assert!(bench.head.is_connected());
}

#[test]
fn a_reset_takes_any_order_of_stops_and_reads_the_limits_anew() {
    for reply in ["!T!T!P!P*\r\n", "!P!P!T!T!T*\r\n", "*\r\n", "!T!T*\r"] {
        let (mut bench, mut replies) = Bench::connected();
        bench.head.reset(bench.now).expect("connected");
        assert_eq!(bench.sends(), ["R "]);
        bench.now += Duration::from_secs(30);
        bench.head.handle_deadline(bench.now);
        assert!(bench.sends().is_empty());
        bench.feed(reply.as_bytes());
        assert_eq!(bench.go_on(&mut replies), ["PN", "PX", "TN", "TX"]);
        assert!(matches!(
            bench.event(),
            Event::HomeDone {
                tilt: AxisLimits {
                    min_steps: -907,
                    max_steps: 604
                },
                ..
            }
        ));
        assert!(bench.head.position_trusted());
    }
}

#[test]
fn a_reset_with_a_notice_that_is_none_of_its_stops_has_failed() {
    // The cable at any time; a limit only after the end.
    for (during, after) in [
        ("!T!D!T!P!P*\r\n", ""),
        ("!T!T!P!P*\r\n", "!P"),
        ("*\r\n", "!T0!D"),
    ] {
        let (mut bench, mut replies) = Bench::connected();
        bench.head.reset(bench.now).expect("connected");
        bench.sends();
        bench.feed(during.as_bytes());
        bench.feed(after.as_bytes());
        bench.go_on(&mut replies);
        assert!(
            matches!(
                bench.events.last(),
                Some(Event::Fault(HeadError::ResetFailed { .. }))
            ),
            "{during:?} {after:?}: {:?}",
            bench.events
        );
        assert!(bench.head.is_connected() && !bench.head.position_trusted());
        bench.events.clear();
        bench.head.reset(bench.now).expect("connected");
        bench.feed(b"!T!T!P!P*\r\n");
        bench.go_on(&mut replies);
        assert!(matches!(bench.event(), Event::HomeDone { .. }));
        assert!(bench.head.position_trusted());
    }
}

#[test]
fn a_reset_that_fails_or_never_ends() {
    let (mut bench, _) = Bench::connected();
    bench.head.reset(bench.now).expect("connected");
    bench.sends();
    bench.feed(b"!T! Axis Error\r\n");
    assert_eq!(
        bench.event(),
        Event::Fault(HeadError::ResetFailed {
            text: "Axis Error".into()
        })
    );
    assert!(bench.head.is_connected() && !bench.head.position_trusted());

    bench.head.reset(bench.now).expect("connected");
    bench.sends();
    bench.pass_deadline();
    assert_eq!(
        bench.event(),
        Event::Fault(HeadError::ResetTimedOut { waited_s: 60 })
    );
}

#[test]
fn lost_settings_are_noticed_and_made_again() {
    for (echo, verbose, wanted) in [
        (true, false, Event::EchoReturned),
        (false, true, Event::VerboseReturned),
    ] {
        let (mut bench, mut replies) = Bench::connected();
        (replies.echo, replies.verbose) = (echo, verbose);
        bench
            .head
            .poll_position(Axis::Pan, bench.now)
            .expect("connected");
        bench.go_on(&mut replies);
        assert_eq!(bench.events.len(), 2, "{:?}", bench.events);
        assert_eq!(bench.events[0], wanted);
        assert!(matches!(bench.events[1], Event::Connected(_)));
        assert!(!bench.head.position_trusted());
    }
    let (mut bench, mut replies) = Bench::connected();
    bench.feed(b"\r\n### PAN-TILT CONTROLLER\r\n### v2\r\nInitializing...*\r\n");
    bench.go_on(&mut replies);
    assert!(matches!(
        bench.events[..],
        [Event::Restarted, Event::Connected(_)]
    ));
}

#[test]
fn damaged_numbers_are_asked_for_again_and_dirt_is_overlooked() {
    let (mut bench, _) = Bench::connected();
    bench
        .head
        .poll_position(Axis::Pan, bench.now)
        .expect("connected");
    bench.sends();
    bench.feed(b"* 1\xff00\r\n");
    assert_eq!(bench.next_send(), " ");
    assert_eq!(bench.next_send(), "PP ");
    bench.feed(b"\xff\xfe\r\n\x00* 100\r\n");
    assert!(matches!(bench.event(), Event::Position { steps: 100, .. }));
}

#[test]
fn health_is_read_and_a_unit_without_it_says_so() {
    let (mut bench, _) = Bench::connected();
    bench.head.query_health(bench.now).expect("connected");
    bench.sends();
    bench.feed(b"* 29.8,104,95,93\r\n");
    assert!(matches!(bench.event(), Event::Health(h) if h.temperatures_c.len() == 3));
    bench.head.query_health(bench.now).expect("connected");
    bench.sends();
    bench.feed(b"! Illegal command\r\n");
    assert!(matches!(bench.event(), Event::Refused { command, .. } if command == "O"));
}
