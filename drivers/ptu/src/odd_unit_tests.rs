//! Units and lines that answer oddly: they connect with the right values where they can, else one line says what was heard,
//! what it is and what to do.

use std::time::Duration;

use crate::test_rig::{PtuTestRig, ScriptedReplies};
use crate::{AxisLimits, HeadError, HeadLine, PtuDriver, PtuEvent, PtuOptions};

/// How an odd unit or line answers the bytes that were sent.
type Answer<'a> = &'a mut dyn FnMut(&mut PtuTestRig, &[u8]);

/// Connects; the event that ends it, and how long it took.
fn connect(answer: Answer<'_>) -> (PtuEvent, Duration) {
    let mut rig = PtuTestRig::new();
    let began = rig.now;
    rig.driver.connect(rig.now);
    while rig.driver.deadline().is_some() {
        let sent = rig.take_sent();
        if sent.is_empty() {
            rig.pass_deadline();
        }
        for bytes in sent {
            answer(&mut rig, bytes.as_bytes());
        }
    }
    rig.take_sent();
    assert_eq!(rig.events.len(), 1, "{:?}", rig.events);
    (rig.events.remove(0), rig.now - began)
}

fn fault(answer: Answer<'_>) -> HeadError {
    let (event, took) = connect(answer);
    assert!(took < Duration::from_secs(13), "{took:?}");
    match event {
        PtuEvent::Fault(error) => error,
        other => panic!("{other:?}"),
    }
}

/// The commands in what was sent, each answered as by a good unit.
fn replies(unit: &mut ScriptedReplies, sent: &[u8]) -> Vec<String> {
    let text = std::str::from_utf8(sent).expect("ASCII");
    text.split_whitespace()
        .map(|command| unit.answer(command))
        .collect()
}

#[test]
fn what_is_no_pan_tilt_unit_is_named_with_an_excerpt_and_a_remedy() {
    let wrong = [0x00, 0xF8, 0x80, 0xE0, b'~'];
    let mut laser = Vec::new();
    let cases: [(Answer<'_>, HeadLine, &str); 6] = [
        (
            &mut |rig, sent| {
                for at in 0..sent.len() {
                    rig.feed(&[wrong[at % 5]]);
                }
            },
            HeadLine::NotText,
            "line rate",
        ),
        (
            &mut |rig, sent| rig.feed(sent),
            HeadLine::Loopback,
            "bridged",
        ),
        (
            // SCIP 2.0 answers whole lines.
            &mut |rig, sent| {
                laser.extend_from_slice(sent);
                if laser.last() == Some(&b'\r') {
                    laser.pop();
                    let line = std::mem::take(&mut laser);
                    rig.feed(&[&line[..], b"\n0Ee\n\n"].concat());
                }
            },
            HeadLine::Laser,
            "exchange the two ports",
        ),
        (
            &mut |rig, sent| rig.feed(&[sent, b"\r\nERROR\r\n"].concat()),
            HeadLine::Modem,
            "ERROR",
        ),
        (
            &mut |rig, _| rig.feed(b"! Illegal command\r\n"),
            HeadLine::OtherReplies,
            "other programs",
        ),
        (
            &mut |rig, _| rig.feed(b"$GPRMC,1,V\r\n"),
            HeadLine::OtherText,
            "GPRMC",
        ),
    ];
    for (answer, expected, text) in cases {
        let error = fault(answer);
        let message = error.to_string();
        let HeadError::NotAHead { line, .. } = error else {
            panic!("{message}")
        };
        assert_eq!(line, expected, "{message}");
        assert!(
            message.starts_with("heard \"") && message.contains(text),
            "{message}"
        );
        assert!(!message.contains('\n'), "one line: {message}");
    }
    assert_eq!(fault(&mut |_, _| {}), HeadError::Silent);
}

#[test]
fn replies_that_come_twice_are_never_taken_for_others() {
    let mut unit = ScriptedReplies::default();
    let error = fault(&mut |rig, sent| {
        for reply in replies(&mut unit, sent) {
            rig.feed(reply.repeat(2).as_bytes());
        }
    });
    let text = error.to_string();
    assert!(matches!(error, HeadError::OutOfStep { .. }), "{text}");
    assert!(text.contains("replies come twice"), "{text}");
}

#[test]
fn one_reply_that_comes_twice_is_found_wherever_it_is() {
    let (mut sent_once, mut unit) = (Vec::new(), ScriptedReplies::default());
    connect(&mut |rig, sent| {
        for reply in replies(&mut unit, sent) {
            sent_once.push(());
            rig.feed(reply.as_bytes());
        }
    });
    for twice in 0..sent_once.len() {
        let (mut count, mut unit) = (0, ScriptedReplies::default());
        let (event, _) = connect(&mut |rig, sent| {
            for reply in replies(&mut unit, sent) {
                let times = if count == twice { 2 } else { 1 };
                count += 1;
                rig.feed(reply.repeat(times).as_bytes());
            }
        });
        let PtuEvent::Connected(identity) = event else {
            panic!("reply {twice}: {event:?}")
        };
        let limits = |min_steps, max_steps| AxisLimits {
            min_steps,
            max_steps,
        };
        assert_eq!(identity.pan.limits, limits(-3090, 3091), "reply {twice}");
        assert_eq!(identity.tilt.limits, limits(-907, 604), "reply {twice}");
        for axis in [identity.pan, identity.tilt] {
            let speeds = (axis.speed_min, axis.speed_max, axis.speed);
            assert_eq!(speeds, (31, 2902, 1000), "reply {twice}");
            assert_eq!((axis.base_speed, axis.acceleration), (1000, 2000));
        }
    }
}

#[test]
fn the_limits_after_a_reset_are_checked_too() {
    let (mut rig, mut unit) = PtuTestRig::connected();
    rig.driver.reset(rig.now).expect("connected");
    assert_eq!(rig.next_send(), "R ");
    rig.feed(b"!T!T!P!P*\r\n");
    // The first limit twice: the others would be shifted by one.
    let mut twice = true;
    while rig.driver.deadline().is_some() {
        let sent = rig.take_sent();
        if sent.is_empty() {
            rig.pass_deadline();
        }
        for command in sent.concat().split_whitespace() {
            let times = if std::mem::take(&mut twice) { 2 } else { 1 };
            let reply = unit.answer(command).repeat(times);
            rig.feed(reply.as_bytes());
        }
    }
    rig.take_sent();
    let [PtuEvent::HomeDone { pan, tilt }] = rig.events[..] else {
        panic!("{:?}", rig.events)
    };
    assert_eq!((pan.min_steps, pan.max_steps), (-3090, 3091));
    assert_eq!((tilt.min_steps, tilt.max_steps), (-907, 604));
}

#[test]
fn replies_within_half_a_second_are_in_time() {
    for after in [Duration::from_millis(350), Duration::from_millis(499)] {
        let mut unit = ScriptedReplies::default();
        let (event, _) = connect(&mut |rig, sent| {
            for reply in replies(&mut unit, sent) {
                rig.now += after;
                rig.feed(reply.as_bytes());
            }
        });
        assert!(matches!(event, PtuEvent::Connected(_)), "{event:?}");
    }
}

#[test]
fn a_unit_that_takes_a_third_of_a_second_is_connected_within_13_seconds() {
    let mut unit = ScriptedReplies::default();
    let (event, took) = connect(&mut |rig, sent| {
        for reply in replies(&mut unit, sent) {
            rig.now += Duration::from_millis(350);
            rig.feed(reply.as_bytes());
        }
    });
    assert!(matches!(event, PtuEvent::Connected(_)), "{event:?}");
    // The health that `devices` asks for is one reply more.
    assert!(took < Duration::from_millis(12_650), "{took:?}");
}

#[test]
fn late_replies_are_drained_before_all_is_read_again() {
    // Now and then a reply comes 0.3 s after its time-out.
    for every in [4, 5, 7, 9] {
        let mut unit = ScriptedReplies::default();
        let (mut count, mut late) = (0, None);
        let mut rig = PtuTestRig::new();
        rig.driver.connect(rig.now);
        while let Some(due) = rig.driver.deadline() {
            let sent = rig.take_sent();
            if sent.is_empty() {
                let due_reply = late.as_ref().map(|(at, _): &(Duration, String)| *at);
                match due_reply {
                    Some(at) if at <= due => {
                        let (at, reply) = late.take().expect("due");
                        rig.now = rig.now.max(at);
                        rig.feed(reply.as_bytes());
                    }
                    _ => rig.pass_deadline(),
                }
            }
            for command in sent.concat().split_whitespace() {
                count += 1;
                let reply = unit.answer(command);
                // The first time round only: a unit that is always late cannot be read.
                if count % every == 0 && count < 40 {
                    late = Some((rig.now + Duration::from_millis(900), reply));
                } else {
                    rig.feed(reply.as_bytes());
                }
            }
        }
        rig.take_sent();
        let Some(PtuEvent::Connected(identity)) = rig.events.last() else {
            panic!("every {every}: {:?}", rig.events)
        };
        assert_eq!(identity.pan.limits.max_steps, 3091, "every {every}");
        assert_eq!(identity.tilt.limits.min_steps, -907, "every {every}");
    }
}

#[test]
fn a_unit_that_starts_while_it_is_asked_is_waited_for() {
    // It takes no command until a second after its banner.
    let mut unit = ScriptedReplies::default();
    let mut banner = Some(());
    let (event, _) = connect(&mut |rig, sent| {
        if banner.take().is_some() {
            rig.feed(b"\r\n\r\n### PAN-TILT CONTROLLER\r\n### v2.12\r\nInitializing...");
            rig.now += Duration::from_secs(8);
            rig.feed(b"!T!T!P!P*\r\n");
            return;
        }
        for reply in replies(&mut unit, sent) {
            rig.feed(reply.as_bytes());
        }
    });
    let PtuEvent::Connected(identity) = event else {
        panic!("{event:?}")
    };
    assert!(identity.calibration_seen);
}

#[test]
fn while_a_rate_is_searched_garbage_ends_the_attempt() {
    for (bytes, within_ms) in [(&b"\xf8\x80\x00"[..], 900), (b"* \r\n", 10_000)] {
        let mut rig = PtuTestRig::new();
        rig.driver = PtuDriver::new(PtuOptions {
            gives_up_on_garbage: true,
            ..PtuOptions::default()
        });
        let began = rig.now;
        rig.driver.connect(rig.now);
        while rig.driver.deadline().is_some() {
            for _ in rig.take_sent() {
                rig.feed(bytes);
            }
            rig.pass_deadline();
        }
        rig.take_sent();
        assert!(matches!(
            rig.events[..],
            [PtuEvent::Fault(HeadError::NotAHead { .. })]
        ));
        let took = rig.now - began;
        assert!(took < Duration::from_millis(within_ms), "{took:?}");
        assert_eq!(within_ms > 900, took > Duration::from_secs(2), "{took:?}");
    }
}
