//! What is asked of an idle laser: the time exchange. Byte by byte.

mod common;

use common::ScriptedLaser;
use scip::{LaserEvent, ScipDriver, ScipError, ScipOptions};
use std::time::Duration;

#[test]
fn a_time_exchange_pairs_instants_with_the_timer() {
    let mut script = ScriptedLaser::connected(ScipDriver::new(ScipOptions::default()));
    script.driver.exchange_time(2, script.now).expect("idle");
    script.exchange("TM0\n", "TM0\n00P\n\n");
    let sent = script.now;
    script.exchange("TM1\n", "TM1\n00P\n<SfkP\n\n");
    script.exchange("TM1\n", "TM1\n00P\nJUGnD\n\n");
    script.exchange("TM2\n", "TM2\n00P\n\n");
    let events = script.take_events();
    let [first, second, LaserEvent::TimeExchanged { samples: 2 }] = events.as_slice() else {
        panic!("{events:?}")
    };
    let received = sent + Duration::from_millis(95);
    let stamp_ms = scip::encoding::decode(b"<Sfk").expect("valid");
    assert_eq!(
        *first,
        LaserEvent::TimeSample {
            sent,
            received,
            stamp_ms
        }
    );
    assert!(matches!(
        second,
        LaserEvent::TimeSample {
            stamp_ms: 6_968_830,
            ..
        }
    ));
}

#[test]
fn a_lost_time_ends_the_exchange_so_that_no_late_one_is_taken_for_another() {
    let mut script = ScriptedLaser::connected(ScipDriver::new(ScipOptions::default()));
    script.driver.exchange_time(5, script.now).expect("idle");
    script.exchange("TM0\n", "TM0\n00P\n\n");
    script.exchange("TM1\n", "TM1\n00P\n<SfkP\n\n");
    script.expect_sent(&["TM1\n"]);
    script.time_out();
    // The late answer comes before TM2's and is nobody's.
    script.exchange("TM2\n", "TM1\n00P\n<SfkP\n\nTM2\n00P\n\n");
    let events = script.take_events();
    assert!(
        matches!(
            events.as_slice(),
            [
                LaserEvent::TimeSample { .. },
                LaserEvent::TimeExchanged { samples: 1 }
            ]
        ),
        "{events:?}"
    );
}

#[test]
fn stopping_in_time_adjust_leaves_it() {
    let mut script = ScriptedLaser::connected(ScipDriver::new(ScipOptions::default()));
    script.driver.exchange_time(5, script.now).expect("idle");
    script.exchange("TM0\n", "TM0\n00P\n\n");
    script.driver.stop(script.now);
    script.expect_sent(&["TM1\n", "QT\n"]);
    script.reply("TM1\n00P\n<SfkP\n\nQT\n0Ee\n\n");
    script.exchange("TM2\n", "TM2\n00P\n\n");
    script.exchange("QT\n", "QT\n00P\n\n");
    assert_eq!(script.take_events(), [LaserEvent::Stopped]);
}

#[test]
fn a_refused_time_adjust_fails_and_leaves_the_sensor_idle() {
    let mut script = ScriptedLaser::connected(ScipDriver::new(ScipOptions::default()));
    script.driver.exchange_time(3, script.now).expect("idle");
    script.expect_sent(&["TM0\n"]);
    for _ in 0..2 {
        script.reply("TM0\n0Ee\n\n");
        script.time_out();
        script.expect_sent(&["TM0\n"]);
    }
    script.time_out();
    script.exchange("TM2\n", "TM2\n0Ee\n\n");
    script.time_out();
    script.exchange("TM2\n", "TM2\n03S\n\n");
    let events = script.take_events();
    assert!(
        matches!(
            events.last(),
            Some(LaserEvent::RequestFailed(ScipError::BadReply { .. }))
        ),
        "{events:?}"
    );
    assert!(script.driver.exchange_time(1, script.now).is_ok());
}

#[test]
fn unasked_for_messages_are_counted() {
    let mut script = ScriptedLaser::connected(ScipDriver::new(ScipOptions::default()));
    script.reply("QT\n00P\n\n");
    assert!(matches!(
        script.take_events().as_slice(),
        [LaserEvent::Rejected { total: 1, .. }]
    ));
}
