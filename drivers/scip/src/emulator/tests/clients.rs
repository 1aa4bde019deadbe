//! Third-party programs as the document describes their habits (scip2 sections 6, 8, 10, 13 and 15): each is played against
//! the emulator, byte by byte in virtual time, by a client that shares no code with this crate's driver.

use super::*;
use crate::emulator::LaserLink;

/// A client that reads characters one by one and gives up on a line after a gap of this length.
struct LineClient {
    rig: LaserRig,
    gap: Duration,
    received: std::collections::VecDeque<u8>,
}

impl LineClient {
    fn new(rig: LaserRig, gap: Duration) -> Self {
        Self {
            rig,
            gap,
            received: Default::default(),
        }
    }

    fn send(&mut self, line: &str) {
        self.rig.send(&format!("{line}\n"));
    }

    fn byte(&mut self) -> Option<u8> {
        let give_up_at = self.rig.now + self.gap;
        while self.received.is_empty() && self.rig.now < give_up_at {
            let received = self.rig.run(MS);
            self.received
                .extend(received.into_iter().flat_map(|output| output.bytes));
        }
        self.received.pop_front()
    }

    /// A line without its end; `None` after a gap.
    fn line(&mut self) -> Option<String> {
        let mut line = String::new();
        loop {
            match self.byte()? {
                b'\n' => return Some(line),
                byte => line.push(char::from(byte)),
            }
        }
    }

    /// The lines of one reply, up to its empty line.
    fn reply(&mut self) -> Vec<String> {
        let mut lines = Vec::new();
        loop {
            let line = self.line().expect("no gap within a reply");
            if line.is_empty() {
                return lines;
            }
            lines.push(line);
        }
    }

    /// Sends and expects the echo first.
    fn ask(&mut self, line: &str) -> Vec<String> {
        self.send(line);
        let reply = self.reply();
        assert_eq!(reply[0], line);
        reply
    }
}

/// urg_library 1.2.7 waits 140 ms per line: `QT`, on `E` `SCIP2.0`, then who it is; one scan by `BM` and `GD`, scans by
/// `MD`, which it ends by `QT`, reading up to three replies before the echo.
fn play_urg_library(rig: LaserRig, steps: &str, starts_in_scip1: bool) {
    let mut client = LineClient::new(rig, 140 * MS);
    let reply = client.ask("QT");
    assert_eq!(reply[1], if starts_in_scip1 { "E" } else { "00P" });
    if starts_in_scip1 {
        assert_eq!(client.ask("SCIP2.0")[1], "0");
        assert_eq!(client.ask("QT")[1], "00P");
    }
    assert_eq!(client.ask("VV").len(), 7);
    let parameters = client.ask("PP");
    assert!(parameters.iter().any(|line| line.starts_with("AFRT:")));
    assert!(client.ask("II").len() >= 9);
    for round in 0..2 {
        assert_eq!(client.ask("BM")[1], "00P");
        let scan = client.ask(&format!("GD{steps}00"));
        assert_eq!(scan[1], "00P");
        let characters: usize = scan[3..].iter().map(|line| line.len() - 1).sum();
        let (first, last) = (&steps[..4], &steps[4..]);
        let number = |text: &str| text.parse::<usize>().expect("a number");
        assert_eq!(characters, (number(last) - number(first) + 1) * 3);
        assert_eq!(client.ask(&format!("MD{steps}00000"))[1], "00P");
        for _ in 0..5 {
            let scan = client.reply();
            assert_eq!(scan[0], format!("MD{steps}00000"));
            assert_eq!(scan[1], "99b");
        }
        client.send("QT");
        let before = (0..4).position(|_| client.reply()[0] == "QT");
        assert!(before.is_some_and(|scans| scans <= 3), "round {round}");
    }
    // The laser went off with QT: a GD after MD is refused until BM.
    assert_eq!(client.ask(&format!("GD{steps}00"))[1], "10Q");
    assert_eq!(client.ask("BM")[1], "00P");
    assert_eq!(client.ask(&format!("GD{steps}00"))[1], "00P");
    assert_eq!(client.ask("TM0")[1], "00P");
    assert_eq!(client.ask("TM1").len(), 3);
    assert_eq!(client.ask("TM2")[1], "00P");
}

#[test]
fn the_vendors_library_with_its_gaps_of_140_ms() {
    let urg = LaserOptions::default;
    play_urg_library(LaserRig::new(urg()), "00440725", true);
    let ug01 = LaserOptions {
        profile: LaserProfile::urg_04lx_ug01(),
        ..urg()
    };
    play_urg_library(LaserRig::new(ug01), "00440725", false);
    let utm = LaserOptions {
        profile: LaserProfile::utm_30lx(),
        ..urg()
    };
    play_urg_library(LaserRig::new(utm), "00001080", false);
    let ust = LaserOptions {
        profile: LaserProfile::ust_20lx(),
        link: LaserLink::Network,
        ..urg()
    };
    play_urg_library(LaserRig::new(ust), "00001080", false);
}

/// A finite stream turns the laser off after its last scan (scip2 section 6): a GD after it needs BM; a GD within it does not.
#[test]
fn gd_after_md_and_within_it() {
    let mut client = LineClient::new(LaserRig::idle(), 250 * MS);
    assert_eq!(client.ask("MD0044072501002")[1], "00P");
    assert_eq!(client.reply()[0], "MD0044072501001");
    client.send("GD0384038401");
    let replies = [client.reply(), client.reply()].map(|reply| reply[0].clone() + &reply[1]);
    assert!(
        replies.contains(&"GD038403840100P".to_owned()),
        "{replies:?}"
    );
    assert!(
        replies.contains(&"MD004407250100099b".to_owned()),
        "{replies:?}"
    );
    assert_eq!(client.ask("GD0384038401")[1], "10Q");
    assert_eq!(client.ask("BM")[1], "00P");
    assert_eq!(client.ask("GD0384038401")[1], "00P");
}

/// hokuyo_node resets in this order whatever the device was left in: flush, `TM2`, `RS` (replies ignored),
/// flush, `RS`, which must work (scip2 section 13).
#[test]
fn the_reset_order_of_the_ros_driver() {
    for start in [
        LaserStartState::Idle,
        LaserStartState::LaserOn,
        LaserStartState::Streaming,
        LaserStartState::TimeAdjust,
    ] {
        let mut rig = LaserRig::new(exact(start));
        rig.run(320 * MS);
        rig.send("TM2\n");
        rig.run(1000 * MS);
        rig.send("RS\n");
        rig.run(1000 * MS);
        let mut client = LineClient::new(rig, 1000 * MS);
        assert_eq!(client.ask("RS")[1], "00P", "{start:?}");
        assert_eq!(client.ask("BM")[1], "00P", "{start:?}");
        assert_eq!(client.ask("QT")[1], "00P", "{start:?}");
    }
}

/// hokuyoaist and others end their requests with LF or CR LF, number them by a string, and send the next before the
/// reply to the last: the string comes back, and with it every reply finds its request (scip2 section 3).
#[test]
fn strings_name_their_requests() {
    let mut rig = LaserRig::idle();
    rig.send("VV;a1\r\nPP;a 2\nII;x_y.z+@\rBM;0123456789abcdef\n");
    let heads: Vec<String> = messages(&rig.text(1000 * MS))
        .iter()
        .map(|reply| format!("{} {}", reply[0], reply[1]))
        .collect();
    let expected = [
        "VV;a1 00P",
        "PP;a 2 00P",
        "II;x_y.z+@ 00P",
        "BM;0123456789abcdef 00P",
    ];
    assert_eq!(heads, expected);
    rig.send("MD0384038401002;scan 7\n");
    let echoes: Vec<String> = messages(&rig.text(500 * MS))
        .iter()
        .map(|reply| reply[0].clone())
        .collect();
    let expected = [2, 1, 0].map(|left| format!("MD038403840100{left};scan 7"));
    assert_eq!(echoes, expected);
}

/// hokuyolx asks a UST for its state by `%ST` before and between, synchronises, wants distance with intensity, and puts
/// it to sleep in the end. A URG-04LX answers `%ST` as undefined.
#[test]
fn the_python_client_of_the_ust() {
    let rig = LaserRig::new(LaserOptions {
        profile: LaserProfile::ust_20lx(),
        link: LaserLink::Network,
        ..LaserOptions::default()
    });
    let mut client = LineClient::new(rig, Duration::from_secs(5));
    for (line, status) in [
        ("%ST", "00P"),
        ("TM0", "00P"),
        ("TM1", "00P"),
        ("TM2", "00P"),
    ] {
        assert_eq!(client.ask(line)[1], status);
    }
    for line in ["VV", "PP", "II"] {
        for pair in &client.ask(line)[2..] {
            // It takes KEY:value;sum apart and checks the sum over KEY:value.
            let (body, sum) = pair.split_once(';').expect("a semicolon");
            let total: u32 = body.bytes().map(u32::from).sum();
            assert_eq!(sum, char::from(b'0' + (total % 64) as u8).to_string());
        }
    }
    assert_eq!(client.ask("BM")[1], "00P");
    assert_eq!(client.ask("%ST")[2], "003C");
    let scan = client.ask("GE0000108000");
    let characters: usize = scan[3..].iter().map(|line| line.len() - 1).sum();
    assert_eq!(characters, 1081 * 6);
    assert_eq!(client.ask("ME0000108000003")[1], "00P");
    for left in [2, 1, 0] {
        assert_eq!(client.reply()[0], format!("ME000010800000{left}"));
    }
    assert_eq!(client.ask("%SL")[1], "00P");
    assert_eq!(client.ask("%ST")[2], "005E");
    assert_eq!(client.ask("QT")[1], "00P");
    let mut urg = LineClient::new(LaserRig::idle(), 250 * MS);
    assert_eq!(urg.ask("%ST")[1], "0Ee");
}

/// A client that looks for the end of a stream by silence alone never finds it: between two scans there are some 94 ms
/// (scip2 section 13). This test keeps that gap.
#[test]
fn draining_by_silence_alone_never_ends() {
    let mut client = LineClient::new(LaserRig::new(exact(LaserStartState::Streaming)), 140 * MS);
    for _ in 0..20_000 {
        assert!(client.byte().is_some(), "silence at {:?}", client.rig.now);
    }
}
