//! scip2 section 6: every command with every status it can have.

use super::*;

/// Sends `before`, then `line`, and checks the status of the latter.
fn check(make: fn() -> LaserRig, table: &[(&str, &str, &str)]) {
    for (before, line, expected) in table {
        let mut rig = make();
        for line in before.split('|').filter(|line| !line.is_empty()) {
            rig.ask(line);
        }
        assert_eq!(rig.status(line), *expected, "`{line}` after `{before}`");
    }
}

#[test]
fn firmware_3_1_04() {
    check(
        LaserRig::idle,
        &[
            ("", "VV", "00"),
            ("", "PP", "00"),
            ("", "II", "00"),
            ("", "SCIP2.0", "0E"),
            ("", "BM", "00"),
            ("BM", "BM", "02"),
            ("MD0044072501000", "BM", "02"),
            ("", "QT", "00"),
            ("BM", "QT", "00"),
            ("", "RS", "00"),
            ("BM|RS", "BM", "00"),
            ("", "TM0", "00"),
            ("TM0", "TM0", "02"),
            ("TM0", "TM1", "00"),
            ("TM0", "TM2", "00"),
            ("", "TM1", "04"),
            ("", "TM2", "03"),
            ("", "TM3", "01"),
            ("", "TMx", "01"),
            ("TM0", "TM7", "01"),
            ("TM0", "VV", "0E"),
            ("TM0", "QT", "0E"),
            ("TM0", "RS", "0E"),
            ("TM0|RS", "VV", "0E"),
            ("TM0|TM2", "VV", "00"),
            ("", "SS115200", "00"),
            ("", "SS750000", "00"),
            ("", "SS11520x", "01"),
            ("", "SS123456", "02"),
            ("", "SS019200", "03"),
            ("SS115200", "SS115200", "03"),
            ("SS115200|RS", "SS019200", "03"),
            ("", "SS038400", "04"),
            ("", "SS19200", "0C"),
            ("", "CR00", "03"),
            ("", "CR99", "03"),
            ("", "CR10", "00"),
            ("CR10", "CR10", "03"),
            ("CR10", "CR99", "00"),
            ("CR10|RS", "CR00", "03"),
            ("", "CR1x", "01"),
            ("", "CR11", "02"),
            ("", "HS1", "0C"),
            ("", "DB10", "0E"),
            ("", "GD0044072501", "10"),
            ("BM", "GD0044072501", "00"),
            ("BM", "GS0044072501", "00"),
            ("BM", "GD0044072500", "00"),
            ("BM", "GD0000076899", "00"),
            ("BM", "GDx044072501", "01"),
            ("BM", "GD0044x72501", "02"),
            ("BM", "GD00440725x1", "03"),
            ("BM", "GD0044076901", "04"),
            ("BM", "GD0044004301", "05"),
            ("", "GD00440043x1", "03"),
            ("", "MD0044072501005", "00"),
            ("", "MS0044072501000", "00"),
            ("", "MDx044072501000", "01"),
            ("", "MD0044x72501000", "02"),
            ("", "MD00440725x1000", "03"),
            ("", "MD0044076901000", "04"),
            ("", "MS0044004301000", "05"),
            ("", "MD0044072501x00", "06"),
            ("", "MD00440725010x0", "07"),
            ("", "MD004407250100", "0C"),
            ("", "MD00440725010000", "0D"),
            ("", "ME0044072501000", "0E"),
            ("", "GE0044072501", "0E"),
            ("", "ND0044072501000", "0E"),
            ("", "HD0044072501", "0E"),
            ("", "RT", "0E"),
            ("", "%ST", "0E"),
            ("", "V", "0E"),
            ("", "AT", "0E"),
            ("", "VV;1234567890abcdefg", "0G"),
            ("", "VV;a/b", "0H"),
        ],
    );
}

#[test]
fn firmware_3_4_03() {
    check(
        LaserRig::ug01,
        &[
            ("", "HS1", "00"),
            ("", "HS0", "02"),
            ("HS1", "HS1", "02"),
            ("HS1|RS", "HS0", "02"),
            ("", "HSx", "01"),
            ("", "HS2", "01"),
            ("", "SS115200", "04"),
            ("", "DB99", "01"),
            ("", "DB01", "04"),
            ("", "DB02", "00"),
            ("DB02", "DB02", "02"),
            ("DB02", "BM", "01"),
            ("DB02", "GD0044072501", "50"),
            ("DB02", "MD0044072501000", "50"),
            ("DB02", "DB10", "00"),
            ("DB02|DB10", "BM", "00"),
            ("", "DB10", "03"),
        ],
    );
}

#[test]
fn broken_hardware_refuses_to_simulate_failures() {
    let mut rig = LaserRig::ug01();
    rig.inject("hardware:status=77");
    rig.run(MS);
    assert_eq!(rig.status("DB03"), "05");
    assert_eq!(rig.status("BM"), "01");
    assert_eq!(rig.status("GD0044072501"), "77");
    assert!(rig.ask("II").contains("STAT:Trouble!!"));
}

#[test]
fn a_repeat_of_a_pending_command_is_refused_in_its_place() {
    let mut rig = LaserRig::idle();
    rig.send("VV\nPP\nVV\nQT\nQT\n");
    let replies = messages(&rig.text(1000 * MS));
    let statuses: Vec<(&str, &str)> = replies
        .iter()
        .map(|lines| (lines[0].as_str(), lines[1].as_str()))
        .collect();
    assert_eq!(
        statuses,
        [
            ("VV", "00P"),
            ("PP", "00P"),
            ("VV", "0Bb"),
            ("QT", "00P"),
            ("QT", "00P")
        ]
    );
    rig.send("TM0\nTM1\nTM1\nTM2\n");
    let replies = messages(&rig.text(100 * MS));
    let statuses: Vec<(&str, &str)> = replies
        .iter()
        .map(|lines| (lines[0].as_str(), lines[1].as_str()))
        .collect();
    assert_eq!(
        statuses,
        [
            ("TM0", "00P"),
            ("TM1", "00P"),
            ("TM1", "0Bb"),
            ("TM2", "00P")
        ]
    );
}

#[test]
fn a_second_stream_is_refused_and_the_first_goes_on() {
    let mut rig = LaserRig::idle();
    rig.ask("MD0044072501000");
    let text = rig.ask("MS0044072501000");
    assert!(text.contains("MS0044072501000\n0Bb\n\n"), "{text}");
    assert!(rig.laser.streaming());
}

#[test]
fn more_requests_than_the_queue_holds() {
    let mut rig = LaserRig::idle();
    rig.send(&"QT\n".repeat(20));
    let replies = messages(&rig.text(3000 * MS));
    assert_eq!(replies.iter().filter(|lines| lines[1] == "0Bb").count(), 4);
    assert_eq!(replies.iter().filter(|lines| lines[1] == "00P").count(), 16);
}

#[test]
fn conditions_reported_by_ii() {
    let mut rig = LaserRig::idle();
    rig.ask("CR10");
    rig.ask("SS115200");
    let text = rig.ask("II;now");
    assert!(text.starts_with("II;now\n00P\n"));
    assert!(
        text.contains("\nSCSP:540[rpm];") && text.contains("\nSBPS:115200[bps];"),
        "{text}"
    );
    let mut rig = LaserRig::ug01();
    rig.ask("HS1");
    rig.ask("BM");
    let text = rig.ask("II");
    assert!(
        text.contains("\nMESM:Measuring by Sensitive Mode;")
            && text.contains("\nSBPS:USB Full Speed;"),
        "{text}"
    );
}
