//! Streaming, its checks and its recovery, byte by byte.

mod common;

use common::{Story, scan_message};
use scip::{
    Coding, Event, Instant, RecoveryCause, RecoveryStep, Rejection, ReplyError, STAMP_MODULUS_MS,
    Sensor, SensorError, SensorOptions, StreamPlan,
};

const PLAN: StreamPlan = StreamPlan {
    first_step: 44,
    last_step: 725,
    cluster: 1,
    interval: 0,
    coding: Coding::ThreeCharacter,
    count: 0,
};
const REQUEST: &str = "MD0044072501000\n";
const ECHO: &str = "MD0044072501000";
const ACK: &str = "MD0044072501000\n00P\n\n";

fn connected() -> Story {
    Story::connected(Sensor::new(SensorOptions::default()))
}

fn streaming() -> Story {
    let mut story = connected();
    story.sensor.start_streaming(PLAN, story.now).expect("idle");
    story.turn(REQUEST, ACK);
    assert_eq!(story.take_events(), [Event::Streaming]);
    story
}

fn scan(stamp_ms: u32) -> Vec<u8> {
    scan_message(ECHO, "99", stamp_ms, &[1234; 682])
}

/// The stamps of the scans among the events, and the other events.
fn sort(events: Vec<Event>) -> (Vec<u32>, Vec<Event>) {
    let (scans, others): (Vec<_>, Vec<_>) = events
        .into_iter()
        .partition(|event| matches!(event, Event::Scan { .. }));
    let stamps = scans.into_iter().filter_map(|event| match event {
        Event::Scan { scan, .. } => Some(scan.stamp_ms),
        _ => None,
    });
    (stamps.collect(), others)
}

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
fn gaps_are_counted_and_a_damaged_scan_costs_itself_only() {
    let mut story = streaming();
    let mut damaged = scan(200);
    damaged[1000] ^= 1;
    story.reply(scan(100));
    story.reply(damaged);
    story.reply(scan(300));
    story.reply(scan(700));
    let (stamps, others) = sort(story.take_events());
    assert_eq!(stamps, [100, 300, 700]);
    let [
        Event::Rejected {
            reason: Rejection::Reply(ReplyError::Sum { .. }),
            total: 1,
        },
        lost @ ..,
    ] = others.as_slice()
    else {
        panic!("{others:?}");
    };
    assert_eq!(lost, [Event::LostScans(1), Event::LostScans(3)]);
}

#[test]
fn a_truncated_scan_with_right_sums_is_rejected_by_its_count() {
    let mut story = streaming();
    let bytes = scan(100);
    // Cut at a line's end: the first 20 data lines, then the empty line.
    let cut = ECHO.len() + 1 + 4 + 6 + 20 * 66;
    story.reply([&bytes[..cut], b"\n"].concat());
    let events = story.take_events();
    assert!(
        matches!(
            events.as_slice(),
            [Event::Rejected {
                reason: Rejection::Reply(_),
                total: 1
            }]
        ),
        "{events:?}"
    );
}

#[test]
fn the_same_stamp_again_and_again_is_a_fault() {
    let mut story = streaming();
    for _ in 0..3 {
        story.reply(scan(100));
    }
    story.expect_sent(&[]);
    story.reply(scan(100));
    story.expect_sent(&["QT\n"]);
    let (stamps, others) = sort(std::mem::take(&mut story.events));
    assert_eq!(stamps, [100]);
    assert_eq!(
        others.last(),
        Some(&Event::Fault(SensorError::StaleStamp {
            stamp_ms: 100,
            repeats: 3
        }))
    );
}

#[test]
fn one_odd_stamp_is_rejected_three_are_a_fault() {
    let mut story = streaming();
    story.reply(scan(100));
    story.reply(scan(250));
    story.reply(scan(350));
    let (stamps, others) = sort(story.take_events());
    assert_eq!(stamps, [100, 350]);
    let reason = Rejection::StampJump {
        advance_ms: 150,
        expected_ms: 100,
    };
    assert_eq!(others, [Event::Rejected { reason, total: 1 }]);
    for stamp in [9_000_000, 20, 4_000_000] {
        story.reply(scan(stamp));
    }
    story.expect_sent(&["QT\n"]);
    assert!(matches!(
        story.events.last(),
        Some(Event::Fault(SensorError::ErraticStamps { jumps: 3, .. }))
    ));
}

#[test]
fn silence_is_answered_by_qt_then_rs_then_a_fault() {
    let mut story = streaming();
    story.reply(scan(100));
    let before = story.now;
    story.silence();
    assert!(
        story.now - before <= Instant::from_millis(300),
        "three periods"
    );
    // The tail of the old stream may come before the echo.
    story.turn("QT\n", [scan(200), b"QT\n00P\n\n".to_vec()].concat());
    story.turn(REQUEST, ACK);
    story.silence();
    story.turn("RS\n", "RS\n00P\n\n");
    story.turn(REQUEST, ACK);
    story.silence();
    story.expect_sent(&["QT\n"]);
    let (_, others) = sort(std::mem::take(&mut story.events));
    let cause = RecoveryCause::Silence;
    assert_eq!(
        others,
        [
            Event::Recovering {
                cause,
                step: RecoveryStep::Quit
            },
            Event::Recovered { timer_reset: false },
            Event::Recovering {
                cause,
                step: RecoveryStep::Reset
            },
            Event::Recovered { timer_reset: true },
            Event::Fault(SensorError::StreamLost { cause }),
        ]
    );
}

#[test]
fn a_run_of_good_scans_makes_the_next_silence_the_first_again() {
    let mut story = streaming();
    let mut stamp = 0;
    for _ in 0..5 {
        for _ in 0..10 {
            stamp += 100;
            story.reply(scan(stamp));
        }
        story.silence();
        story.turn("QT\n", "QT\n00P\n\n");
        story.turn(REQUEST, ACK);
        stamp += 370;
    }
    let (stamps, others) = sort(story.take_events());
    assert_eq!(stamps.len(), 50);
    assert!(
        !others
            .iter()
            .any(|event| matches!(event, Event::Fault(_) | Event::Rejected { .. })),
        "{others:?}"
    );
    assert_eq!(
        others
            .iter()
            .filter(|event| matches!(event, Event::LostScans(_)))
            .count(),
        4
    );
}

#[test]
fn garbage_without_end_is_silence() {
    let mut story = streaming();
    let by = story.sensor.deadline().expect("the first data");
    while story.now < by {
        story.now += Instant::from_millis(10);
        story.sensor.handle_bytes(&[0xFF; 2000], story.now);
        story.sensor.handle_deadline(story.now);
    }
    story.expect_sent(&["QT\n"]);
    let overrun = Event::Rejected {
        reason: Rejection::Overrun,
        total: 1,
    };
    let recovering = Event::Recovering {
        cause: RecoveryCause::Silence,
        step: RecoveryStep::Quit,
    };
    assert_eq!(story.events, [overrun, recovering]);
}

#[test]
fn damage_without_end_restarts_the_stream() {
    let mut story = streaming();
    for k in 0..10 {
        let mut damaged = scan(100 * k);
        damaged[500] ^= 2;
        story.reply(damaged);
    }
    story.expect_sent(&["QT\n"]);
    let recovering = Event::Recovering {
        cause: RecoveryCause::Damage,
        step: RecoveryStep::Quit,
    };
    assert_eq!(story.events.last(), Some(&recovering));
}

#[test]
fn a_lost_acknowledgement_is_made_good_by_the_first_scan() {
    let mut story = connected();
    story.sensor.start_streaming(PLAN, story.now).expect("idle");
    story.turn(REQUEST, scan(100));
    let (stamps, others) = sort(story.take_events());
    assert_eq!((stamps, others), (vec![100], vec![Event::Streaming]));
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
fn a_relapse_into_scip_1_1_is_told_as_such() {
    let mut story = streaming();
    story.reply(scan(100));
    story.silence();
    story.turn("QT\n", "QT\nE\n\n");
    assert_eq!(
        story.take_events().last(),
        Some(&Event::Fault(SensorError::Relapsed))
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

#[test]
fn a_timer_reset_before_the_first_scan_is_told_too() {
    let mut story = connected();
    story.sensor.start_streaming(PLAN, story.now).expect("idle");
    story.expect_sent(&[REQUEST]);
    story.silence();
    story.turn("QT\n", "QT\n00P\n\n");
    story.expect_sent(&[REQUEST]);
    story.silence();
    story.turn("RS\n", "RS\n00P\n\n");
    story.turn(REQUEST, ACK);
    let events = story.take_events();
    assert_eq!(
        events[2..],
        [Event::Streaming, Event::Recovered { timer_reset: true }]
    );
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
