//! Dialogues of connecting, fed byte by byte.

use std::time::Duration;

use crate::bench::{Bench, Replies};
use crate::{Axis, AxisLimits, Event, Head, HeadError, HeadOptions, RequestError};

#[test]
fn connects_from_every_state_and_line_end() {
    for (echo, verbose) in [(false, false), (false, true), (true, false), (true, true)] {
        for line_end in ["\r\n", "\r", "\n"] {
            let mut bench = Bench::new();
            let mut replies = Replies {
                echo,
                verbose,
                line_end,
                instead: Vec::new(),
            };
            let seen = bench.connect_with(&mut replies);
            assert_eq!(seen[..7], ["ED", "FT", "V", "H", "CI", "I", "LE"]);
            assert_eq!(seen.last().map(String::as_str), Some("O"));
            let [Event::Connected(identity)] = &bench.events[..] else {
                panic!("{:?}", bench.events)
            };
            assert!(identity.version.contains("v2.12.1d1"));
            assert_eq!(
                identity.pan.limits,
                AxisLimits {
                    min_steps: -3090,
                    max_steps: 3091
                }
            );
            assert_eq!(
                identity.tilt.limits,
                AxisLimits {
                    min_steps: -907,
                    max_steps: 604
                }
            );
            assert!((identity.tilt.step.radians().to_degrees() - 0.9 / 17.5).abs() < 1e-15);
            assert_eq!(
                (
                    identity.pan.speed_min,
                    identity.pan.speed_max,
                    identity.pan.base_speed
                ),
                (31, 2902, 1000)
            );
            assert!(
                identity
                    .health
                    .as_ref()
                    .is_some_and(|h| (h.supply_volts - 30.0).abs() < 1e-9)
            );
            assert!(!identity.calibration_seen && !bench.head.position_trusted());
            assert_eq!(bench.head.counters(), crate::Counters::default());
        }
    }
}

#[test]
fn the_recorded_echoes_of_switching_echo_off_are_taken() {
    // Section 2: `ED *\r\n*\r\n` on a unit that echoes, the reply of `ED` split from that of `FT`.
    let mut bench = Bench::new();
    bench.head.connect(bench.now);
    assert_eq!(bench.next_send(), "   ");
    bench.feed(b"   ");
    assert_eq!(bench.next_send(), "ED ");
    bench.feed(b"ED *\r\n");
    assert_eq!(bench.next_send(), "FT ");
    bench.feed(b"*\r\n");
    assert_eq!(bench.next_send(), "V ");
}

#[test]
fn a_deaf_or_silent_line_is_said_to_be_so() {
    let mut bench = Bench::new();
    bench.head.connect(bench.now);
    while bench.head.deadline().is_some() {
        bench.sends();
        bench.feed(&[0xff, 0x80, 0x00]);
        bench.pass_deadline();
    }
    bench.sends();
    let [Event::Fault(HeadError::Silent { bytes_heard })] = bench.events[..] else {
        panic!("{:?}", bench.events)
    };
    assert!(bytes_heard > 10);
    assert!(!bench.head.is_connected());
    assert_eq!(
        bench.head.move_to(Axis::Pan, 0, bench.now),
        Err(RequestError::NotConnected)
    );
}

#[test]
fn the_network_rescue_comes_last_and_only_if_asked_for() {
    let mut bench = Bench::new();
    bench.head = Head::new(HeadOptions {
        network_rescue: true,
        ..HeadOptions::default()
    });
    bench.head.connect(bench.now);
    let mut sent = Vec::new();
    while bench.head.deadline().is_some() {
        sent.extend(bench.sends());
        bench.pass_deadline();
    }
    assert_eq!(sent.iter().filter(|s| *s == " _0 U0 ").count(), 1);
    assert_eq!(sent.iter().filter(|s| *s == "V ").count(), 4);
}

#[test]
fn a_power_up_banner_is_waited_for() {
    let (mut bench, mut replies) = (Bench::new(), Replies::default());
    bench.head.connect(bench.now);
    bench.sends();
    bench.feed(b"\r\n\r\n### PAN-TILT CONTROLLER\r\n### v2.12.1, (C)2003 Directed Perception, All Rights Reserved\r\nInitializing...!T!T");
    bench.now += Duration::from_secs(12);
    bench.head.handle_deadline(bench.now);
    assert!(
        bench.sends().is_empty(),
        "nothing is sent into a calibration"
    );
    bench.feed(b"!P!P*\r\n");
    let seen = bench.go_on(&mut replies);
    assert_eq!(seen[0], "ED");
    let [Event::Connected(identity)] = &bench.events[..] else {
        panic!("{:?}", bench.events)
    };
    assert!(identity.calibration_seen && bench.head.position_trusted());
}

#[test]
fn a_calibration_that_never_ends_is_a_fault() {
    let mut bench = Bench::new();
    bench.head.connect(bench.now);
    let began = bench.now;
    while bench.head.deadline().is_some() {
        bench.sends();
        bench.feed(b"!T");
        bench.pass_deadline();
    }
    bench.sends();
    assert_eq!(
        bench.events.last(),
        Some(&Event::Fault(HeadError::CalibrationTimedOut {
            waited_s: 60
        }))
    );
    assert!(bench.now - began < Duration::from_secs(70));
}

#[test]
fn units_that_answer_otherwise_are_taken() {
    // Section 12, second row, the capital letter of later models, and a unit that does not tell its supply.
    let (mut bench, mut replies) = (Bench::new(), Replies::default());
    replies.instead = vec![
        ("CI", "* independent (default) speed control mode"),
        ("C", "* Independent speed control mode"),
        ("O", "! Illegal command"),
        ("PR", "* 185.1428 seconds arc per Pan position"),
        ("TR", "* 46.2857"),
    ];
    bench.connect_with(&mut replies);
    let [Event::Connected(identity)] = &bench.events[..] else {
        panic!("{:?}", bench.events)
    };
    assert!(identity.health.is_none());
    assert!((identity.tilt.step.radians().to_degrees() - 0.9 / 70.0).abs() < 1e-15);
}

#[test]
fn a_setting_that_is_not_taken_is_a_fault_after_three_tries() {
    for (query, reply, wanted) in [
        (
            "L",
            "* Limit bounds are DISABLED (hard limits only: use care)",
            "enabled",
        ),
        ("E", "* Echoing ON", "off"),
        ("C", "* Pure Velocity speed control mode", "independent"),
    ] {
        let (mut bench, mut replies) = (Bench::new(), Replies::default());
        replies.instead = vec![(query, reply)];
        let seen = bench.connect_with(&mut replies);
        assert_eq!(seen.iter().filter(|c| *c == "V").count(), 3);
        let fault = HeadError::SettingNotTaken {
            command: query.into(),
            expected: wanted.into(),
            got: reply.trim_start_matches("* ").into(),
        };
        assert_eq!(bench.events, [Event::Fault(fault)]);
    }
}

#[test]
fn a_refused_or_impossible_property_is_a_fault() {
    for (query, reply) in [("PN", "! Axis Error"), ("TX", "* -907"), ("PR", "* 0")] {
        let (mut bench, mut replies) = (Bench::new(), Replies::default());
        replies.instead = vec![(query, reply)];
        bench.connect_with(&mut replies);
        assert!(
            matches!(
                bench.events[..],
                [Event::Fault(HeadError::SetupRefused { .. })]
            ),
            "{:?}",
            bench.events
        );
        assert!(!bench.head.is_connected());
    }
}
