//! The relatives of the URG-04LX: UTM-30LX on USB and UST on Ethernet (scip2 sections 1, 6 and 10).

use super::*;
use crate::emulator::{KeyedSumRule, LaserLink};

fn ust() -> LaserRig {
    LaserRig::new(LaserOptions {
        link: LaserLink::Network,
        ..exact_of(LaserProfile::ust_20lx())
    })
}

fn exact_of(profile: LaserProfile) -> LaserOptions {
    LaserOptions {
        profile,
        ..exact(LaserStartState::PowerUp)
    }
}

#[test]
fn identity_of_a_utm() {
    let mut rig = LaserRig::with_profile(LaserProfile::utm_30lx());
    assert_eq!(rig.ask("SCIP2.0"), "SCIP2.0\n0Ee\n\n");
    let parameters = rig.ask("PP");
    for line in [
        "\nMODL:UTM-30LX(Hokuyo Automatic Co.,Ltd.);",
        "\nDMIN:23;",
        "\nDMAX:60000;",
        "\nARES:1440;",
        "\nAMIN:0;",
        "\nAMAX:1080;",
        "\nAFRT:540;",
        "\nSCAN:2400;",
    ] {
        assert!(parameters.contains(line), "{line} in {parameters}");
    }
    assert!(rig.ask("II").contains("\nSBPS:USB Full Speed;"));
    assert_eq!(rig.status("CR00"), "04");
    assert_eq!(rig.status("SS115200"), "04");
    assert_eq!(rig.status("RT"), "00");
    assert_eq!(rig.status("%ST"), "0E");
    assert_eq!(rig.status("ND0000108001000"), "0E");
}

/// Log L3: the request `ME0000108001101` is acknowledged and its one scan announced as `ME0000108001100`.
#[test]
fn intensity_of_a_utm_as_in_log_l3() {
    let mut rig = LaserRig::with_profile(LaserProfile::utm_30lx());
    rig.send("ME0000108001101\n");
    let replies = messages(&rig.text(300 * MS));
    assert_eq!(replies.len(), 2);
    assert_eq!(replies[0][..2], ["ME0000108001101", "00P"]);
    assert_eq!(replies[1][..2], ["ME0000108001100", "99b"]);
    let characters: usize = replies[1][3..].iter().map(|line| line.len() - 1).sum();
    assert_eq!(characters, 1081 * 6);
    assert_eq!(rig.source.lengths, [1081]);
    // 1234 mm, and its intensity 4000 / 1.234^2 = 2626.
    assert!(replies[1][3].starts_with("0CB0Y2"), "{}", replies[1][3]);
    assert!(!rig.laser.laser_on());
}

#[test]
fn forty_scans_a_second_pass_the_link_even_with_intensity() {
    for (profile, link) in [
        (LaserProfile::utm_30lx(), LaserLink::Usb),
        (LaserProfile::ust_20lx(), LaserLink::Network),
    ] {
        let mut rig = LaserRig::new(LaserOptions {
            link,
            ..exact_of(profile)
        });
        rig.send("ME0000108001000\n");
        rig.run(100 * MS);
        let stamps = stamps(&rig.text(1000 * MS));
        assert_eq!(stamps.len(), 40);
        assert!(stamps.windows(2).all(|pair| pair[1] - pair[0] == 25));
        assert_eq!(rig.laser.lost_replies(), 0);
    }
}

#[test]
fn a_ust_answers_on_ticks_of_a_millisecond() {
    let mut rig = ust();
    for _ in 0..20 {
        rig.run(Duration::from_micros(3_300));
        let sent = rig.now;
        rig.send("VV\n");
        let trip = rig.run(20 * MS)[0].at - sent;
        assert!(trip < 3 * MS, "{trip:?}");
    }
    let version = rig.ask("VV");
    assert!(version.contains("\nPROT:SCIP 2.2;") && version.contains("\nFIRM:1.1.0 (2011-09-30);"));
    assert!(rig.ask("PP").contains("\nPROT:SCIP 2.2;"));
    assert!(rig.ask("II").contains("\nSTAT:sensor is working normally;"));
}

#[test]
fn states_of_a_ust() {
    let mut rig = ust();
    let state = |rig: &mut LaserRig| {
        let replies = messages(&rig.ask("%ST"));
        let reply = replies.iter().find(|reply| reply[0] == "%ST");
        reply.expect("a reply")[2][..3].to_owned()
    };
    assert_eq!(state(&mut rig), "000");
    assert_eq!(rig.status("BM"), "00");
    assert_eq!(state(&mut rig), "003");
    assert_eq!(rig.status("MD0000108001000"), "00");
    assert_eq!(state(&mut rig), "004");
    assert_eq!(rig.status("TM0"), "10");
    assert_eq!(rig.status("QT"), "00");
    assert_eq!(rig.status("TM0"), "00");
    assert_eq!(state(&mut rig), "002");
    assert_eq!(rig.status("QT"), "10");
    assert_eq!(rig.status("VV"), "00");
    assert_eq!(rig.status("TM2"), "00");
    assert_eq!(rig.status("TM1"), "00", "outside time adjustment too");
    assert_eq!(rig.status("%SL"), "00");
    assert_eq!(state(&mut rig), "005");
    assert_eq!(rig.status("MD0000108001000"), "10");
    assert_eq!(rig.status("BM"), "10");
    assert_eq!(rig.status("QT"), "00");
    assert_eq!(rig.status("BM"), "00");
    for (line, status) in [
        ("SS115200", "0F"),
        ("CR00", "0F"),
        ("HS0", "0E"),
        ("DB10", "0E"),
        ("GD0000", "0H"),
        ("VV1", "0D"),
        ("MD0000108101000", "04"),
    ] {
        assert_eq!(rig.status(line), status, "{line}");
    }
    rig.inject("hardware");
    assert_eq!(state(&mut rig), "900");
}

#[test]
fn two_rb_within_a_second_restart_a_ust() {
    let mut rig = ust();
    rig.run(5000 * MS);
    rig.ask("BM");
    assert_eq!(rig.status("RB"), "01");
    rig.run(2000 * MS);
    assert_eq!(rig.status("RB"), "01", "too late to be the second");
    assert_eq!(rig.status("RB"), "00");
    rig.run(1000 * MS);
    assert!(!rig.laser.laser_on());
    assert!(rig.laser.timer_ms(rig.now) < 1000);
}

#[test]
fn several_echoes_of_a_ust() {
    let mut rig = ust();
    rig.ask("BM");
    let reply = rig.ask("HD0540054101");
    assert_eq!(reply.lines().nth(3), Some("0CB0CBZ"));
    let reply = rig.ask("HE0540054001");
    assert_eq!(&reply.lines().nth(3).expect("data")[..6], "0CB0Y2");
    rig.send("NE0540054001102\n");
    let heads: Vec<String> = messages(&rig.text(500 * MS))
        .iter()
        .map(|lines| format!("{} {}", &lines[0][13..], lines[1]))
        .collect();
    assert_eq!(heads, ["02 00P", "01 99b", "00 99b"]);
}

#[test]
fn keyed_sums_by_every_rule() {
    let line = |keyed_sum| {
        let profile = LaserProfile {
            keyed_sum,
            ..LaserProfile::urg_04lx()
        };
        let mut rig = LaserRig::new(LaserOptions {
            profile,
            ..exact(LaserStartState::Idle)
        });
        let text = rig.ask("II");
        let line = text.lines().find(|line| line.starts_with("SBPS"));
        line.expect("a bit rate").to_owned()
    };
    let body = "SBPS:19200[bps]<-Default setting by user";
    let sum = |text: &str| {
        let total: u32 = text.bytes().map(u32::from).sum();
        char::from(b'0' + (total % 64) as u8)
    };
    assert_eq!(
        line(KeyedSumRule::BeforeSemicolon),
        format!("{body};{}", sum(body))
    );
    assert_eq!(
        line(KeyedSumRule::WithSemicolon),
        format!("{body};{}", sum(&format!("{body};")))
    );
    assert_eq!(
        line(KeyedSumRule::BeforeComment),
        format!("{body};{}", sum("SBPS:19200[bps]"))
    );
}
