//! Streaming and its end, byte by byte.

mod common;

use common::streaming::{ACK, ECHO, PLAN, REQUEST, connected, scan, sort, streaming};
use common::{Story, scan_message};
use scip::{Event, Instant, STAMP_MODULUS_MS, Sensor, SensorError, SensorOptions, StreamPlan};

#[test]
fn scans_carry_the_instants_of_their_first_and_last_byte() {
    let mut story = streaming();
    let bytes = scan(5000);
    let at = |ms| story_start() + Instant::from_millis(ms);
    fn story_start() -> Instant {
        Instant::from_secs(100)
    }
    story.sensor.handle_bytes(&bytes[..1], at(1));
    story.sensor.handle_bytes(&bytes[1..2000], at(4));
    story.sensor.handle_bytes(&bytes[2000..], at(7));
    let events = story.take_events();
    let [
        Event::Scan {
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
    let mut story = streaming();
    for stamp in [STAMP_MODULUS_MS - 150, STAMP_MODULUS_MS - 50, 49, 149] {
        story.reply(scan(stamp));
    }
    let (stamps, others) = sort(story.take_events());
    assert_eq!(
        stamps,
        [STAMP_MODULUS_MS - 150, STAMP_MODULUS_MS - 50, 49, 149]
    );
    assert_eq!(others, []);
}

#[test]
fn an_interval_stretches_the_period() {
    let mut story = connected();
    story
        .sensor
        .start_streaming(
            StreamPlan {
                interval: 2,
                last_step: 47,
                ..PLAN
            },
            story.now,
        )
        .expect("idle");
    story.turn("MD0044004701200\n", "MD0044004701200\n00P\n\n");
    for stamp in [100, 400, 699, 1299] {
        story.reply(scan_message("MD0044004701200", "99", stamp, &[900; 4]));
    }
    let (stamps, others) = sort(story.take_events());
    assert_eq!(stamps, [100, 400, 699, 1299]);
    assert_eq!(others, [Event::Streaming, Event::LostScans(1)]);
}

#[test]
fn statuses_in_mid_stream_are_events() {
    let mut story = streaming();
    story.reply(scan(100));
    story.reply(format!("{ECHO}\n21S\n\n"));
    let patience = story.sensor.deadline().expect("still waiting") - story.now;
    assert_eq!(patience, Instant::from_secs(10), "verifying takes its time");
    story.reply(format!("{ECHO}\n98a\n\n"));
    story.reply(scan(3130));
    let (stamps, others) = sort(story.take_events());
    assert_eq!(stamps, [100, 3130]);
    assert_eq!(
        others,
        [
            Event::Verifying { status: 21 },
            Event::VerifiedNormal,
            Event::LostScans(29)
        ]
    );

    story.reply(format!("{ECHO}\n50U\n\n"));
    story.expect_sent(&["QT\n"]);
    assert_eq!(
        story.events,
        [Event::Fault(SensorError::Hardware { status: 50 })]
    );
}

#[test]
fn a_slow_link_is_given_its_time() {
    let options = SensorOptions {
        link_bytes_per_second: Some(1920),
        ..Default::default()
    };
    let mut story = Story::connected(Sensor::new(options));
    story.sensor.start_streaming(PLAN, story.now).expect("idle");
    story.turn(REQUEST, ACK);
    story.reply(scan(100));
    let patience = story.sensor.deadline().expect("streaming") - story.now;
    assert!(
        patience > Instant::from_millis(3300),
        "2137 bytes take 1.1 s at 19200 baud: {patience:?}"
    );
}

#[test]
fn stopping_skips_the_scan_in_flight_and_asks_again() {
    let mut story = streaming();
    story.sensor.stop(story.now);
    story.expect_sent(&["QT\n"]);
    story.reply(scan(100));
    story.silence();
    story.turn("QT\n", "QT\n00P\n\n");
    assert_eq!(story.take_events(), [Event::Stopped]);
    // Idle again: anything may follow.
    story.sensor.start_streaming(PLAN, story.now).expect("idle");
    story.expect_sent(&[REQUEST]);
}

#[test]
fn a_refused_plan_leaves_the_sensor_idle() {
    let mut story = connected();
    let plan = StreamPlan {
        last_step: 1080,
        ..PLAN
    };
    story
        .sensor
        .start_streaming(plan, story.now)
        .expect("the device must judge it");
    story.turn("MD0044108001000\n", "MD0044108001000\n04T\n\n");
    let events = story.take_events();
    assert!(
        matches!(
            events.last(),
            Some(Event::Failed(SensorError::BadReply { .. }))
        ),
        "{events:?}"
    );
    assert!(story.sensor.start_streaming(PLAN, story.now).is_ok());

    let mut story = connected();
    let backwards = StreamPlan {
        first_step: 726,
        ..PLAN
    };
    assert!(matches!(
        story.sensor.start_streaming(backwards, story.now),
        Err(SensorError::Plan { .. })
    ));
    let sparse = StreamPlan {
        interval: 10,
        ..PLAN
    };
    assert!(matches!(
        story.sensor.start_streaming(sparse, story.now),
        Err(SensorError::Plan { .. })
    ));
}

/// The whole dialogue gives the same events however the bytes are cut.
#[test]
fn chunking_changes_nothing() {
    let stream: Vec<u8> = [100, 200, 400, 500].into_iter().flat_map(scan).collect();
    let run = |longest: usize, seed: u64| {
        let mut story = streaming();
        for chunk in common::chunks(&stream, longest, &mut common::Dice(seed)) {
            story.sensor.handle_bytes(&chunk, story.now);
        }
        story.take_events()
    };
    let whole = run(usize::MAX / 2, 0);
    assert_eq!(sort(whole.clone()).0, [100, 200, 400, 500]);
    for seed in 0..30 {
        assert_eq!(run(1 + seed as usize * 17, seed), whole);
    }
}

#[test]
fn questions_are_refused_while_streaming() {
    let mut story = streaming();
    let refused = SensorError::NotReady {
        request: "a query",
        state: "streaming",
    };
    assert_eq!(story.sensor.query_info(story.now), Err(refused));
    story.expect_sent(&[]);
}
