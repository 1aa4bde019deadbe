//! Units that answer oddly: they connect where they can, else one line says what was heard, what it is and what to do.

mod common;

use common::{II, PP, SplitMix64, VV, drain, summed};
use scip::{LaserEvent, LaserLine, ReplyError, ScipDriver, ScipError, ScipOptions, StatusMeaning};
use std::time::Duration;

/// How an odd unit answers a request.
type Answer<'a> = &'a mut dyn FnMut(&str) -> Vec<u8>;

/// A URG-04LX in SCIP 2.0.
fn urg(request: &str) -> Vec<u8> {
    let reply = match request {
        "VV" => VV.to_owned(),
        "PP" => PP.to_owned(),
        "II" => II.to_owned(),
        "SCIP2.0" => "SCIP2.0\n0Ee\n\n".to_owned(),
        "TM1" => "TM1\n00P\n<SfkP\n\n".to_owned(),
        other => format!("{other}\n00P\n\n"),
    };
    reply.into_bytes()
}

/// The same, with another reply to `PP`.
fn with_parameters(lines: &[&str]) -> impl FnMut(&str) -> Vec<u8> {
    let body: String = lines
        .iter()
        .map(|line| {
            let summed = summed(line);
            let (text, sum) = summed.split_at(line.len());
            format!("{text};{sum}")
        })
        .collect();
    let reply = format!("PP\n00P\n{body}\n");
    move |request| match request {
        "PP" => reply.clone().into_bytes(),
        other => urg(other),
    }
}

/// Lets the driver work until nothing is due: what happened, and how long it took.
fn run(driver: &mut ScipDriver, answer: Answer<'_>) -> (Vec<LaserEvent>, Duration) {
    let (mut now, mut events) = (Duration::ZERO, Vec::new());
    loop {
        let (sent, new) = drain(driver);
        events.extend(new);
        if sent.is_empty() {
            let Some(due) = driver.deadline() else {
                return (events, now);
            };
            now = now.max(due);
            driver.handle_deadline(now);
        }
        for request in sent {
            now += Duration::from_millis(20);
            driver.handle_bytes(&answer(request.trim_end()), now);
        }
    }
}

fn connect(mut answer: impl FnMut(&str) -> Vec<u8>) -> LaserEvent {
    let mut driver = ScipDriver::new(ScipOptions::default());
    driver.connect(Duration::ZERO);
    let (mut events, took) = run(&mut driver, &mut answer);
    assert!(took < Duration::from_secs(13), "{took:?}");
    events.retain(|event| !matches!(event, LaserEvent::Rejected { .. }));
    assert_eq!(events.len(), 1, "{events:?}");
    events.remove(0)
}

fn fault(answer: impl FnMut(&str) -> Vec<u8>) -> ScipError {
    match connect(answer) {
        LaserEvent::ConnectionFailed(error) => error,
        other => panic!("{other:?}"),
    }
}

#[test]
fn lines_that_end_in_cr_lf_are_taken() {
    let crlf = |request: &str| {
        let reply = String::from_utf8(urg(request)).expect("ASCII");
        reply.replace('\n', "\r\n").into_bytes()
    };
    let LaserEvent::Connected(identity) = connect(crlf) else {
        panic!("not connected")
    };
    assert_eq!(identity.serial, "H0706400");
    assert_eq!(identity.status, "Sensor works well.");
}

#[test]
fn what_is_no_laser_is_named_with_an_excerpt_and_a_remedy() {
    let mut rng = SplitMix64(7);
    let mut random = SplitMix64(8);
    let cases: [(Answer<'_>, LaserLine, &str); 6] = [
        (
            &mut |request: &str| {
                let wrong = [0x00, 0xF8, 0x80, 0xE0, b'~'];
                request.bytes().map(|_| wrong[rng.below(5)]).collect()
            },
            LaserLine::NotText,
            "line rate",
        ),
        (
            &mut |_: &str| (0..200).map(|_| random.next() as u8).collect(),
            LaserLine::NotText,
            "noise",
        ),
        (
            &mut |request: &str| format!("{request}\r\nERROR\r\n").into_bytes(),
            LaserLine::Modem,
            "ERROR",
        ),
        (
            &mut |request: &str| format!("{request}\n").into_bytes(),
            LaserLine::Loopback,
            "bridged",
        ),
        (
            &mut |request: &str| format!("{request}\r\n! Illegal command\r\n").into_bytes(),
            LaserLine::PanTilt,
            "exchange the two ports",
        ),
        (
            &mut |_: &str| b"$GPRMC,1,V*00\r\n".to_vec(),
            LaserLine::OtherText,
            "GPRMC",
        ),
    ];
    for (answer, expected, text) in cases {
        let error = fault(answer);
        let message = error.to_string();
        let ScipError::NotALaser { line, bytes, .. } = error else {
            panic!("{message}")
        };
        assert_eq!(line, expected, "{message}");
        assert!(bytes > 0 && message.contains(text), "{message}");
        assert!(message.starts_with("heard \""), "{message}");
        assert!(!message.contains('\n'), "one line: {message}");
    }
}

#[test]
fn while_a_rate_is_searched_garbage_ends_the_attempt_and_silence_does_not() {
    let options = ScipOptions {
        gives_up_on_garbage: true,
        ..ScipOptions::default()
    };
    for (bytes, took_s) in [(&b"\xf8\x80\x00"[..], 1), (b"", 6), (b"hello\n", 6)] {
        let mut driver = ScipDriver::new(options.clone());
        driver.connect(Duration::ZERO);
        let (events, took) = run(&mut driver, &mut |_| bytes.to_vec());
        assert!(matches!(
            events.last(),
            Some(LaserEvent::ConnectionFailed(_))
        ));
        let late = took.saturating_sub(Duration::from_secs(took_s));
        assert!(took >= Duration::from_secs(took_s) && late < Duration::from_millis(200));
    }
}

#[test]
fn a_rate_that_is_only_tried_is_given_up_soon_and_a_sensor_there_has_all_its_time() {
    let options = ScipOptions {
        probe: Some((Duration::from_millis(400), 1)),
        ..ScipOptions::default()
    };
    let mut driver = ScipDriver::new(options.clone());
    driver.connect(Duration::ZERO);
    let (_, took) = run(&mut driver, &mut |_| Vec::new());
    assert_eq!(
        took,
        Duration::from_millis(800),
        "QT and SCIP2.0, once each"
    );
    // The second and the third answer are lost, and come after a second each.
    let mut driver = ScipDriver::new(options);
    driver.connect(Duration::ZERO);
    let mut lost = 0;
    let (events, took) = run(&mut driver, &mut |request| {
        if request == "VV" && lost < 2 {
            lost += 1;
            return Vec::new();
        }
        urg(request)
    });
    assert!(
        matches!(events.last(), Some(LaserEvent::Connected(_))),
        "{events:?}"
    );
    assert!(took > Duration::from_secs(2), "{took:?}");
}

#[test]
fn a_mute_line_is_silent() {
    let error = fault(|_| Vec::new());
    assert!(matches!(error, ScipError::NoReply { .. }), "{error}");
}

#[test]
fn a_unit_of_scip_1_1_only_is_named() {
    let error = fault(|request| format!("{request}\nE\n\n").into_bytes());
    let message = error.to_string();
    assert!(matches!(error, ScipError::Scip11Only { .. }), "{message}");
    assert!(message.contains("SCIP2.0\\nE\""), "{message}");
    // A refusal of another kind is none.
    let error = fault(|request| match request {
        "SCIP2.0" => b"SCIP2.0\n0Bb\n\n".to_vec(),
        other => format!("{other}\nE\n\n").into_bytes(),
    });
    assert!(matches!(error, ScipError::BadReply { .. }), "{error}");
}

#[test]
fn parameters_that_cannot_be_are_questioned_and_named() {
    let lines = |changed: &[(usize, &'static str)]| {
        let mut lines = vec![
            "MODL:URG-04LX(Hokuyo Automatic Co.,Ltd.)",
            "DMIN:20",
            "DMAX:5600",
            "ARES:1024",
            "AMIN:44",
            "AMAX:725",
            "AFRT:384",
            "SCAN:600",
        ];
        for (at, line) in changed {
            lines[*at] = line;
        }
        lines
    };
    assert!(matches!(
        connect(with_parameters(&lines(&[]))),
        LaserEvent::Connected(_)
    ));
    for (changed, key) in [
        (
            &[(3, "ARES:3"), (4, "AMIN:0"), (5, "AMAX:99999")][..],
            "AMAX",
        ),
        (&[(3, "ARES:0"), (7, "SCAN:0")], "ARES"),
        (&[(1, "DMIN:-20"), (4, "AMIN:-44")], "DMIN"),
    ] {
        let error = fault(with_parameters(&lines(changed)));
        let ScipError::BadReply {
            attempts: 3,
            ref last,
            ..
        } = error
        else {
            panic!("{error}")
        };
        assert!(
            matches!(last, ReplyError::Value { key: named, .. } if *named == key),
            "{error}"
        );
    }
    let error = fault(with_parameters(&lines(&[])[..4]));
    assert!(
        error
            .to_string()
            .contains("no AMIN in the reply to PP, which has \"MODL DMIN DMAX ARES\""),
        "{error}"
    );
}

#[test]
fn a_refused_time_exchange_says_that_it_was_refused() {
    let mut denied = |request: &str| match request {
        "TM0" => b"TM0\n10Q\n\n".to_vec(),
        other => urg(other),
    };
    let mut driver = ScipDriver::new(ScipOptions::default());
    driver.connect(Duration::ZERO);
    run(&mut driver, &mut denied);
    let _ = driver.exchange_time(20, Duration::ZERO);
    let (events, took) = run(&mut driver, &mut denied);
    assert!(took < Duration::from_secs(13), "{took:?}");
    let Some(LaserEvent::RequestFailed(ScipError::BadReply { last, .. })) = events.last() else {
        panic!("{events:?}")
    };
    assert_eq!(last.refusal(), Some(StatusMeaning::Denied));
}
