//! Troubles of a stream, its checks and its recovery, byte by byte.

mod common;

use common::streaming::{ACK, ECHO, PLAN, REQUEST, connected, scan, sort, streaming};
use scip::{LaserEvent, RecoveryCause, RecoveryStep, Rejection, ReplyError, ScipError};
use std::time::Duration;

#[test]
fn the_same_stamp_again_and_again_is_a_fault() {
    let mut script = streaming();
    for _ in 0..3 {
        script.reply(scan(100));
    }
    script.expect_sent(&[]);
    script.reply(scan(100));
    script.expect_sent(&["QT\n"]);
    let (stamps, others) = sort(std::mem::take(&mut script.events));
    assert_eq!(stamps, [100]);
    assert_eq!(
        others.last(),
        Some(&LaserEvent::ConnectionFailed(ScipError::StaleStamp {
            stamp_ms: 100,
            repeats: 3
        }))
    );
}

#[test]
fn one_odd_stamp_is_rejected_three_are_a_fault() {
    let mut script = streaming();
    script.reply(scan(100));
    script.reply(scan(250));
    script.reply(scan(350));
    let (stamps, others) = sort(script.take_events());
    assert_eq!(stamps, [100, 350]);
    let reason = Rejection::StampJump {
        advance_ms: 150,
        expected_ms: 100,
    };
    assert_eq!(others, [LaserEvent::Rejected { reason, total: 1 }]);
    for stamp in [9_000_000, 20, 4_000_000] {
        script.reply(scan(stamp));
    }
    script.expect_sent(&["QT\n"]);
    assert!(matches!(
        script.events.last(),
        Some(LaserEvent::ConnectionFailed(ScipError::ErraticStamps {
            jumps: 3,
            ..
        }))
    ));
}

#[test]
fn garbage_without_end_is_silence() {
    let mut script = streaming();
    let by = script.driver.deadline().expect("the first data");
    while script.now < by {
        script.now += Duration::from_millis(10);
        script.driver.handle_bytes(&[0xFF; 2000], script.now);
        script.driver.handle_deadline(script.now);
    }
    script.expect_sent(&["QT\n"]);
    let overrun = LaserEvent::Rejected {
        reason: Rejection::Overrun,
        total: 1,
    };
    let recovering = LaserEvent::Recovering {
        cause: RecoveryCause::Silence,
        step: RecoveryStep::Quit,
    };
    assert_eq!(script.events, [overrun, recovering]);
}

#[test]
fn damage_without_end_restarts_the_stream() {
    let mut script = streaming();
    for k in 0..10 {
        let mut damaged = scan(100 * k);
        damaged[500] ^= 2;
        script.reply(damaged);
    }
    script.expect_sent(&["QT\n"]);
    let recovering = LaserEvent::Recovering {
        cause: RecoveryCause::Damage,
        step: RecoveryStep::Quit,
    };
    assert_eq!(script.events.last(), Some(&recovering));
}

#[test]
fn the_first_scan_replaces_a_lost_acknowledgement() {
    let mut script = connected();
    script
        .driver
        .start_streaming(PLAN, script.now)
        .expect("idle");
    script.exchange(REQUEST, scan(100));
    let (stamps, others) = sort(script.take_events());
    assert_eq!((stamps, others), (vec![100], vec![LaserEvent::Streaming]));
}

#[test]
fn a_relapse_into_scip_1_1_is_reported() {
    let mut script = streaming();
    script.reply(scan(100));
    script.time_out();
    script.exchange("QT\n", "QT\nE\n\n");
    assert_eq!(
        script.take_events().last(),
        Some(&LaserEvent::ConnectionFailed(ScipError::FellBackToScip11))
    );
    // In answer to the request itself: a restart would not help either.
    let mut script = connected();
    script
        .driver
        .start_streaming(PLAN, script.now)
        .expect("idle");
    script.exchange(REQUEST, format!("{ECHO}\nE\n\n"));
    assert_eq!(
        script.take_events().last(),
        Some(&LaserEvent::ConnectionFailed(ScipError::FellBackToScip11))
    );
}

#[test]
fn gaps_are_counted_and_a_damaged_scan_costs_itself_only() {
    let mut script = streaming();
    let mut damaged = scan(200);
    damaged[1000] ^= 1;
    script.reply(scan(100));
    script.reply(damaged);
    script.reply(scan(300));
    script.reply(scan(700));
    let (stamps, others) = sort(script.take_events());
    assert_eq!(stamps, [100, 300, 700]);
    let [
        LaserEvent::Rejected {
            reason: Rejection::Reply(ReplyError::Sum { .. }),
            total: 1,
        },
        lost @ ..,
    ] = others.as_slice()
    else {
        panic!("{others:?}");
    };
    assert_eq!(lost, [LaserEvent::LostScans(1), LaserEvent::LostScans(3)]);
}

#[test]
fn a_truncated_scan_with_right_sums_is_rejected_by_its_count() {
    let mut script = streaming();
    let bytes = scan(100);
    // Cut at a line's end: the first 20 data lines, then the empty line.
    let cut = ECHO.len() + 1 + 4 + 6 + 20 * 66;
    script.reply([&bytes[..cut], b"\n"].concat());
    let events = script.take_events();
    assert!(
        matches!(
            events.as_slice(),
            [LaserEvent::Rejected {
                reason: Rejection::Reply(_),
                total: 1
            }]
        ),
        "{events:?}"
    );
}

/// A long stream with single faults, more of them than a row may have, each followed by good scans.
fn long_stream_with_single_faults(fault: impl Fn(u32) -> Vec<u8>, period_after: u32) -> usize {
    let mut script = streaming();
    let mut stamp = 0;
    for _ in 0..30 {
        stamp += 100;
        script.reply(scan(stamp));
        script.reply(fault(stamp));
        stamp += period_after;
    }
    let (stamps, others) = sort(script.take_events());
    let ended = |event: &LaserEvent| {
        matches!(
            event,
            LaserEvent::ConnectionFailed(_) | LaserEvent::Recovering { .. }
        )
    };
    assert!(!others.iter().any(ended), "{others:?}");
    stamps.len()
}

#[test]
fn single_faults_never_add_up_to_a_row() {
    // The stamp of the scan before.
    assert_eq!(long_stream_with_single_faults(scan, 0), 30);
    // A jump that the next scan follows by a period.
    let jump = |stamp| scan(stamp + 130);
    assert_eq!(long_stream_with_single_faults(jump, 130), 30);
    let damaged = |stamp| {
        let mut bytes = scan(stamp + 100);
        bytes[700] ^= 1;
        bytes
    };
    assert_eq!(long_stream_with_single_faults(damaged, 100), 30);
}

#[test]
fn a_request_that_is_refused_is_no_stream() {
    // 10: the laser cannot be turned on in this state; 0B: busy; 0L: abnormal state.
    for status in ["10Q", "0Bb", "0Ll"] {
        let mut script = connected();
        script
            .driver
            .start_streaming(PLAN, script.now)
            .expect("idle");
        let refused = format!("{ECHO}\n{status}\n\n");
        script.exchange(REQUEST, &refused);
        script.exchange("QT\n", "QT\n00P\n\n");
        script.exchange(REQUEST, &refused);
        script.exchange("RS\n", "RS\n00P\n\n");
        script.exchange(REQUEST, &refused);
        script.expect_sent(&["QT\n"]);
        let (stamps, others) = sort(std::mem::take(&mut script.events));
        assert_eq!(stamps, [0; 0]);
        assert!(!others.contains(&LaserEvent::Streaming), "{others:?}");
        let cause = RecoveryCause::NotAcknowledged;
        let lost = LaserEvent::ConnectionFailed(ScipError::StreamLost { cause });
        assert_eq!(others.last(), Some(&lost));
    }
    // A plan that the sensor refuses is no reason to restart anything.
    let mut script = connected();
    script
        .driver
        .start_streaming(PLAN, script.now)
        .expect("idle");
    script.exchange(REQUEST, format!("{ECHO}\n04T\n\n"));
    let events = script.take_events();
    assert!(
        matches!(
            events.last(),
            Some(LaserEvent::RequestFailed(ScipError::BadReply { .. }))
        ),
        "{events:?}"
    );
}

#[test]
fn only_its_own_answer_begins_a_stream() {
    let mut script = connected();
    script
        .driver
        .start_streaming(PLAN, script.now)
        .expect("idle");
    // A late answer to what was asked before.
    script.exchange(REQUEST, "QT\n00P\n\n");
    assert_eq!(script.take_events(), []);
    script.reply(ACK);
    assert_eq!(script.take_events(), [LaserEvent::Streaming]);
}

#[test]
fn half_a_message_does_not_survive_a_reopened_port() {
    let mut script = streaming();
    let bytes = scan(100);
    script.reply(&bytes[..1000]);
    // The port was opened again; the first reply comes whole.
    script.driver.connect(script.now);
    script.exchange("QT\n", "QT\n00P\n\n");
    script.identify();
}
