//! The bit rate of a serial line: recognised, raised, and left where that does not work; byte by byte, and against the
//! emulated laser, whose line is paced.

mod common;

use common::driver_and_emulator::DriverAndEmulator;
use common::{II, PP, ScriptedLaser, VV};
use scip::emulator::{LaserLink, LaserOptions};
use scip::{LaserEvent, ScipDriver, ScipError, ScipOptions, ValueCoding};
use std::time::Duration;

fn options() -> ScipOptions {
    ScipOptions {
        link_bytes_per_second: Some(1920),
        wanted_bit_rate: Some(115_200),
        reset_on_connect: false,
        ..ScipOptions::default()
    }
}

/// Identified over 19200 bit/s, asked for 115200.
fn asked() -> ScriptedLaser {
    let mut script = ScriptedLaser::new(ScipDriver::new(options()));
    script.driver.connect(script.now);
    script.exchange("QT\n", "QT\n00P\n\n");
    script.exchange("VV\n", VV);
    script.exchange("PP\n", PP);
    script.exchange("II\n", II);
    script.expect_sent(&["SS115200\n"]);
    script
}

/// The bytes per second of the line after connecting, and the events before.
fn connected(script: &mut ScriptedLaser) -> (Option<u32>, Vec<LaserEvent>) {
    let mut events = script.take_events();
    match events.pop() {
        Some(LaserEvent::Connected(identity)) => (identity.line_bytes_s, events),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_slow_line_is_raised_after_the_reply_and_a_pause() {
    let mut script = asked();
    script.reply("SS115200\n00P\n\n");
    script.expect_sent(&[]);
    let replied = script.now;
    script.time_out();
    assert_eq!(script.now - replied, Duration::from_millis(150));
    script.expect_sent(&["rate 115200", "II\n"]);
    script.reply(II);
    assert_eq!(connected(&mut script), (Some(11_520), Vec::new()));
}

#[test]
fn a_refusal_or_silence_leaves_the_rate_as_it_was() {
    let kept = LaserEvent::BitRateKept { wanted: 115_200 };
    for status in ["02R", "04T", "0Ee"] {
        let mut script = asked();
        script.reply(format!("SS115200\n{status}\n\n"));
        assert_eq!(connected(&mut script), (Some(1920), vec![kept.clone()]));
    }
    let mut script = asked();
    script.time_out();
    script.expect_sent(&["SS115200\n"]);
    script.time_out();
    script.expect_sent(&["SS115200\n"]);
    script.time_out();
    assert_eq!(connected(&mut script), (Some(1920), vec![kept]));
}

#[test]
fn a_rate_without_a_reply_is_given_up() {
    let fallen_back = || {
        let mut script = asked();
        script.reply("SS115200\n00P\n\n");
        script.time_out();
        script.expect_sent(&["rate 115200", "II\n"]);
        for _ in 0..2 {
            script.time_out();
            script.expect_sent(&["II\n"]);
        }
        script.time_out();
        script.expect_sent(&["rate 19200", "QT\n"]);
        script
    };
    let mut script = fallen_back();
    script.reply("QT\n00P\n\n");
    let kept = LaserEvent::BitRateKept { wanted: 115_200 };
    assert_eq!(connected(&mut script), (Some(1920), vec![kept]));

    let mut script = fallen_back();
    for _ in 0..2 {
        script.time_out();
        script.expect_sent(&["QT\n"]);
    }
    script.time_out();
    let lost = LaserEvent::ConnectionFailed(ScipError::BitRateLost { wanted: 115_200 });
    assert_eq!(script.take_events(), [lost]);
}

#[test]
fn a_line_that_is_as_fast_as_wanted_or_has_no_rate_is_left_alone() {
    for (link_bytes_per_second, wanted_bit_rate) in [
        (Some(11_520), Some(115_200)),
        (Some(25_000), Some(115_200)),
        (None, Some(115_200)),
        (Some(1920), None),
    ] {
        let mut script = ScriptedLaser::new(ScipDriver::new(ScipOptions {
            link_bytes_per_second,
            wanted_bit_rate,
            ..options()
        }));
        script.driver.connect(script.now);
        script.exchange("QT\n", "QT\n00P\n\n");
        script.exchange("VV\n", VV);
        script.exchange("PP\n", PP);
        script.exchange("II\n", II);
        assert_eq!(connected(&mut script), (link_bytes_per_second, Vec::new()));
    }
}

fn emulated(link: LaserLink, wanted: Option<u32>, max_bit_rate: u32) -> DriverAndEmulator {
    let mut pair = DriverAndEmulator::new(LaserOptions {
        link,
        ..LaserOptions::default()
    });
    pair.max_bit_rate = max_bit_rate;
    pair.driver = ScipDriver::new(ScipOptions {
        wanted_bit_rate: wanted,
        reset_on_connect: false,
        ..ScipOptions::default()
    });
    pair
}

fn line_of(pair: &mut DriverAndEmulator) -> Option<u32> {
    match pair.try_connect() {
        LaserEvent::Connected(identity) => identity.line_bytes_s,
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_pace_of_the_replies_shows_the_rate_of_a_line() {
    for baud in [19_200, 57_600, 115_200, 250_000] {
        let mut pair = emulated(LaserLink::Serial { baud }, None, u32::MAX);
        assert_eq!(line_of(&mut pair), Some(baud / 10));
    }
    for link in [LaserLink::Usb, LaserLink::Network] {
        assert_eq!(line_of(&mut emulated(link, None, u32::MAX)), None);
    }
}

#[test]
fn a_raised_line_carries_the_scans_that_it_did_not() {
    let slow = LaserLink::Serial { baud: 19_200 };
    let mut pair = emulated(slow, Some(250_000), u32::MAX);
    assert_eq!(line_of(&mut pair), Some(25_000));
    pair.stream(ValueCoding::ThreeCharacter);
    let scans = pair.scans(Duration::from_secs(5));
    assert!(scans >= 47, "{scans} scans");
}

#[test]
fn a_line_that_does_not_carry_the_wanted_rate_goes_back() {
    let slow = LaserLink::Serial { baud: 19_200 };
    let mut pair = emulated(slow, Some(250_000), 115_200);
    // The sensor has changed, the line garbles it: neither rate is answered.
    let lost = LaserEvent::ConnectionFailed(ScipError::BitRateLost { wanted: 250_000 });
    assert_eq!(pair.try_connect(), lost);
}
