//! `MD` and `MS`, and what ends them.

use super::*;

#[test]
fn three_scans_with_one_skipped_between() {
    let mut rig = LaserRig::idle();
    rig.send("MD0044072501103;tag\n");
    let text = rig.text(2000 * MS);
    let heads: Vec<(String, String)> = messages(&text)
        .into_iter()
        .map(|lines| (lines[0].clone(), lines[1].clone()))
        .collect();
    let expected = [("03", "00P"), ("02", "99b"), ("01", "99b"), ("00", "99b")];
    let expected =
        expected.map(|(count, status)| (format!("MD00440725011{count};tag"), status.to_owned()));
    assert_eq!(heads, expected);
    let stamps = stamps(&text);
    assert_eq!(stamps, [100, 300, 500]);
    assert_eq!(rig.source.revolutions.len(), 3);
    assert!(!rig.laser.laser_on() && !rig.laser.streaming());
    assert_eq!(rig.laser.next_event(), None);
}

#[test]
fn a_scan_is_sent_after_step_768_of_a_revolution_that_starts_after_the_command() {
    let mut rig = LaserRig::idle();
    rig.send("MD0044072501000\n");
    let outputs = rig.run(300 * MS);
    let data = outputs
        .iter()
        .position(|output| output.bytes.windows(3).any(|bytes| bytes == b"99b"));
    let data = &outputs[data.expect("a scan")..];
    assert!(
        data[0].at >= 175 * MS && data[0].at < 177 * MS,
        "{:?}",
        data[0].at
    );
    assert_eq!(rig.source.revolutions[0], (100 * MS, 100 * MS));
    let first: Vec<&LaserOutput> = data
        .iter()
        .take_while(|output| output.at < 200 * MS)
        .collect();
    assert_eq!(
        first.iter().map(|output| output.bytes.len()).sum::<usize>(),
        2137
    );
    let span = first[first.len() - 1].at - first[0].at;
    assert!(
        span >= Duration::from_micros(5_500) && span <= Duration::from_micros(8_000),
        "{span:?}"
    );
}

#[test]
fn without_end_the_count_stays_00_until_quit() {
    let mut rig = LaserRig::new(LaserOptions::default());
    rig.ask("SCIP2.0");
    rig.send("MS0100010002000\n");
    let text = rig.text(3000 * MS);
    let data = messages(&text).split_off(1);
    assert!(data.len() > 25);
    assert!(
        data.iter()
            .all(|lines| lines[0] == "MS0100010002000" && lines[1] == "99b" && lines[3] == "CB5")
    );
    rig.send("QT\n");
    let text = rig.text(1000 * MS);
    assert!(text.ends_with("QT\n00P\n\n"), "{text}");
    assert!(messages(&text).len() <= 3);
    assert!(!rig.laser.laser_on());
}

#[test]
fn the_tail_of_a_scan_in_flight_comes_before_the_quit_echo() {
    let link = LaserLink::Serial { baud: 19_200 };
    let mut rig = LaserRig::new(LaserOptions {
        link,
        ..exact(LaserStartState::Streaming)
    });
    rig.run(500 * MS);
    rig.send("QT\n");
    let text = rig.text(2000 * MS);
    assert!(
        text.len() > 500 && text.ends_with("\n\nQT\n00P\n\n"),
        "{text}"
    );
}

#[test]
fn a_slow_line_loses_whole_scans() {
    let link = LaserLink::Serial { baud: 115_200 };
    let mut rig = LaserRig::new(LaserOptions {
        link,
        ..exact(LaserStartState::Streaming)
    });
    let text = rig.text(5000 * MS);
    assert!(
        stamps(&text)
            .windows(2)
            .all(|pair| pair[1] - pair[0] == 200)
    );
    let messages = messages(&text);
    assert!(
        messages[..messages.len() - 1]
            .iter()
            .all(|lines| lines.len() == 3 + 32)
    );
    let link = LaserLink::Serial { baud: 250_000 };
    let mut rig = LaserRig::new(LaserOptions {
        link,
        ..exact(LaserStartState::Streaming)
    });
    let text = rig.text(5000 * MS);
    assert!(
        stamps(&text)
            .windows(2)
            .all(|pair| pair[1] - pair[0] == 100)
    );
}

#[test]
fn reset_ends_streaming_but_not_time_adjust() {
    let mut rig = LaserRig::new(exact(LaserStartState::Streaming));
    let text = rig.ask("RS");
    assert!(text.ends_with("RS\n00P\n\n"), "{text}");
    assert!(!rig.laser.streaming() && !rig.laser.laser_on());
    assert!(rig.laser.timer_ms(rig.now) < 100);
    assert_eq!(rig.status("TM0"), "00");
    assert_eq!(rig.ask("RS"), "RS\n0Ee\n\n");
    assert_eq!(rig.ask("VV"), "VV\n0Ee\n\n");
    assert_eq!(rig.status("TM2"), "00");
    assert_eq!(rig.status("RS"), "00");
    assert_eq!(rig.status("VV"), "00");
}

#[test]
fn no_request_means_no_revolution_is_measured() {
    let mut rig = LaserRig::idle();
    rig.ask("BM");
    rig.run(Duration::from_secs(60));
    assert!(rig.source.revolutions.is_empty());
    assert_eq!(rig.laser.next_event(), None);
    rig.ask("GD0044072501");
    assert_eq!(rig.source.revolutions.len(), 1);
}

#[test]
fn a_scan_asked_for_while_streaming_is_the_one_just_streamed() {
    let mut rig = LaserRig::new(exact(LaserStartState::Streaming));
    rig.send("GD0384038401\n");
    let text = rig.text(99 * MS);
    let messages = messages(&text);
    assert_eq!(messages[0][0], "MD0044072501000");
    assert_eq!(messages[1][0], "GD0384038401");
    assert_eq!(messages[0][2], messages[1][2]);
    assert_eq!(rig.source.revolutions.len(), 1);
}

#[test]
fn steps_outside_the_window_cannot_be_measured() {
    let mut rig = LaserRig::new(exact(LaserStartState::LaserOn));
    let reply = rig.ask("GD0043004401");
    assert_eq!(&reply.lines().nth(3).expect("data")[..6], "00C0CB");
    let reply = rig.ask("GS0725076802");
    let values = &reply.lines().nth(3).expect("data")[..44];
    assert_eq!(values, format!("CB{}", "0C".repeat(21)));
}

#[test]
fn a_slower_motor_gives_longer_revolutions() {
    let mut rig = LaserRig::idle();
    rig.ask("CR10");
    rig.send("MD0044072501000\n");
    let stamps = stamps(&rig.text(2000 * MS));
    assert!(
        stamps
            .windows(2)
            .all(|pair| (111..=112).contains(&(pair[1] - pair[0]))),
        "{stamps:?}"
    );
}

#[test]
fn a_change_of_bit_rate_follows_its_reply() {
    let link = LaserLink::Serial { baud: 19_200 };
    let mut rig = LaserRig::new(LaserOptions {
        link,
        ..exact(LaserStartState::Idle)
    });
    assert_eq!(rig.ask("SS115200"), "SS115200\n00P\n\n");
    assert_eq!(rig.ask("VV"), "");
    rig.laser.set_host_baud(115_200);
    assert_eq!(rig.status("VV"), "00");
    assert_eq!(rig.ask("RS"), "RS\n00P\n\n");
    assert_eq!(rig.ask("QT"), "");
    rig.laser.set_host_baud(19_200);
    assert_eq!(rig.ask("QT"), "QT\n00P\n\n");
}
