//! Dialogues while connecting, fed byte by byte.

use std::time::Duration;

use crate::test_rig::{PtuTestRig, ScriptedReplies};
use crate::{Axis, AxisLimits, HeadError, HeadLine, PtuDriver, PtuEvent, PtuOptions, RequestError};

#[test]
fn connects_from_every_state_and_line_end() {
    for (echo, verbose) in [(false, false), (false, true), (true, false), (true, true)] {
        for line_end in ["\r\n", "\r", "\n"] {
            let mut rig = PtuTestRig::new();
            let mut replies = ScriptedReplies {
                echo,
                verbose,
                line_end,
                overrides: Vec::new(),
            };
            let seen = rig.connect_with(&mut replies);
            assert_eq!(seen[..7], ["ED", "FT", "V", "H", "CI", "I", "LE"]);
            assert_eq!(seen[seen.len() - 2..], ["O", "E"]);
            let [PtuEvent::Connected(identity)] = &rig.events[..] else {
                panic!("{:?}", rig.events)
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
            assert!(!identity.calibration_seen);
        }
    }
}

#[test]
fn recorded_echoes_while_echo_is_switched_off_are_accepted() {
    // ptu-d46 section 2: `ED *\r\n*\r\n` on a unit that echoes, the reply of `ED` split from that of `FT`.
    let mut rig = PtuTestRig::new();
    rig.driver.connect(rig.now);
    assert_eq!(rig.next_send(), "   ");
    rig.feed(b"   ");
    assert_eq!(rig.next_send(), "ED ");
    rig.feed(b"ED *\r\n");
    assert_eq!(rig.next_send(), "FT ");
    rig.feed(b"*\r\n");
    assert_eq!(rig.next_send(), "V ");
}

#[test]
fn a_line_without_valid_replies_is_reported_with_what_was_heard() {
    let mut rig = PtuTestRig::new();
    rig.driver.connect(rig.now);
    while rig.driver.deadline().is_some() {
        rig.take_sent();
        rig.feed(&[0xff, 0x80, 0x00]);
        rig.pass_deadline();
    }
    rig.take_sent();
    let [
        PtuEvent::Fault(HeadError::NotAHead {
            line, bytes_heard, ..
        }),
    ] = rig.events[..]
    else {
        panic!("{:?}", rig.events)
    };
    assert!(bytes_heard > 10);
    assert_eq!(line, HeadLine::NotText);
    assert!(!rig.driver.is_connected());
    assert_eq!(
        rig.driver.move_to(Axis::Pan, 0, rig.now),
        Err(RequestError::NotConnected)
    );
}

#[test]
fn the_network_rescue_comes_last_and_only_if_enabled() {
    let mut rig = PtuTestRig::new();
    rig.driver = PtuDriver::new(PtuOptions {
        network_rescue: true,
        ..PtuOptions::default()
    });
    rig.driver.connect(rig.now);
    let mut sent = Vec::new();
    while rig.driver.deadline().is_some() {
        sent.extend(rig.take_sent());
        rig.pass_deadline();
    }
    assert_eq!(sent.iter().filter(|s| *s == " _0 U0 ").count(), 1);
    assert_eq!(sent.iter().filter(|s| *s == "V ").count(), 4);
}

#[test]
fn a_power_up_banner_is_waited_for() {
    let (mut rig, mut replies) = (PtuTestRig::new(), ScriptedReplies::default());
    rig.driver.connect(rig.now);
    rig.take_sent();
    rig.feed(b"\r\n\r\n### PAN-TILT CONTROLLER\r\n### v2.12.1, (C)2003 Directed Perception, All Rights Reserved\r\nInitializing...!T!T");
    rig.now += Duration::from_secs(12);
    rig.driver.handle_deadline(rig.now);
    assert!(
        rig.take_sent().is_empty(),
        "nothing is sent into a calibration"
    );
    rig.feed(b"!P!P*\r\n");
    let seen = rig.answer_all(&mut replies);
    assert_eq!(seen[0], "ED");
    let [PtuEvent::Connected(identity)] = &rig.events[..] else {
        panic!("{:?}", rig.events)
    };
    assert!(identity.calibration_seen);
}

#[test]
fn a_calibration_that_never_ends_is_a_fault() {
    let mut rig = PtuTestRig::new();
    rig.driver.connect(rig.now);
    let began = rig.now;
    while rig.driver.deadline().is_some() {
        rig.take_sent();
        rig.feed(b"!T");
        rig.pass_deadline();
    }
    rig.take_sent();
    assert_eq!(
        rig.events.last(),
        Some(&PtuEvent::Fault(HeadError::CalibrationTimedOut {
            waited_s: 60
        }))
    );
    assert!(rig.now - began < Duration::from_secs(70));
}

#[test]
fn replies_of_other_firmware_are_accepted() {
    // ptu-d46 section 12, second row; the capital letter of later models; a unit that does not report its supply.
    let (mut rig, mut replies) = (PtuTestRig::new(), ScriptedReplies::default());
    replies.overrides = vec![
        ("CI", "* independent (default) speed control mode"),
        ("C", "* Independent speed control mode"),
        ("O", "! Illegal command"),
        ("PR", "* 185.1428 seconds arc per Pan position"),
        ("TR", "* 46.2857"),
    ];
    rig.connect_with(&mut replies);
    let [PtuEvent::Connected(identity)] = &rig.events[..] else {
        panic!("{:?}", rig.events)
    };
    assert!(identity.health.is_none());
    assert!((identity.tilt.step.radians().to_degrees() - 0.9 / 70.0).abs() < 1e-15);
}

#[test]
fn a_setting_that_is_not_accepted_is_a_fault_after_three_tries() {
    for (query, reply, wanted) in [
        (
            "L",
            "* Limit bounds are DISABLED (hard limits only: use care)",
            "enabled",
        ),
        ("E", "* Echoing ON", "off"),
        ("C", "* Pure Velocity speed control mode", "independent"),
    ] {
        let (mut rig, mut replies) = (PtuTestRig::new(), ScriptedReplies::default());
        replies.overrides = vec![(query, reply)];
        let seen = rig.connect_with(&mut replies);
        assert_eq!(seen.iter().filter(|c| *c == "V").count(), 3);
        let fault = HeadError::SettingNotTaken {
            command: query.into(),
            expected: wanted.into(),
            got: reply.trim_start_matches("* ").into(),
        };
        assert_eq!(rig.events, [PtuEvent::Fault(fault)]);
    }
}

#[test]
fn a_refused_or_impossible_property_is_a_fault() {
    for (query, reply, times) in [
        ("PN", "! Axis Error", 1),
        ("TX", "* -907", 5),
        ("PR", "* 0", 5),
    ] {
        let (mut rig, mut replies) = (PtuTestRig::new(), ScriptedReplies::default());
        replies.overrides = vec![(query, reply)];
        let seen = rig.connect_with(&mut replies);
        let asked = seen.iter().filter(|command| *command == query).count();
        assert_eq!(asked, times, "{query}: a refusal is final, a value is not");
        let [PtuEvent::Fault(fault)] = &rig.events[..] else {
            panic!("{:?}", rig.events)
        };
        match fault {
            HeadError::SetupRefused { command, .. } if times == 1 => assert_eq!(command, query),
            HeadError::ImpossibleValue { command, got, .. } => {
                assert_eq!(
                    (command.as_str(), format!("* {got}").as_str()),
                    (query, reply)
                );
            }
            other => panic!("{other}"),
        }
        assert!(!rig.driver.is_connected());
    }
}

#[test]
fn a_value_that_cannot_be_is_read_again() {
    let (mut rig, mut replies) = (PtuTestRig::new(), ScriptedReplies::default());
    replies.overrides = vec![("TX", "* -907")];
    rig.driver.connect(rig.now);
    let mut asked = 0;
    for _ in 0..500 {
        let sent = rig.take_sent();
        if sent.is_empty() && rig.driver.deadline().is_none() {
            break;
        }
        if sent.is_empty() {
            rig.pass_deadline();
        }
        for command in sent.concat().split_whitespace() {
            asked += usize::from(command == "TX");
            if asked == 2 {
                replies.overrides.clear();
            }
            let answer = replies.answer(command);
            rig.feed(answer.as_bytes());
        }
    }
    let [PtuEvent::Connected(identity)] = &rig.events[..] else {
        panic!("{:?}", rig.events)
    };
    assert_eq!((identity.tilt.limits.max_steps, asked), (604, 2));
}
