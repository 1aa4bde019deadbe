//! Whole dialogues against scripted replies, fed byte by byte.

use std::time::Duration;

use crate::{Action, Axis, AxisLimits, Event, Head, HeadError, HeadOptions, Instant, RequestError};

const BYTE: Duration = Duration::from_micros(1042);

/// The unit's replies, and what it remembers: the forms of section 3, nothing of its motion.
struct Replies {
    echo: bool,
    verbose: bool,
    line_end: &'static str,
}

impl Replies {
    fn answer(&mut self, command: &str) -> String {
        let echo = if self.echo {
            format!("{command} ")
        } else {
            String::new()
        };
        let numeric = |terse: &str, verbose: &str| {
            if self.verbose {
                verbose.to_owned()
            } else {
                format!(" {terse}")
            }
        };
        let body = match command {
            "ED" => {
                self.echo = false;
                String::new()
            }
            "FT" => {
                self.verbose = false;
                String::new()
            }
            "V" => {
                " Pan-Tilt Controller v2.12.1d1(C14/E), (C)2003 Directed Perception, Inc.".into()
            }
            "CI" | "I" | "LE" | "H" | "PHL" | "THL" => String::new(),
            "E" => " Echoing OFF".into(),
            "F" => " ASCII terse mode".into(),
            "C" => " independent (default) speed control mode".into(),
            "L" => " Limit bounds are ENABLED (soft limits enabled)".into(),
            "PR" | "TR" => numeric("185.1428", " 185.1428 seconds arc per Pan position"),
            "PN" => numeric("-3090", " Minimum Pan position is -3090"),
            "PX" => numeric("3091", " Maximum Pan position is 3091"),
            "TN" => " -907".into(),
            "TX" => " 604".into(),
            "PL" | "TL" => " 31".into(),
            "PU" | "TU" => " 2902".into(),
            "PS" | "TS" | "PB" | "TB" => " 1000".into(),
            "PA" | "TA" => " 2000".into(),
            "O" => " Input 30 VDC @ 86 degF".into(),
            "PP" => numeric("22", " Current Pan position is 22"),
            "TP" => numeric("-7", " Current Tilt position is -7"),
            _ => String::new(),
        };
        format!("{echo}*{body}{}", self.line_end)
    }
}

struct Bench {
    head: Head,
    now: Instant,
    events: Vec<Event>,
}

impl Bench {
    fn new() -> Self {
        Self {
            head: Head::new(HeadOptions::default()),
            now: Duration::from_secs(100),
            events: Vec::new(),
        }
    }

    /// Takes all actions; gives what was sent.
    fn sends(&mut self) -> Vec<String> {
        let mut sent = Vec::new();
        while let Some(action) = self.head.poll_action() {
            match action {
                Action::Send(bytes) => {
                    sent.push(String::from_utf8(bytes).expect("commands are ASCII"))
                }
                Action::Event(event) => self.events.push(event),
            }
        }
        sent
    }

    fn feed(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.now += BYTE;
            self.head.handle_bytes(&[*byte], self.now);
        }
    }

    fn to_deadline(&mut self) {
        self.now = self
            .head
            .deadline()
            .expect("something is waited for")
            .max(self.now);
        self.head.handle_deadline(self.now);
    }

    /// Lets time pass until something is sent.
    fn next_send(&mut self) -> String {
        for _ in 0..20 {
            let mut sent = self.sends();
            if let Some(first) = sent.pop() {
                assert!(
                    sent.is_empty(),
                    "more than one command at once: {sent:?} {first:?}"
                );
                return first;
            }
            self.to_deadline();
        }
        panic!("nothing is sent");
    }

    fn connect_with(&mut self, replies: &mut Replies) -> Vec<String> {
        self.head.connect(self.now);
        self.go_on(replies)
    }

    /// Answers everything until the driver is connected and idle; gives the commands seen.
    fn go_on(&mut self, replies: &mut Replies) -> Vec<String> {
        let mut seen = Vec::new();
        for _ in 0..500 {
            let sent = self.sends();
            if sent.is_empty() {
                if self.head.deadline().is_none() {
                    return seen;
                }
                self.to_deadline();
            }
            for command in sent.concat().split(' ').filter(|c| !c.is_empty()) {
                seen.push(command.to_owned());
                let answer = replies.answer(command);
                self.feed(answer.as_bytes());
            }
        }
        panic!("no end after {seen:?}");
    }

    fn connected() -> (Self, Replies) {
        let (mut bench, mut replies) = (
            Self::new(),
            Replies {
                echo: true,
                verbose: true,
                line_end: "\r\n",
            },
        );
        bench.connect_with(&mut replies);
        assert!(matches!(bench.events.pop(), Some(Event::Connected(_))));
        (bench, replies)
    }

    fn event(&mut self) -> Event {
        assert!(
            self.sends().is_empty(),
            "an event was expected, not a command"
        );
        assert_eq!(self.events.len(), 1, "{:?}", self.events);
        self.events.remove(0)
    }
}

#[test]
fn connects_from_every_state_and_line_end() {
    for (echo, verbose) in [(false, false), (false, true), (true, false), (true, true)] {
        for line_end in ["\r\n", "\r", "\n"] {
            let mut bench = Bench::new();
            let mut replies = Replies {
                echo,
                verbose,
                line_end,
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
        bench.to_deadline();
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
        bench.to_deadline();
    }
    assert_eq!(sent.iter().filter(|s| *s == " _0 U0 ").count(), 1);
    assert_eq!(sent.iter().filter(|s| *s == "V ").count(), 4);
}

#[test]
fn a_power_up_banner_is_waited_for() {
    let (mut bench, mut replies) = (
        Bench::new(),
        Replies {
            echo: true,
            verbose: true,
            line_end: "\r\n",
        },
    );
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
        bench.to_deadline();
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
    bench.to_deadline();
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
        bench.to_deadline();
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
    bench.to_deadline();
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
