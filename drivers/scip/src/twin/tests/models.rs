//! The relatives of the URG-04LX: UTM-30LX on USB and UST on Ethernet (sections 1, 6 and 10).

use super::*;
use crate::twin::{KeyedSum, Link};

fn ust() -> Bench {
    Bench::new(TwinOptions {
        link: Link::Network,
        ..exact_of(Profile::ust_20lx())
    })
}

fn exact_of(profile: Profile) -> TwinOptions {
    TwinOptions {
        profile,
        ..exact(StartState::PowerUp)
    }
}

#[test]
fn a_utm_says_who_it_is() {
    let mut bench = Bench::of(Profile::utm_30lx());
    assert_eq!(bench.ask("SCIP2.0"), "SCIP2.0\n0Ee\n\n");
    let parameters = bench.ask("PP");
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
    assert!(bench.ask("II").contains("\nSBPS:USB Full Speed;"));
    assert_eq!(bench.status("CR00"), "04");
    assert_eq!(bench.status("SS115200"), "04");
    assert_eq!(bench.status("RT"), "00");
    assert_eq!(bench.status("%ST"), "0E");
    assert_eq!(bench.status("ND0000108001000"), "0E");
}

/// Log L3: the request `ME0000108001101` is acknowledged and its one scan announced as `ME0000108001100`.
#[test]
fn intensity_of_a_utm_as_in_log_l3() {
    let mut bench = Bench::of(Profile::utm_30lx());
    bench.send("ME0000108001101\n");
    let replies = messages(&bench.text(300 * MS));
    assert_eq!(replies.len(), 2);
    assert_eq!(replies[0][..2], ["ME0000108001101", "00P"]);
    assert_eq!(replies[1][..2], ["ME0000108001100", "99b"]);
    let characters: usize = replies[1][3..].iter().map(|line| line.len() - 1).sum();
    assert_eq!(characters, 1081 * 6);
    assert_eq!(bench.room.lengths, [1081]);
    // 1234 mm, and its light 4000 / 1.234^2 = 2626.
    assert!(replies[1][3].starts_with("0CB0Y2"), "{}", replies[1][3]);
    assert!(!bench.twin.laser_on());
}

#[test]
fn forty_scans_a_second_pass_the_link_even_with_intensity() {
    for (profile, link) in [
        (Profile::utm_30lx(), Link::Usb),
        (Profile::ust_20lx(), Link::Network),
    ] {
        let mut bench = Bench::new(TwinOptions {
            link,
            ..exact_of(profile)
        });
        bench.send("ME0000108001000\n");
        bench.run(100 * MS);
        let stamps = stamps(&bench.text(1000 * MS));
        assert_eq!(stamps.len(), 40);
        assert!(stamps.windows(2).all(|pair| pair[1] - pair[0] == 25));
        assert_eq!(bench.twin.lost_replies(), 0);
    }
}

#[test]
fn a_ust_answers_on_ticks_of_a_millisecond() {
    let mut bench = ust();
    for _ in 0..20 {
        bench.run(Duration::from_micros(3_300));
        let sent = bench.now;
        bench.send("VV\n");
        let trip = bench.run(20 * MS)[0].at - sent;
        assert!(trip < 3 * MS, "{trip:?}");
    }
    let version = bench.ask("VV");
    assert!(version.contains("\nPROT:SCIP 2.2;") && version.contains("\nFIRM:1.1.0 (2011-09-30);"));
    assert!(bench.ask("PP").contains("\nPROT:SCIP 2.2;"));
    assert!(
        bench
            .ask("II")
            .contains("\nSTAT:sensor is working normally;")
    );
}

#[test]
fn states_of_a_ust() {
    let mut bench = ust();
    let state = |bench: &mut Bench| {
        let replies = messages(&bench.ask("%ST"));
        let reply = replies.iter().find(|reply| reply[0] == "%ST");
        reply.expect("a reply")[2][..3].to_owned()
    };
    assert_eq!(state(&mut bench), "000");
    assert_eq!(bench.status("BM"), "00");
    assert_eq!(state(&mut bench), "003");
    assert_eq!(bench.status("MD0000108001000"), "00");
    assert_eq!(state(&mut bench), "004");
    assert_eq!(bench.status("TM0"), "10");
    assert_eq!(bench.status("QT"), "00");
    assert_eq!(bench.status("TM0"), "00");
    assert_eq!(state(&mut bench), "002");
    assert_eq!(bench.status("QT"), "10");
    assert_eq!(bench.status("VV"), "00");
    assert_eq!(bench.status("TM2"), "00");
    assert_eq!(bench.status("TM1"), "00", "outside time adjustment too");
    assert_eq!(bench.status("%SL"), "00");
    assert_eq!(state(&mut bench), "005");
    assert_eq!(bench.status("MD0000108001000"), "10");
    assert_eq!(bench.status("BM"), "10");
    assert_eq!(bench.status("QT"), "00");
    assert_eq!(bench.status("BM"), "00");
    for (line, status) in [
        ("SS115200", "0F"),
        ("CR00", "0F"),
        ("HS0", "0E"),
        ("DB10", "0E"),
        ("GD0000", "0H"),
        ("VV1", "0D"),
        ("MD0000108101000", "04"),
    ] {
        assert_eq!(bench.status(line), status, "{line}");
    }
    bench.inject("hardware");
    assert_eq!(state(&mut bench), "900");
}

#[test]
fn two_rb_within_a_second_start_a_ust_anew() {
    let mut bench = ust();
    bench.run(5000 * MS);
    bench.ask("BM");
    assert_eq!(bench.status("RB"), "01");
    bench.run(2000 * MS);
    assert_eq!(bench.status("RB"), "01", "too late to be the second");
    assert_eq!(bench.status("RB"), "00");
    bench.run(1000 * MS);
    assert!(!bench.twin.laser_on());
    assert!(bench.twin.timer_ms(bench.now) < 1000);
}

#[test]
fn several_echoes_of_a_ust() {
    let mut bench = ust();
    bench.ask("BM");
    let reply = bench.ask("HD0540054101");
    assert_eq!(reply.lines().nth(3), Some("0CB0CBZ"));
    let reply = bench.ask("HE0540054001");
    assert_eq!(&reply.lines().nth(3).expect("data")[..6], "0CB0Y2");
    bench.send("NE0540054001102\n");
    let heads: Vec<String> = messages(&bench.text(500 * MS))
        .iter()
        .map(|lines| format!("{} {}", &lines[0][13..], lines[1]))
        .collect();
    assert_eq!(heads, ["02 00P", "01 99b", "00 99b"]);
}

#[test]
fn keyed_sums_of_every_habit_on_record() {
    let line = |keyed_sum| {
        let profile = Profile {
            keyed_sum,
            ..Profile::urg_04lx()
        };
        let mut bench = Bench::new(TwinOptions {
            profile,
            ..exact(StartState::Idle)
        });
        let text = bench.ask("II");
        let line = text.lines().find(|line| line.starts_with("SBPS"));
        line.expect("a bit rate").to_owned()
    };
    let body = "SBPS:19200[bps]<-Default setting by user";
    let sum = |text: &str| {
        let total: u32 = text.bytes().map(u32::from).sum();
        char::from(b'0' + (total % 64) as u8)
    };
    assert_eq!(
        line(KeyedSum::BeforeSemicolon),
        format!("{body};{}", sum(body))
    );
    assert_eq!(
        line(KeyedSum::WithSemicolon),
        format!("{body};{}", sum(&format!("{body};")))
    );
    assert_eq!(
        line(KeyedSum::BeforeComment),
        format!("{body};{}", sum("SBPS:19200[bps]"))
    );
}
