//! What is asked of an idle sensor: time exchange, `II`, single scans. Byte by byte.

mod common;

use common::{II, Story, scan_message};
use scip::command::span::Span;
use scip::{Coding, Event, Instant, Sensor, SensorError, SensorOptions};

#[test]
fn a_time_exchange_pairs_instants_with_the_timer() {
    let mut story = Story::connected(Sensor::new(SensorOptions::default()));
    story.sensor.exchange_time(2, story.now).expect("idle");
    story.turn("TM0\n", "TM0\n00P\n\n");
    let sent = story.now;
    story.turn("TM1\n", "TM1\n00P\n<SfkP\n\n");
    story.turn("TM1\n", "TM1\n00P\nJUGnD\n\n");
    story.turn("TM2\n", "TM2\n00P\n\n");
    let events = story.take_events();
    let [first, second, Event::TimeExchanged { samples: 2 }] = events.as_slice() else {
        panic!("{events:?}")
    };
    let received = sent + Instant::from_millis(95);
    let stamp_ms = scip::encoding::decode(b"<Sfk").expect("valid");
    assert_eq!(
        *first,
        Event::TimeSample {
            sent,
            received,
            stamp_ms
        }
    );
    assert!(matches!(
        second,
        Event::TimeSample {
            stamp_ms: 6_968_830,
            ..
        }
    ));
}

#[test]
fn a_lost_time_ends_the_exchange_so_that_no_late_one_is_taken_for_another() {
    let mut story = Story::connected(Sensor::new(SensorOptions::default()));
    story.sensor.exchange_time(5, story.now).expect("idle");
    story.turn("TM0\n", "TM0\n00P\n\n");
    story.turn("TM1\n", "TM1\n00P\n<SfkP\n\n");
    story.expect_sent(&["TM1\n"]);
    story.silence();
    // The late answer comes before TM2's and is nobody's.
    story.turn("TM2\n", "TM1\n00P\n<SfkP\n\nTM2\n00P\n\n");
    let events = story.take_events();
    assert!(
        matches!(
            events.as_slice(),
            [
                Event::TimeSample { .. },
                Event::TimeExchanged { samples: 1 }
            ]
        ),
        "{events:?}"
    );
}

#[test]
fn stopping_in_time_adjust_leaves_it() {
    let mut story = Story::connected(Sensor::new(SensorOptions::default()));
    story.sensor.exchange_time(5, story.now).expect("idle");
    story.turn("TM0\n", "TM0\n00P\n\n");
    story.sensor.stop(story.now);
    story.expect_sent(&["TM1\n", "QT\n"]);
    story.reply("TM1\n00P\n<SfkP\n\nQT\n0Ee\n\n");
    story.turn("TM2\n", "TM2\n00P\n\n");
    story.turn("QT\n", "QT\n00P\n\n");
    assert_eq!(story.take_events(), [Event::Stopped]);
}

#[test]
fn info_and_single_scans() {
    let mut story = Story::connected(Sensor::new(SensorOptions::default()));
    story.sensor.query_info(story.now).expect("idle");
    story.turn("II\n", II);
    assert!(
        matches!(story.take_events().as_slice(), [Event::Info(info)] if info.time_ms == Some(0x1957))
    );

    let span = Span {
        first_step: 44,
        last_step: 725,
        cluster: 1,
        coding: Coding::ThreeCharacter,
    };
    story.sensor.single(span, story.now).expect("idle");
    story.turn("BM\n", "BM\n02R\n\n");
    story.turn(
        "GD0044072501\n",
        scan_message("GD0044072501", "00", 77, &[500; 682]),
    );
    let events = story.take_events();
    assert!(
        matches!(events.as_slice(), [Event::Scan { scan, .. }] if scan.stamp_ms == 77),
        "{events:?}"
    );
}

#[test]
fn a_refused_time_adjust_fails_and_leaves_the_sensor_idle() {
    let mut story = Story::connected(Sensor::new(SensorOptions::default()));
    story.sensor.exchange_time(3, story.now).expect("idle");
    story.expect_sent(&["TM0\n"]);
    for _ in 0..2 {
        story.reply("TM0\n0Ee\n\n");
        story.silence();
        story.expect_sent(&["TM0\n"]);
    }
    story.silence();
    story.turn("TM2\n", "TM2\n0Ee\n\n");
    story.silence();
    story.turn("TM2\n", "TM2\n03S\n\n");
    let events = story.take_events();
    assert!(
        matches!(
            events.last(),
            Some(Event::Failed(SensorError::BadReply { .. }))
        ),
        "{events:?}"
    );
    assert!(story.sensor.query_info(story.now).is_ok());
}

#[test]
fn unasked_for_messages_are_counted() {
    let mut story = Story::connected(Sensor::new(SensorOptions::default()));
    story.reply("QT\n00P\n\n");
    assert!(matches!(
        story.take_events().as_slice(),
        [Event::Rejected { total: 1, .. }]
    ));
}
