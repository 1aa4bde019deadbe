//! `MD` and `MS`, and what ends them.

use super::*;

#[test]
fn three_scans_with_one_skipped_between() {
    let mut bench = Bench::idle();
    bench.send("MD0044072501103;tag\n");
    let text = bench.text(2000 * MS);
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
    assert_eq!(bench.room.looks.len(), 3);
    assert!(!bench.twin.laser_on() && !bench.twin.streaming());
    assert_eq!(bench.twin.next_event(), None);
}

#[test]
fn a_scan_is_sent_after_step_768_of_a_revolution_begun_after_the_command() {
    let mut bench = Bench::idle();
    bench.send("MD0044072501000\n");
    let outputs = bench.run(300 * MS);
    let data = outputs
        .iter()
        .position(|output| output.bytes.windows(3).any(|bytes| bytes == b"99b"));
    let data = &outputs[data.expect("a scan")..];
    assert!(
        data[0].at >= 175 * MS && data[0].at < 177 * MS,
        "{:?}",
        data[0].at
    );
    assert_eq!(bench.room.looks[0], (100 * MS, 100 * MS));
    let first: Vec<&Output> = data
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
    let mut bench = Bench::new(TwinOptions::default());
    bench.ask("SCIP2.0");
    bench.send("MS0100010002000\n");
    let text = bench.text(3000 * MS);
    let data = messages(&text).split_off(1);
    assert!(data.len() > 25);
    assert!(
        data.iter()
            .all(|lines| lines[0] == "MS0100010002000" && lines[1] == "99b" && lines[3] == "CB5")
    );
    bench.send("QT\n");
    let text = bench.text(1000 * MS);
    assert!(text.ends_with("QT\n00P\n\n"), "{text}");
    assert!(messages(&text).len() <= 3);
    assert!(!bench.twin.laser_on());
}

#[test]
fn the_tail_of_a_scan_in_flight_comes_before_the_quit_echo() {
    let link = Link::Serial { baud: 19_200 };
    let mut bench = Bench::new(TwinOptions {
        link,
        ..exact(StartState::Streaming)
    });
    bench.run(500 * MS);
    bench.send("QT\n");
    let text = bench.text(2000 * MS);
    assert!(
        text.len() > 500 && text.ends_with("\n\nQT\n00P\n\n"),
        "{text}"
    );
}

#[test]
fn a_slow_line_loses_whole_scans() {
    let link = Link::Serial { baud: 115_200 };
    let mut bench = Bench::new(TwinOptions {
        link,
        ..exact(StartState::Streaming)
    });
    let text = bench.text(5000 * MS);
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
    let link = Link::Serial { baud: 250_000 };
    let mut bench = Bench::new(TwinOptions {
        link,
        ..exact(StartState::Streaming)
    });
    let text = bench.text(5000 * MS);
    assert!(
        stamps(&text)
            .windows(2)
            .all(|pair| pair[1] - pair[0] == 100)
    );
}

#[test]
fn reset_leaves_streaming_but_not_time_adjustment() {
    let mut bench = Bench::new(exact(StartState::Streaming));
    let text = bench.ask("RS");
    assert!(text.ends_with("RS\n00P\n\n"), "{text}");
    assert!(!bench.twin.streaming() && !bench.twin.laser_on());
    assert!(bench.twin.timer_ms(bench.now) < 100);
    assert_eq!(bench.status("TM0"), "00");
    assert_eq!(bench.ask("RS"), "RS\n0Ee\n\n");
    assert_eq!(bench.ask("VV"), "VV\n0Ee\n\n");
    assert_eq!(bench.status("TM2"), "00");
    assert_eq!(bench.status("RS"), "00");
    assert_eq!(bench.status("VV"), "00");
}

#[test]
fn nobody_waiting_means_nobody_looks() {
    let mut bench = Bench::idle();
    bench.ask("BM");
    bench.run(Duration::from_secs(60));
    assert!(bench.room.looks.is_empty());
    assert_eq!(bench.twin.next_event(), None);
    bench.ask("GD0044072501");
    assert_eq!(bench.room.looks.len(), 1);
}

#[test]
fn a_scan_asked_for_while_streaming_is_the_one_just_streamed() {
    let mut bench = Bench::new(exact(StartState::Streaming));
    bench.send("GD0384038401\n");
    let text = bench.text(99 * MS);
    let messages = messages(&text);
    assert_eq!(messages[0][0], "MD0044072501000");
    assert_eq!(messages[1][0], "GD0384038401");
    assert_eq!(messages[0][2], messages[1][2]);
    assert_eq!(bench.room.looks.len(), 1);
}

#[test]
fn steps_outside_the_window_cannot_be_measured() {
    let mut bench = Bench::new(exact(StartState::LaserOn));
    let reply = bench.ask("GD0043004401");
    assert_eq!(&reply.lines().nth(3).expect("data")[..6], "00C0CB");
    let reply = bench.ask("GS0725076802");
    let values = &reply.lines().nth(3).expect("data")[..44];
    assert_eq!(values, format!("CB{}", "0C".repeat(21)));
}

#[test]
fn a_slower_motor_gives_longer_revolutions() {
    let mut bench = Bench::idle();
    bench.ask("CR10");
    bench.send("MD0044072501000\n");
    let stamps = stamps(&bench.text(2000 * MS));
    assert!(
        stamps
            .windows(2)
            .all(|pair| (111..=112).contains(&(pair[1] - pair[0]))),
        "{stamps:?}"
    );
}

#[test]
fn a_change_of_bit_rate_follows_its_reply() {
    let link = Link::Serial { baud: 19_200 };
    let mut bench = Bench::new(TwinOptions {
        link,
        ..exact(StartState::Idle)
    });
    assert_eq!(bench.ask("SS115200"), "SS115200\n00P\n\n");
    assert_eq!(bench.ask("VV"), "");
    bench.twin.set_host_baud(115_200);
    assert_eq!(bench.status("VV"), "00");
    assert_eq!(bench.ask("RS"), "RS\n00P\n\n");
    assert_eq!(bench.ask("QT"), "");
    bench.twin.set_host_baud(19_200);
    assert_eq!(bench.ask("QT"), "QT\n00P\n\n");
}
