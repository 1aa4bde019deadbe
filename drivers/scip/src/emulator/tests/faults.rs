//! Faults, as the host sees them.

use super::*;

fn streaming() -> LaserRig {
    let mut rig = LaserRig::new(exact(LaserStartState::Streaming));
    rig.run(150 * MS);
    rig
}

fn wrong_sums(message: &[String]) -> usize {
    let wrong = message[1..].iter().filter(|line| {
        let (body, sum) = line.split_at(line.len() - 1);
        let total: u32 = body.bytes().map(u32::from).sum();
        u32::from(sum.as_bytes()[0]) != total % 64 + 48
    });
    wrong.count()
}

#[test]
fn bad_sums_occur_as_often_as_counted() {
    let mut rig = streaming();
    rig.inject("bad-sum:count=2");
    let wrong: Vec<usize> = messages(&rig.text(500 * MS))
        .iter()
        .map(|message| wrong_sums(message))
        .collect();
    assert_eq!(wrong, [1, 1, 0, 0, 0]);
}

#[test]
fn bytes_and_tails_go_missing() {
    let mut rig = streaming();
    rig.inject("dropped-byte");
    assert_eq!(rig.text(200 * MS).len(), 2 * 2137 - 1);
    rig.inject("truncated-scan");
    let length = rig.text(100 * MS).len();
    assert!((2137 / 4..=3 * 2137 / 4).contains(&length), "{length}");
    assert_eq!(rig.text(100 * MS).len(), 2137);
}

#[test]
fn stamps_repeat_or_ranges_freeze() {
    let mut rig = streaming();
    rig.inject("repeated-stamp:count=3");
    assert_eq!(stamps(&rig.text(500 * MS)), [0, 0, 0, 400, 500]);
    rig.inject("frozen-data:for=0.25");
    rig.source.range_mm = 5432;
    let text = rig.text(400 * MS);
    let old: Vec<bool> = messages(&text)
        .iter()
        .map(|lines| lines[5].contains("0CB"))
        .collect();
    assert_eq!(old, [true, true, true, false]);
    assert_eq!(stamps(&text), [600, 700, 800, 900]);
}

#[test]
fn silence_for_a_while_and_for_good() {
    let mut rig = streaming();
    rig.inject("silence:at=0.3,for=0.4");
    assert_eq!(
        stamps(&rig.text(1000 * MS)),
        [100, 200, 700, 800, 900, 1000]
    );
    rig.inject("silence");
    assert_eq!(rig.ask("QT"), "");
    rig.laser.power_cycle(rig.now);
    assert_eq!(rig.ask("QT"), "QT\nE\n\n");
}

#[test]
fn a_stop_to_verify_and_its_end() {
    let mut rig = LaserRig::idle();
    rig.inject("verify:at=0.3,status=31,for=0.35");
    rig.send("MD0044072501006\n");
    let text = rig.text(2000 * MS);
    let heads: Vec<String> = messages(&text)
        .iter()
        .map(|lines| format!("{} {}", &lines[0][13..], lines[1]))
        .collect();
    assert_eq!(
        heads,
        [
            "06 00P", "05 99b", "04 99b", "04 31T", "04 98a", "03 99b", "02 99b", "01 99b",
            "00 99b"
        ]
    );
    assert_eq!(stamps(&text), [100, 200, 800, 900, 1000, 1100]);
}

#[test]
fn hardware_fails_until_power_comes_back() {
    let mut rig = streaming();
    rig.inject("hardware:status=63,at=0.3");
    let text = rig.text(1000 * MS);
    assert!(text.ends_with("MD0044072501000\n63Y\n\n"), "{text}");
    assert!(!rig.laser.laser_on() && !rig.laser.streaming());
    assert_eq!(rig.status("RS"), "00");
    assert_eq!(rig.status("BM"), "01");
    assert_eq!(rig.status("MD0044072501000"), "63");
    rig.laser.power_cycle(rig.now);
    rig.ask("SCIP2.0");
    assert_eq!(rig.status("BM"), "00");
}

#[test]
fn hardware_that_heals() {
    let mut rig = LaserRig::idle();
    rig.inject("hardware:for=0.5");
    assert_eq!(rig.status("BM"), "01");
    rig.run(500 * MS);
    assert_eq!(rig.status("BM"), "00");
}

#[test]
fn trouble_in_stat_alone() {
    let mut rig = LaserRig::idle();
    rig.inject("trouble-stat:count=1");
    assert!(
        rig.ask("II")
            .contains("\nSTAT:Trouble!! Error No. =[00->33];")
    );
    assert!(rig.ask("II").contains("\nSTAT:Sensor works well.;8\n"));
}

#[test]
fn a_brown_out_falls_back_to_scip1() {
    let mut rig = streaming();
    rig.inject("brown-out:at=0.28");
    rig.run(1000 * MS);
    assert!(!rig.laser.streaming());
    assert_eq!(rig.laser.timer_ms(rig.now), 870);
    assert_eq!(rig.ask("QT"), "QT\nE\n\n");
    let mut rig = LaserRig::ug01();
    rig.ask("MD0044072501000");
    rig.inject("brown-out");
    rig.run(200 * MS);
    assert_eq!(rig.ask("QT"), "QT\n00P\n\n");
}

#[test]
fn the_window_is_covered() {
    let mut rig = streaming();
    rig.inject("covered:count=1");
    rig.inject("half-covered:at=0.25,count=1");
    let text = messages(&rig.text(300 * MS));
    let values = |lines: &[String]| {
        let joined: String = lines[3..]
            .iter()
            .map(|line| &line[..line.len() - 1])
            .collect();
        joined
            .as_bytes()
            .chunks(3)
            .map(|value| decode(std::str::from_utf8(value).expect("ascii")))
            .collect::<Vec<u32>>()
    };
    assert!(values(&text[0]).iter().all(|value| *value == 1));
    let half = values(&text[1]);
    assert!(
        half[..340].iter().all(|value| *value == 1234)
            && half[340..].iter().all(|value| *value == 1)
    );
    assert!(values(&text[2]).iter().all(|value| *value == 1234));
}

#[test]
fn the_timer_jumps() {
    let mut rig = streaming();
    rig.inject("timer-jump:by=2,at=0.25");
    assert_eq!(stamps(&rig.text(350 * MS)), [100, 200, 2300, 2400]);
}

#[test]
fn garbage_without_request() {
    let mut rig = LaserRig::idle();
    rig.inject("garbage:at=0.5,count=2");
    assert_eq!(
        rig.run(1000 * MS)
            .iter()
            .map(|output| output.bytes.len())
            .collect::<Vec<_>>(),
        [48, 48]
    );
    assert_eq!(rig.laser.next_event(), None);
}

#[test]
fn simulated_failures() {
    let run = |simulation: &str| {
        let mut rig = LaserRig::ug01();
        rig.ask(simulation);
        rig.send("MD0044072501030\n");
        let text = rig.text(6000 * MS);
        messages(&text)
            .iter()
            .map(|lines| lines[1].clone())
            .filter(|status| status != "99b")
            .collect::<Vec<_>>()
    };
    assert_eq!(run("DB03"), ["00P", "21S", "98a"]);
    assert_eq!(run("DB04"), ["00P", "21S", "50U"]);
    assert_eq!(run("DB05"), ["00P", "50U"]);
}

#[test]
fn absurd_times_do_no_harm() {
    let mut rig = streaming();
    for spec in [
        "verify:for=18446744073709550000",
        "hardware:at=18446744073709550000,for=18446744073709550000",
        "garbage:at=18446744073709550000,for=18446744073709550000",
        "silence:at=18446744073709550000,for=18446744073709550000",
    ] {
        rig.inject(spec);
    }
    rig.run(1000 * MS);
    assert_eq!(rig.ask("QT"), "QT\n00P\n\n");
}

#[test]
fn a_bit_of_a_scan_is_flipped() {
    let mut rig = streaming();
    let clean = rig.text(100 * MS);
    rig.inject("bit-flip:count=1");
    let corrupted = rig.run(100 * MS);
    let corrupted: Vec<u8> = corrupted
        .into_iter()
        .flat_map(|output| output.bytes)
        .collect();
    // The same ranges: only stamp, its sum and the flipped bit differ.
    let differing = clean
        .bytes()
        .zip(&corrupted)
        .filter(|(a, b)| a != *b)
        .count();
    assert_eq!(clean.len(), corrupted.len());
    assert!((1..=4).contains(&differing), "{differing}");
    assert_eq!(wrong_sums(&messages(&rig.text(100 * MS))[0]), 0);
}

#[test]
fn floods_and_endless_lines_come_in_bursts() {
    for (fault, byte) in [("flood", 0xFF), ("endless-line", b'0')] {
        let mut rig = LaserRig::idle();
        rig.inject(&format!("{fault}:at=0.5,for=0.25"));
        let outputs = rig.run(1000 * MS);
        let bytes: Vec<u8> = outputs
            .into_iter()
            .flat_map(|output| output.bytes)
            .collect();
        assert_eq!(bytes.len(), 3 * 7500, "{fault}");
        assert!(bytes.iter().all(|received| *received == byte));
        let reply = rig.ask("QT");
        assert_eq!(reply, "QT\n00P\n\n", "{fault}");
    }
}

#[test]
fn a_stamp_lies_before_the_last_one() {
    let mut rig = streaming();
    rig.inject("older-stamp:at=0.35");
    assert_eq!(stamps(&rig.text(500 * MS)), [100, 200, 100, 400, 500]);
}

#[test]
fn the_timer_is_set_near_its_wrap() {
    let mut rig = streaming();
    rig.inject("timer-set:to=16777.1,at=0.25");
    // Set at 250 ms: the revolutions of 300 ms and later are stamped by the new count.
    assert_eq!(stamps(&rig.text(500 * MS)), [100, 200, 16_777_150, 34, 134]);
    rig.inject("timer-set");
    assert_eq!(rig.text(Duration::ZERO).len(), 0);
    assert_eq!(rig.laser.timer_ms(rig.now), (1 << 24) - 5_000);
}

/// scip2 section 9: old units send an extra line `I` and a wrong sum after `SERI`.
#[test]
fn a_version_as_from_old_units_and_a_torn_one() {
    let mut rig = LaserRig::idle();
    rig.inject("odd-version:count=1");
    let text = rig.ask("VV");
    assert!(text.ends_with("\nSERI:H0706400;G\nI\n\n"), "{text}");
    assert!(rig.ask("VV").ends_with("\nSERI:H0706400;F\n\n"));
    rig.inject("torn-version");
    let text = rig.ask("VV");
    assert!(
        text.starts_with("VV\n00P\nVEND:") && !text.ends_with("\n\n"),
        "{text}"
    );
    assert!(rig.ask("VV").ends_with("\nSERI:H0706400;F\n\n"));
}

#[test]
fn another_host_leaves_it_streaming_or_in_time_adjust() {
    let mut rig = LaserRig::new(exact(LaserStartState::PowerUp));
    rig.inject("left-streaming:at=0.35");
    let text = rig.text(1000 * MS);
    assert_eq!(stamps(&text), [400, 500, 600, 700, 800, 900]);
    assert!(text.starts_with("MD0044072501000\n99b\n"));
    rig.inject("left-in-time-adjust");
    assert_eq!(rig.status("VV"), "0E");
    assert!(!rig.laser.streaming() && !rig.laser.laser_on());
    assert_eq!(rig.status("TM2"), "00");
    assert_eq!(rig.status("VV"), "00");
}

/// scip2 section 5: only VV, II, RS and SCIP2.0 are accepted; II reports it; RS ends it.
#[test]
fn an_interrupted_update_answers_0i() {
    let mut rig = LaserRig::ug01();
    rig.inject("firmware-update");
    for line in [
        "PP",
        "BM",
        "QT",
        "TM0",
        "GD0044072501",
        "MD0044072501000",
        "XY",
    ] {
        assert_eq!(rig.status(line), "0I", "{line}");
    }
    assert_eq!(rig.status("SCIP2.0"), "0E");
    assert_eq!(rig.status("VV"), "00");
    assert!(
        rig.ask("II")
            .contains("\nUDST:F/W update mode (CPU clock is 6MHz);")
    );
    assert_eq!(rig.status("RS"), "00");
    assert_eq!(rig.status("QT"), "00");
    assert!(!rig.ask("II").contains("UDST"));
}

/// scip2 section 10: a URG-04LX may need a power cycle after a request for intensity or several echoes.
#[test]
fn an_unsupported_request_may_make_it_unresponsive() {
    let mut rig = LaserRig::idle();
    assert_eq!(rig.status("ME0044072501000"), "0E");
    rig.inject("deafened");
    assert_eq!(rig.status("XY"), "0E");
    assert_eq!(rig.ask("GE0044072501"), "");
    assert_eq!(rig.ask("QT"), "");
    rig.laser.power_cycle(rig.now);
    assert_eq!(rig.ask("QT"), "QT\nE\n\n");
}
