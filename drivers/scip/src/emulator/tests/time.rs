//! Stamps, ticks and the timer (scip2 section 8).

use super::*;

#[test]
fn stamps_are_99_or_100_ms_apart() {
    let mut rig = LaserRig::new(LaserOptions {
        start_state: LaserStartState::Streaming,
        ..LaserOptions::default()
    });
    let stamps = stamps(&rig.text(Duration::from_secs(100)));
    let steps: Vec<u32> = stamps.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert!(steps.iter().all(|step| *step == 99 || *step == 100));
    let mean = f64::from(stamps[stamps.len() - 1] - stamps[0]) / steps.len() as f64;
    assert!((mean - 99.88).abs() < 0.01, "{mean}");
    // Against the host: 1000 sensor ms in 998.70 host ms.
    let (first, last) = (
        rig.source.revolutions[0].0,
        rig.source.revolutions[stamps.len() - 1].0,
    );
    let host_ms = (last - first).as_secs_f64() * 1e3;
    let rate = f64::from(stamps[stamps.len() - 1] - stamps[0]) / host_ms;
    assert!((rate - 1.0013).abs() < 2e-5, "{rate}");
}

#[test]
fn the_timer_wraps_under_a_stream() {
    let options = LaserOptions {
        timer_start_ms: (1 << 24) - 250,
        ..exact(LaserStartState::Streaming)
    };
    let text = LaserRig::new(options).text(500 * MS);
    assert_eq!(
        stamps(&text),
        [(1 << 24) - 250, (1 << 24) - 150, (1 << 24) - 50, 50, 150]
    );
}

#[test]
fn time_adjustment_round_trip_takes_about_a_millisecond() {
    let mut rig = LaserRig::new(LaserOptions {
        timer_start_ms: 5_000,
        ..exact(LaserStartState::TimeAdjust)
    });
    for _ in 0..50 {
        rig.run(Duration::from_micros(17_300));
        let sent = rig.now;
        rig.send("TM1\n");
        let outputs = rig.run(5 * MS);
        let trip = outputs[0].at - sent;
        assert!(
            trip >= Duration::from_micros(900) && trip <= Duration::from_micros(1_100),
            "{trip:?}"
        );
        let time_ms = decode(&joined(&outputs).lines().nth(2).expect("a time")[..4]);
        let middle = 5_000.0 + (sent + trip / 2).as_secs_f64() * 1e3;
        assert!(
            (f64::from(time_ms) - middle).abs() <= 1.1,
            "{time_ms} {middle}"
        );
    }
}

#[test]
fn every_first_byte_comes_within_111_ms() {
    let mut rig = LaserRig::new(LaserOptions {
        start_state: LaserStartState::LaserOn,
        ..LaserOptions::default()
    });
    let mut longest = Duration::ZERO;
    for round in 0..200 {
        rig.run(Duration::from_micros(round * 997));
        let sent = rig.now;
        rig.send(if round % 2 == 0 {
            "VV\n"
        } else {
            "GD0044072501\n"
        });
        longest = longest.max(rig.run(130 * MS)[0].at - sent);
    }
    assert!(longest < 111 * MS && longest > 90 * MS, "{longest:?}");
}

#[test]
fn one_command_a_tick_in_order() {
    let mut rig = LaserRig::idle();
    rig.send("VV\nPP\nII\nTM1\nBM\n");
    let outputs = rig.run(1000 * MS);
    let at: Vec<u128> = outputs
        .iter()
        .filter(|output| output.bytes.len() > 5)
        .map(|o| o.at.as_millis() / 10)
        .collect();
    // TM1 needs no tick, but waits for its turn.
    let first_pieces: Vec<u128> = at.into_iter().collect();
    assert_eq!(first_pieces, [9, 19, 29, 29, 39]);
    let order: Vec<String> = messages(&joined(&outputs))
        .into_iter()
        .map(|lines| lines[0].clone())
        .collect();
    assert_eq!(order, ["VV", "PP", "II", "TM1", "BM"]);
}

#[test]
fn the_latest_scan_follows_ii_by_six_ms() {
    let mut rig = LaserRig::new(exact(LaserStartState::LaserOn));
    rig.send("II\nGD0044072501\n");
    let replies = messages(&rig.text(300 * MS));
    let time_ms = replies[0]
        .iter()
        .find_map(|line| line.strip_prefix("TIME:"))
        .expect("a time");
    let time_ms = u32::from_str_radix(&time_ms[..6], 16).expect("hexadecimal");
    assert_eq!(decode(&replies[1][2][..4]), time_ms + 6);
}

#[test]
fn power_comes_back_as_if_new() {
    let mut rig = LaserRig::new(exact(LaserStartState::Streaming));
    rig.run(475 * MS);
    rig.send("VV\nV");
    rig.laser.power_cycle(rig.now);
    assert_eq!(rig.text(Duration::from_secs(2)), "");
    assert_eq!(rig.laser.timer_ms(rig.now), 2000);
    assert_eq!(rig.ask("QT"), "QT\nE\n\n");
    assert_eq!(rig.ask("SCIP2.0"), "SCIP2.0\n0\n\n");
}
