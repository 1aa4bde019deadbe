//! Troubles of a stream, its checks and its recovery, byte by byte.

mod common;

use common::streaming::{ACK, ECHO, PLAN, REQUEST, connected, scan, sort, streaming};
use scip::{Event, Instant, RecoveryCause, RecoveryStep, Rejection, ReplyError, SensorError};

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
