//! Connecting, from every state a device can be left in, byte by byte.

mod common;

use common::{II, PP, ScriptedLaser, VV, drain, scan_message, summed};
use scip::{
    LaserEvent, LaserLine, LaserParameters, ScipCommand, ScipDriver, ScipError, ScipOptions,
    StatusMeaning,
};
use std::time::Duration;

fn connecting() -> ScriptedLaser {
    let mut script = ScriptedLaser::new(ScipDriver::new(ScipOptions::default()));
    script.driver.connect(script.now);
    script
}

#[test]
fn a_sensor_in_scip_2_is_identified() {
    let mut script = connecting();
    script.exchange("QT\n", "QT\n00P\n\n");
    script.exchange("RS\n", "RS\n00P\n\n");
    script.exchange("VV\n", VV);
    script.exchange("PP\n", PP);
    script.exchange("II\n", II);
    let events = script.take_events();
    let [LaserEvent::Connected(identity)] = events.as_slice() else {
        panic!("{events:?}")
    };
    assert_eq!(identity.model, "URG-04LX(Hokuyo Automatic Co.,Ltd.)");
    assert_eq!(identity.vendor, "Hokuyo Automatic Co.,Ltd.");
    assert_eq!(identity.product, "SOKUIKI Sensor URG-04LX");
    assert_eq!(identity.firmware, "3.1.04(02/Aug./2007)");
    assert_eq!(identity.protocol, "SCIP 2.0");
    assert_eq!(identity.serial, "H0706400");
    assert_eq!(identity.parameters, LaserParameters::URG_04LX);
    assert_eq!(identity.status, "Sensor works well.");
    assert_eq!(script.driver.deadline(), None, "idle waits for nothing");
}

#[test]
fn a_sensor_in_scip_1_1_is_switched() {
    for answer in ["SCIP2.0\n0\n\n", "SCIP2.0\n0Ee\n\n"] {
        let mut script = connecting();
        script.exchange("QT\n", "QT\nE\n\n");
        script.exchange("SCIP2.0\n", answer);
        script.exchange("QT\n", "QT\n00P\n\n");
        script.identify();
    }
}

#[test]
fn a_streaming_sensor_is_stopped_however_long_its_stream_goes_on() {
    let mut script = connecting();
    script.expect_sent(&["QT\n"]);
    // Opened in the middle of a scan, the scans go on every 94 ms: no gap to wait for.
    let scan = |stamp| scan_message("MD0044072501000", "99", stamp, &[1234; 682]);
    script.reply(&scan(0)[700..]);
    script.reply(scan(100));
    script.reply(scan(200));
    script.reply("QT\n00P\n\n");
    script.identify();
}

#[test]
fn a_stream_that_never_ends_is_a_fault_in_time() {
    let mut script = connecting();
    let mut stamp = 0;
    let fault = loop {
        stamp += 100;
        script.now += Duration::from_millis(94);
        script.driver.handle_bytes(
            &scan_message("MD0044072501000", "99", stamp, &[1; 682]),
            script.now,
        );
        script.driver.handle_deadline(script.now);
        let (_, events) = common::drain(&mut script.driver);
        if let Some(event) = events.into_iter().next() {
            break event;
        }
        assert!(
            script.now < Duration::from_secs(16),
            "the overall deadline is 15 s"
        );
    };
    let LaserEvent::ConnectionFailed(ScipError::NotALaser { line, .. }) = fault else {
        panic!("{fault:?}")
    };
    assert_eq!(line, LaserLine::DeafLaser);
}

#[test]
fn a_sensor_in_time_adjust_leaves_it() {
    let mut script = connecting();
    script.exchange("QT\n", "QT\n0Ee\n\n");
    script.exchange("TM2\n", "TM2\n00P\n\n");
    script.exchange("QT\n", "QT\n00P\n\n");
    script.identify();
}

#[test]
fn a_sensor_that_stays_in_the_wrong_mode_is_a_fault() {
    let mut script = connecting();
    for _ in 0..4 {
        script.exchange("QT\n", "QT\n0Ee\n\n");
        script.exchange("TM2\n", "TM2\n03S\n\n");
    }
    script.exchange("QT\n", "QT\n0Ee\n\n");
    assert_eq!(
        script.take_events(),
        [LaserEvent::ConnectionFailed(ScipError::WrongMode {
            last: StatusMeaning::Undefined
        })]
    );
}

#[test]
fn lost_and_damaged_replies_are_asked_for_again() {
    let mut script = connecting();
    script.expect_sent(&["QT\n"]);
    script.time_out();
    assert_eq!(
        script.now,
        Duration::from_secs(1),
        "far above the device's 100 ms tick"
    );
    script.exchange("QT\n", "QT\n00P\n\n");
    script.exchange("RS\n", "RS\n00P\n\n");
    // A bad sum in the status is asked for again at once; the late second answer to VV disturbs nobody.
    script.exchange("VV\n", "VV\n00Q\n\n");
    script.exchange("VV\n", VV);
    script.reply(VV);
    script.exchange("PP\n", PP.replace("DMAX:5600", "DMAX:5601"));
    script.exchange("PP\n", PP);
    script.expect_sent(&["II\n"]);
    script.time_out();
    script.exchange("II\n", II);
    assert!(matches!(
        script.take_events().as_slice(),
        [LaserEvent::Connected(_)]
    ));
}

#[test]
fn silence_everywhere_is_a_fault_after_scip_2_was_tried_too() {
    let mut script = connecting();
    for request in ["QT\n"; 3].into_iter().chain(["SCIP2.0\n"; 3]) {
        script.expect_sent(&[request]);
        script.time_out();
    }
    let (command, timeout) = (ScipCommand::SwitchProtocol, Duration::from_secs(1));
    let fault = ScipError::NoReply {
        command,
        attempts: 3,
        timeout,
    };
    assert_eq!(script.take_events(), [LaserEvent::ConnectionFailed(fault)]);
    assert_eq!(script.driver.deadline(), None);
    // And connecting once more begins from the start.
    script.driver.connect(script.now);
    script.expect_sent(&["QT\n"]);
}

#[test]
fn the_whole_has_a_deadline() {
    let options = ScipOptions {
        connect_timeout: Duration::from_millis(1500),
        ..Default::default()
    };
    let mut script = ScriptedLaser::new(ScipDriver::new(options));
    script.driver.connect(script.now);
    script.expect_sent(&["QT\n"]);
    script.time_out();
    script.expect_sent(&["QT\n"]);
    script.time_out();
    assert_eq!(script.now, Duration::from_millis(1500));
    let limit = Duration::from_millis(1500);
    let fault = ScipError::ConnectTimeout {
        limit,
        command: ScipCommand::Quit,
    };
    assert_eq!(script.take_events(), [LaserEvent::ConnectionFailed(fault)]);
}

#[test]
fn a_unit_that_always_sends_one_wrong_sum_in_vv_is_accepted_with_a_note() {
    let odd = VV.replace("H0706400;F", "H0706400;E");
    let mut script = connecting();
    script.exchange("QT\n", "QT\n00P\n\n");
    script.exchange("RS\n", "RS\n00P\n\n");
    for _ in 0..3 {
        script.exchange("VV\n", &odd);
    }
    // A bad VV is a reason to try the switch, once.
    script.exchange("SCIP2.0\n", "SCIP2.0\n0Ee\n\n");
    script.exchange("QT\n", "QT\n00P\n\n");
    script.exchange("RS\n", "RS\n00P\n\n");
    for _ in 0..3 {
        script.exchange("VV\n", &odd);
    }
    script.exchange("PP\n", PP);
    script.exchange("II\n", II);
    let events = script.take_events();
    let [
        LaserEvent::WrongSumsTolerated { lines: 1 },
        LaserEvent::Connected(identity),
    ] = events.as_slice()
    else {
        panic!("{events:?}");
    };
    assert_eq!(identity.serial, "H0706400");
}

#[test]
fn a_sensor_in_trouble_is_a_fault_with_its_stat() {
    let trouble = format!("II\n00P\n{}\n", summed("STAT:Trouble!! Error No. =[05]"));
    let mut script = connecting();
    script.exchange("QT\n", "QT\n00P\n\n");
    script.exchange("RS\n", "RS\n00P\n\n");
    script.exchange("VV\n", VV);
    script.exchange("PP\n", PP);
    script.exchange("II\n", trouble);
    let status = "Trouble!! Error No. =[05]".to_owned();
    assert_eq!(
        script.take_events(),
        [LaserEvent::ConnectionFailed(ScipError::Trouble { status })]
    );
}

#[test]
fn a_relapse_while_connecting_is_switched_again() {
    let mut script = connecting();
    script.exchange("QT\n", "QT\n00P\n\n");
    script.exchange("RS\n", "RS\n00P\n\n");
    script.exchange("VV\n", "VV\nE\n\n");
    script.exchange("SCIP2.0\n", "SCIP2.0\n0\n\n");
    script.exchange("QT\n", "QT\n00P\n\n");
    script.identify();
}

#[test]
fn requests_before_connecting_are_refused() {
    let mut driver = ScipDriver::new(ScipOptions::default());
    let refused = |state| ScipError::NotReady {
        request: "a time exchange",
        state,
    };
    assert_eq!(
        driver.exchange_time(1, Duration::ZERO),
        Err(refused("not connected"))
    );
    driver.connect(Duration::ZERO);
    assert_eq!(
        driver.exchange_time(1, Duration::ZERO),
        Err(refused("connecting"))
    );
}

#[test]
fn what_was_heard_before_a_new_connection_is_not_reported() {
    let mut script = connecting();
    script.reply([0xFF; 40]);
    script.driver.connect(script.now);
    while script.driver.deadline().is_some() {
        script.time_out();
    }
    let (_, events) = drain(&mut script.driver);
    assert!(
        matches!(
            events.last(),
            Some(LaserEvent::ConnectionFailed(ScipError::NoReply { .. }))
        ),
        "{events:?}"
    );
}
