//! How a silent stream is restarted, and what a restart forgets and keeps.

mod common;

use common::ScriptedLaser;
use common::streaming::{ACK, PLAN, REQUEST, connected, scan, sort, streaming};
use scip::{LaserEvent, RecoveryCause, RecoveryStep, Rejection, ScipError};
use std::time::Duration;

/// The device falls silent, and goes on after `QT`.
fn restart_by_quit(script: &mut ScriptedLaser) {
    script.time_out();
    script.exchange("QT\n", "QT\n00P\n\n");
    script.exchange(REQUEST, ACK);
}

/// The device falls silent, and goes on after `RS`, which sets its timer to zero.
fn restart_by_reset(script: &mut ScriptedLaser) {
    script.time_out();
    script.exchange("RS\n", "RS\n00P\n\n");
    script.exchange(REQUEST, ACK);
}

/// Good scans at these stamps.
fn scans(script: &mut ScriptedLaser, stamps_ms: impl IntoIterator<Item = u32>) {
    for stamp_ms in stamps_ms {
        script.reply(scan(stamp_ms));
    }
}

#[test]
fn silence_is_answered_by_qt_then_rs_then_a_fault() {
    let mut script = streaming();
    script.reply(scan(100));
    let before = script.now;
    script.time_out();
    assert!(
        script.now - before <= Duration::from_millis(300),
        "three periods"
    );
    // The tail of the old stream may come before the echo.
    script.exchange("QT\n", [scan(200), b"QT\n00P\n\n".to_vec()].concat());
    script.exchange(REQUEST, ACK);
    restart_by_reset(&mut script);
    script.time_out();
    script.expect_sent(&["QT\n"]);
    let (_, others) = sort(std::mem::take(&mut script.events));
    let cause = RecoveryCause::Silence;
    assert_eq!(
        others,
        [
            LaserEvent::Recovering {
                cause,
                step: RecoveryStep::Quit
            },
            LaserEvent::Recovered { timer_reset: false },
            LaserEvent::Recovering {
                cause,
                step: RecoveryStep::Reset
            },
            LaserEvent::Recovered { timer_reset: true },
            LaserEvent::ConnectionFailed(ScipError::StreamLost { cause }),
        ]
    );
}

#[test]
fn a_run_of_good_scans_makes_the_next_silence_the_first_again() {
    let mut script = streaming();
    let mut stamp = 0;
    for _ in 0..5 {
        for _ in 0..10 {
            stamp += 100;
            script.reply(scan(stamp));
        }
        restart_by_quit(&mut script);
        stamp += 370;
    }
    let (stamps, others) = sort(script.take_events());
    assert_eq!(stamps.len(), 50);
    assert!(
        !others.iter().any(|event| matches!(
            event,
            LaserEvent::ConnectionFailed(_) | LaserEvent::Rejected { .. }
        )),
        "{others:?}"
    );
    assert_eq!(
        others
            .iter()
            .filter(|event| matches!(event, LaserEvent::LostScans(_)))
            .count(),
        4
    );
}

#[test]
fn a_timer_reset_before_the_first_scan_is_reported_too() {
    let mut script = connected();
    script
        .driver
        .start_streaming(PLAN, script.now)
        .expect("idle");
    script.expect_sent(&[REQUEST]);
    script.time_out();
    script.exchange("QT\n", "QT\n00P\n\n");
    script.expect_sent(&[REQUEST]);
    restart_by_reset(&mut script);
    let events = script.take_events();
    assert_eq!(
        events[2..],
        [
            LaserEvent::Streaming,
            LaserEvent::Recovered { timer_reset: true }
        ]
    );
}

#[test]
fn a_restarted_stream_counts_damage_anew() {
    let mut script = streaming();
    let damaged = || {
        let mut bytes = scan(100);
        bytes[700] ^= 1;
        bytes
    };
    for _ in 0..9 {
        script.reply(damaged());
    }
    restart_by_quit(&mut script);
    // The tenth of all, the first since the restart.
    script.reply(damaged());
    script.expect_sent(&[]);
    script.reply(scan(200));
    let (stamps, _) = sort(script.take_events());
    assert_eq!(stamps, [200]);
}

#[test]
fn after_a_reset_the_timer_starts_anew_without_a_jump() {
    let mut script = streaming();
    script.reply(scan(5_000_000));
    // Two repeats of a row of three.
    script.reply(scan(5_000_000));
    script.reply(scan(5_000_000));
    restart_by_quit(&mut script);
    restart_by_reset(&mut script);
    script.take_events();
    // The third repeat of all, the first of the new timer.
    for stamp in [37, 37, 137, 237] {
        script.reply(scan(stamp));
    }
    let (stamps, others) = sort(script.take_events());
    assert_eq!(stamps, [37, 137, 237]);
    let repeated = Rejection::RepeatedStamp { stamp_ms: 37 };
    let [LaserEvent::Rejected { reason, .. }] = others.as_slice() else {
        panic!("{others:?}")
    };
    assert_eq!(*reason, repeated);
}

#[test]
fn after_a_reset_jumps_are_counted_anew() {
    let mut script = streaming();
    // Two jumps of a row of three.
    scans(&mut script, [5_000_000, 9_000_000, 20]);
    restart_by_quit(&mut script);
    restart_by_reset(&mut script);
    script.take_events();
    // The third of all, the first of the new timer.
    scans(&mut script, [37, 4_000_000, 4_000_100]);
    let (stamps, others) = sort(script.take_events());
    assert_eq!(stamps, [37, 4_000_100]);
    let [LaserEvent::Rejected { reason, .. }] = others.as_slice() else {
        panic!("{others:?}")
    };
    assert!(matches!(reason, Rejection::StampJump { .. }), "{reason:?}");
}

#[test]
fn only_the_first_scan_after_a_restart_may_have_any_stamp() {
    let mut script = streaming();
    scans(&mut script, [100]);
    restart_by_quit(&mut script);
    scans(&mut script, [540]);
    script.take_events();
    scans(&mut script, [670, 770]);
    let (stamps, others) = sort(script.take_events());
    assert_eq!(stamps, [770]);
    let [LaserEvent::Rejected { reason, .. }] = others.as_slice() else {
        panic!("{others:?}")
    };
    let jump = Rejection::StampJump {
        advance_ms: 130,
        expected_ms: 100,
    };
    assert_eq!(*reason, jump);
}

#[test]
fn a_stream_that_keeps_stopping_is_lost_however_long_it_ran_before() {
    let mut script = streaming();
    scans(&mut script, (1..=50).map(|n| 100 * n));
    restart_by_quit(&mut script);
    scans(&mut script, [6000, 6100]);
    restart_by_reset(&mut script);
    scans(&mut script, [100, 200]);
    script.time_out();
    script.expect_sent(&["QT\n"]);
    let cause = RecoveryCause::Silence;
    let lost = LaserEvent::ConnectionFailed(ScipError::StreamLost { cause });
    assert_eq!(script.events.last(), Some(&lost));
}

#[test]
fn a_timer_reset_is_reported_once() {
    let mut script = streaming();
    scans(&mut script, [100]);
    restart_by_quit(&mut script);
    restart_by_reset(&mut script);
    // A run of good scans: the next silence is the first again.
    scans(&mut script, (1..=10).map(|n| 100 * n));
    script.take_events();
    restart_by_quit(&mut script);
    assert_eq!(
        script.take_events().last(),
        Some(&LaserEvent::Recovered { timer_reset: false })
    );
}
