//! Connecting, from every state a device can be left in, byte by byte.

mod common;

use common::{II, PP, Story, VV, scan_message, summed};
use scip::{
    Command, Event, Instant, Meaning, Parameters, Rejection, Sensor, SensorError, SensorOptions,
};

fn begin() -> Story {
    let mut story = Story::new(Sensor::new(SensorOptions::default()));
    story.sensor.connect(story.now);
    story
}

#[test]
fn a_sensor_in_scip_2_is_identified() {
    let mut story = begin();
    story.turn("QT\n", "QT\n00P\n\n");
    story.turn("RS\n", "RS\n00P\n\n");
    story.turn("VV\n", VV);
    story.turn("PP\n", PP);
    story.turn("II\n", II);
    let events = story.take_events();
    let [Event::Connected(identity)] = events.as_slice() else {
        panic!("{events:?}")
    };
    assert_eq!(identity.model, "URG-04LX(Hokuyo Automatic Co.,Ltd.)");
    assert_eq!(identity.vendor, "Hokuyo Automatic Co.,Ltd.");
    assert_eq!(identity.product, "SOKUIKI Sensor URG-04LX");
    assert_eq!(identity.firmware, "3.1.04(02/Aug./2007)");
    assert_eq!(identity.protocol, "SCIP 2.0");
    assert_eq!(identity.serial, "H0706400");
    assert_eq!(identity.parameters, Parameters::URG_04LX);
    assert_eq!(identity.status, "Sensor works well.");
    assert_eq!(story.sensor.deadline(), None, "idle waits for nothing");
}

#[test]
fn a_sensor_in_scip_1_1_is_switched() {
    for answer in ["SCIP2.0\n0\n\n", "SCIP2.0\n0Ee\n\n"] {
        let mut story = begin();
        story.turn("QT\n", "QT\nE\n\n");
        story.turn("SCIP2.0\n", answer);
        story.turn("QT\n", "QT\n00P\n\n");
        story.identify();
    }
}

#[test]
fn a_streaming_sensor_is_stopped_however_long_its_stream_goes_on() {
    let mut story = begin();
    story.expect_sent(&["QT\n"]);
    // Opened in the middle of a scan, the scans go on every 94 ms: no gap to wait for.
    let scan = |stamp| scan_message("MD0044072501000", "99", stamp, &[1234; 682]);
    story.reply(&scan(0)[700..]);
    story.reply(scan(100));
    story.reply(scan(200));
    story.reply("QT\n00P\n\n");
    story.identify();
}

#[test]
fn a_stream_that_never_ends_is_a_fault_in_time() {
    let mut story = begin();
    let mut stamp = 0;
    let fault = loop {
        stamp += 100;
        story.now += Instant::from_millis(94);
        story.sensor.handle_bytes(
            &scan_message("MD0044072501000", "99", stamp, &[1; 682]),
            story.now,
        );
        story.sensor.handle_deadline(story.now);
        let (_, events) = common::drain(&mut story.sensor);
        if let Some(event) = events.into_iter().next() {
            break event;
        }
        assert!(
            story.now < Instant::from_secs(16),
            "the overall deadline is 15 s"
        );
    };
    assert!(
        matches!(fault, Event::Fault(SensorError::NoReply { .. })),
        "{fault:?}"
    );
}

#[test]
fn a_sensor_in_time_adjust_is_led_out() {
    let mut story = begin();
    story.turn("QT\n", "QT\n0Ee\n\n");
    story.turn("TM2\n", "TM2\n00P\n\n");
    story.turn("QT\n", "QT\n00P\n\n");
    story.identify();
}

#[test]
fn a_sensor_that_stays_in_the_wrong_mode_is_a_fault() {
    let mut story = begin();
    for _ in 0..4 {
        story.turn("QT\n", "QT\n0Ee\n\n");
        story.turn("TM2\n", "TM2\n03S\n\n");
    }
    story.turn("QT\n", "QT\n0Ee\n\n");
    assert_eq!(
        story.take_events(),
        [Event::Fault(SensorError::WrongMode {
            last: Meaning::Undefined
        })]
    );
}

#[test]
fn lost_and_damaged_replies_are_asked_for_again() {
    let mut story = begin();
    story.expect_sent(&["QT\n"]);
    story.silence();
    assert_eq!(
        story.now,
        Instant::from_secs(1),
        "far above the device's 100 ms tick"
    );
    story.turn("QT\n", "QT\n00P\n\n");
    story.turn("RS\n", "RS\n00P\n\n");
    // A bad sum in the status is asked for again at once; the late second answer to VV disturbs nobody.
    story.turn("VV\n", "VV\n00Q\n\n");
    story.turn("VV\n", VV);
    story.reply(VV);
    story.turn("PP\n", PP.replace("DMAX:5600", "DMAX:5601"));
    story.turn("PP\n", PP);
    story.expect_sent(&["II\n"]);
    story.silence();
    story.turn("II\n", II);
    assert!(matches!(
        story.take_events().as_slice(),
        [Event::Connected(_)]
    ));
}

#[test]
fn silence_everywhere_is_a_fault_after_scip_2_was_tried_too() {
    let mut story = begin();
    for request in ["QT\n"; 3].into_iter().chain(["SCIP2.0\n"; 3]) {
        story.expect_sent(&[request]);
        story.silence();
    }
    let (command, timeout) = (Command::SwitchProtocol, Instant::from_secs(1));
    let fault = SensorError::NoReply {
        command,
        attempts: 3,
        timeout,
    };
    assert_eq!(story.take_events(), [Event::Fault(fault)]);
    assert_eq!(story.sensor.deadline(), None);
    // And connecting once more begins from the start.
    story.sensor.connect(story.now);
    story.expect_sent(&["QT\n"]);
}

#[test]
fn the_whole_has_a_deadline() {
    let options = SensorOptions {
        connect_timeout: Instant::from_millis(1500),
        ..Default::default()
    };
    let mut story = Story::new(Sensor::new(options));
    story.sensor.connect(story.now);
    story.expect_sent(&["QT\n"]);
    story.silence();
    story.expect_sent(&["QT\n"]);
    story.silence();
    assert_eq!(story.now, Instant::from_millis(1500));
    let limit = Instant::from_millis(1500);
    let fault = SensorError::ConnectTimeout {
        limit,
        command: Command::Quit,
    };
    assert_eq!(story.take_events(), [Event::Fault(fault)]);
}

#[test]
fn a_unit_that_always_sends_one_wrong_sum_in_vv_is_taken_with_a_note() {
    let odd = VV.replace("H0706400;F", "H0706400;E");
    let mut story = begin();
    story.turn("QT\n", "QT\n00P\n\n");
    story.turn("RS\n", "RS\n00P\n\n");
    for _ in 0..3 {
        story.turn("VV\n", &odd);
    }
    // A bad VV is a reason to try the switch, once.
    story.turn("SCIP2.0\n", "SCIP2.0\n0Ee\n\n");
    story.turn("QT\n", "QT\n00P\n\n");
    story.turn("RS\n", "RS\n00P\n\n");
    for _ in 0..3 {
        story.turn("VV\n", &odd);
    }
    story.turn("PP\n", PP);
    story.turn("II\n", II);
    let events = story.take_events();
    let [
        Event::Rejected {
            reason: Rejection::ToleratedSums { lines: 1 },
            ..
        },
        Event::Connected(identity),
    ] = events.as_slice()
    else {
        panic!("{events:?}");
    };
    assert_eq!(identity.serial, "H0706400");
}

#[test]
fn a_sensor_in_trouble_is_a_fault_with_its_own_words() {
    let trouble = format!("II\n00P\n{}\n", summed("STAT:Trouble!! Error No. =[05]"));
    let mut story = begin();
    story.turn("QT\n", "QT\n00P\n\n");
    story.turn("RS\n", "RS\n00P\n\n");
    story.turn("VV\n", VV);
    story.turn("PP\n", PP);
    story.turn("II\n", trouble);
    let status = "Trouble!! Error No. =[05]".to_owned();
    assert_eq!(
        story.take_events(),
        [Event::Fault(SensorError::Trouble { status })]
    );
}

#[test]
fn a_relapse_while_connecting_is_switched_again() {
    let mut story = begin();
    story.turn("QT\n", "QT\n00P\n\n");
    story.turn("RS\n", "RS\n00P\n\n");
    story.turn("VV\n", "VV\nE\n\n");
    story.turn("SCIP2.0\n", "SCIP2.0\n0\n\n");
    story.turn("QT\n", "QT\n00P\n\n");
    story.identify();
}

#[test]
fn requests_before_connecting_are_refused() {
    let mut sensor = Sensor::new(SensorOptions::default());
    let refused = |state| SensorError::NotReady {
        request: "a query",
        state,
    };
    assert_eq!(
        sensor.query_info(Instant::ZERO),
        Err(refused("not connected"))
    );
    sensor.connect(Instant::ZERO);
    assert_eq!(sensor.query_info(Instant::ZERO), Err(refused("connecting")));
}
