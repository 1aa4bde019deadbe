//! Streaming and its end, byte by byte.

mod common;

use common::streaming::{ACK, ECHO, PLAN, REQUEST, connected, scan, sort, streaming};
use common::{ScriptedLaser, scan_message};
use scip::{LaserEvent, STAMP_MODULUS_MS, ScipDriver, ScipError, ScipOptions, StreamPlan};
use std::time::Duration;

#[test]
fn scans_carry_the_instants_of_their_first_and_last_byte() {
    let mut script = streaming();
    let bytes = scan(5000);
    let at = |ms| start() + Duration::from_millis(ms);
    fn start() -> Duration {
        Duration::from_secs(100)
    }
    script.driver.handle_bytes(&bytes[..1], at(1));
    script.driver.handle_bytes(&bytes[1..2000], at(4));
    script.driver.handle_bytes(&bytes[2000..], at(7));
    let events = script.take_events();
    let [
        LaserEvent::Scan {
            scan,
            first_byte_at,
            last_byte_at,
        },
    ] = events.as_slice()
    else {
        panic!("{events:?}")
    };
    assert_eq!((*first_byte_at, *last_byte_at), (at(1), at(7)));
    assert_eq!(
        (
            scan.ranges.len(),
            scan.first_step,
            scan.cluster,
            scan.stamp_ms
        ),
        (682, 44, 1, 5000)
    );
}

#[test]
fn scans_follow_across_the_wrap_of_the_timer() {
    let mut script = streaming();
    for stamp in [STAMP_MODULUS_MS - 150, STAMP_MODULUS_MS - 50, 49, 149] {
        script.reply(scan(stamp));
    }
    let (stamps, others) = sort(script.take_events());
    assert_eq!(
        stamps,
        [STAMP_MODULUS_MS - 150, STAMP_MODULUS_MS - 50, 49, 149]
    );
    assert_eq!(others, []);
}

#[test]
fn an_interval_stretches_the_period() {
    let mut script = connected();
    script
        .driver
        .start_streaming(
            StreamPlan {
                interval: 2,
                last_step: 47,
                ..PLAN
            },
            script.now,
        )
        .expect("idle");
    script.exchange("MD0044004701200\n", "MD0044004701200\n00P\n\n");
    for stamp in [100, 400, 699, 1299] {
        script.reply(scan_message("MD0044004701200", "99", stamp, &[900; 4]));
    }
    let (stamps, others) = sort(script.take_events());
    assert_eq!(stamps, [100, 400, 699, 1299]);
    assert_eq!(others, [LaserEvent::Streaming, LaserEvent::LostScans(1)]);
}

#[test]
fn statuses_in_mid_stream_are_events() {
    let mut script = streaming();
    script.reply(scan(100));
    script.reply(format!("{ECHO}\n21S\n\n"));
    let time_left = script.driver.deadline().expect("still waiting") - script.now;
    assert_eq!(
        time_left,
        Duration::from_secs(10),
        "verifying takes its time"
    );
    script.reply(format!("{ECHO}\n98a\n\n"));
    script.reply(scan(3130));
    let (stamps, others) = sort(script.take_events());
    assert_eq!(stamps, [100, 3130]);
    assert_eq!(
        others,
        [
            LaserEvent::Verifying { status: 21 },
            LaserEvent::VerifiedNormal,
            LaserEvent::LostScans(29)
        ]
    );

    script.reply(format!("{ECHO}\n50U\n\n"));
    script.expect_sent(&["QT\n"]);
    assert_eq!(
        script.events,
        [LaserEvent::ConnectionFailed(ScipError::Hardware {
            status: 50
        })]
    );
}

#[test]
fn a_slow_link_is_given_its_time() {
    let options = ScipOptions {
        link_bytes_per_second: Some(1920),
        ..Default::default()
    };
    let mut script = ScriptedLaser::connected(ScipDriver::new(options));
    script
        .driver
        .start_streaming(PLAN, script.now)
        .expect("idle");
    script.exchange(REQUEST, ACK);
    script.reply(scan(100));
    let time_left = script.driver.deadline().expect("streaming") - script.now;
    assert!(
        time_left > Duration::from_millis(3300),
        "2137 bytes take 1.1 s at 19200 baud: {time_left:?}"
    );
}

#[test]
fn stopping_skips_the_scan_in_flight_and_asks_again() {
    let mut script = streaming();
    script.driver.stop(script.now);
    script.expect_sent(&["QT\n"]);
    script.reply(scan(100));
    script.time_out();
    script.exchange("QT\n", "QT\n00P\n\n");
    assert_eq!(script.take_events(), [LaserEvent::Stopped]);
    // Idle again: anything may follow.
    script
        .driver
        .start_streaming(PLAN, script.now)
        .expect("idle");
    script.expect_sent(&[REQUEST]);
}

#[test]
fn a_refused_plan_leaves_the_sensor_idle() {
    let mut script = connected();
    let plan = StreamPlan {
        last_step: 1080,
        ..PLAN
    };
    script
        .driver
        .start_streaming(plan, script.now)
        .expect("the device must judge it");
    script.exchange("MD0044108001000\n", "MD0044108001000\n04T\n\n");
    let events = script.take_events();
    assert!(
        matches!(
            events.last(),
            Some(LaserEvent::RequestFailed(ScipError::BadReply { .. }))
        ),
        "{events:?}"
    );
    assert!(script.driver.start_streaming(PLAN, script.now).is_ok());

    let mut script = connected();
    let backwards = StreamPlan {
        first_step: 726,
        ..PLAN
    };
    assert!(matches!(
        script.driver.start_streaming(backwards, script.now),
        Err(ScipError::Plan { .. })
    ));
    let sparse = StreamPlan {
        interval: 10,
        ..PLAN
    };
    assert!(matches!(
        script.driver.start_streaming(sparse, script.now),
        Err(ScipError::Plan { .. })
    ));
}

/// The whole dialogue gives the same events however the bytes are cut.
#[test]
fn chunking_changes_nothing() {
    let stream: Vec<u8> = [100, 200, 400, 500].into_iter().flat_map(scan).collect();
    let run = |longest: usize, seed: u64| {
        let mut script = streaming();
        for chunk in common::chunks(&stream, longest, &mut common::SplitMix64(seed)) {
            script.driver.handle_bytes(&chunk, script.now);
        }
        script.take_events()
    };
    let whole = run(usize::MAX / 2, 0);
    assert_eq!(sort(whole.clone()).0, [100, 200, 400, 500]);
    for seed in 0..30 {
        assert_eq!(run(1 + seed as usize * 17, seed), whole);
    }
}

#[test]
fn requests_are_refused_while_streaming() {
    let mut script = streaming();
    let refused = ScipError::NotReady {
        request: "a time exchange",
        state: "streaming",
    };
    assert_eq!(script.driver.exchange_time(1, script.now), Err(refused));
    script.expect_sent(&[]);
}
