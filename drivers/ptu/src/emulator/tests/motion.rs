//! Motion as commands report it and as the rotor makes it.

use super::{Host, options, seconds};
use crate::emulator::HeadOptions;

fn instant() -> HeadOptions {
    HeadOptions {
        latency: [seconds(0.0); 2],
        ..options()
    }
}

/// Time from now until the axes stop.
fn run(host: &mut Host) -> f64 {
    let start = host.now;
    while host.head.moving() {
        let next = host.head.next_event().expect("a motion ends");
        host.now = next;
        host.head.advance(next);
        host.drain();
    }
    (host.now - start).as_secs_f64()
}

#[test]
fn closed_form_durations() {
    let mut host = Host::new(instant());
    host.ask("PS1900 ");
    host.send("PP2600 ");
    assert!((run(&mut host) - (0.9 + 1295.0 / 1900.0)).abs() < 1e-6);
    assert_eq!(host.number("PP "), 2600);
    host.ask("TS97 ");
    host.send("TP-485 ");
    assert!(
        (run(&mut host) - 5.0).abs() < 1e-6,
        "below base speed no ramp"
    );
}

#[test]
fn whole_steps_at_a_sweeps_pace_and_the_past() {
    let mut host = Host::new(instant());
    host.ask("TS97 ");
    let start = host.now;
    host.send("TP400 ");
    host.wait(1.5);
    let mut last = 0.0;
    for i in 0..1500 {
        let t = f64::from(i) * 1e-3;
        let (pan, tilt) = host.head.true_position_at(start + seconds(t));
        assert!(pan == 0.0 && tilt.fract() == 0.0 && tilt >= last && tilt - last <= 1.0);
        assert!((tilt - 97.0 * t).abs() <= 0.5 + 1e-6, "t={t} tilt={tilt}");
        last = tilt;
    }
    assert_eq!(
        host.head.true_position_at(host.now + seconds(9.0)),
        host.truth(),
        "the future is not known"
    );
    host.wait(30.0);
    assert_eq!(host.truth(), (0.0, 400.0));
    let degrees = host.head.true_degrees_at(host.now).1;
    assert!((degrees - 400.0 * 0.9 / 17.5).abs() < 1e-9);
}

#[test]
fn speed_and_target_change_on_the_fly() {
    let mut host = Host::new(HeadOptions {
        base_speed: [57, 57],
        ..instant()
    });
    host.send("PS2000 PP3000 ");
    host.wait(1.0);
    assert!((1900..=2000).contains(&host.number("PD ")));
    let here = host.number("PP ");
    host.send("PP-500 ");
    let took = run(&mut host);
    assert_eq!(host.number("PP "), -500);
    // Brakes over 1000 counts, then all the way back.
    let top = f64::from(here) + 1000.0;
    assert!(took > (top + 500.0) / 2000.0 + 1.0, "{took}");
    host.ask("PP3000 ");
    host.wait(1.0);
    assert_eq!(host.ask("PS500 "), "*\r\n");
    host.wait(1.0);
    assert_eq!(host.number("PD "), 500);
    assert_eq!(host.ask("PO "), "* 3000\r\n");
    assert_eq!(host.ask("PO-50 "), "*\r\n", "relative to where it is now");
    assert!(host.number("PO ") < 3000);
}

#[test]
fn halt_decelerates_and_becomes_the_target() {
    let mut host = Host::new(HeadOptions {
        base_speed: [57, 57],
        ..instant()
    });
    host.send("PS2000 PP3000 ");
    host.wait(1.2);
    let before = host.number("PP ");
    assert_eq!(host.ask("H "), "*\r\n");
    host.wait(3.0);
    let (stop, target) = (host.number("PP "), host.number("PO "));
    assert_eq!(stop, target);
    assert!(
        stop - before > 900 && stop - before < 1300,
        "{before} -> {stop}"
    );
    host.ask("TS50 TP500 ");
    host.wait(0.2);
    assert_eq!(host.ask("HT "), "*\r\n");
    let stop = host.number("TP ");
    assert!(
        (stop - host.truth().1 as i32).abs() == 0 && !host.head.moving(),
        "below base it stops at once"
    );
}

#[test]
fn slaved_axes_start_together_and_await_blocks() {
    let mut o = instant();
    o.start.slaved = true;
    let mut host = Host::new(o);
    assert_eq!(host.ask("PP1000 TP500 "), "*\r\n*\r\n");
    host.wait(1.0);
    assert_eq!(host.truth(), (0.0, 0.0));
    assert_eq!(host.ask("PO PP "), "* 1000\r\n* 0\r\n");
    let start = host.now;
    assert_eq!(host.ask("A PP "), "");
    assert_eq!(
        host.head.true_position_at(start + seconds(0.05)),
        (50.0, 50.0)
    );
    assert_eq!(host.wait(0.5), "");
    assert_eq!(host.wait(0.5), "*\r\n* 1000\r\n");
    host.ask("PP0 ");
    assert!(!host.head.moving());
    host.ask("I ");
    assert!(host.head.moving(), "I starts what was held back");
}

#[test]
fn velocity_mode_ends_at_limits() {
    let mut host = Host::new(instant());
    host.ask("PS0 ");
    assert_eq!(
        host.ask("H TS0 PS200 CV "),
        "*\r\n! Tilt speed cannot be less than 31 positions/sec\r\n*\r\n*\r\n"
    );
    host.ask("TS0 PS-300 ");
    host.wait(1.0);
    assert_eq!(host.number("PD "), -300);
    host.ask("PS0 ");
    assert!(host.number("PD ") == 0 && host.number("PP ") < -250);
    host.ask("PS2000 ");
    assert_eq!(host.wait(10.0), "", "limits are on: no event");
    assert_eq!((host.number("PP "), host.head.moving()), (3090, false));
    host.ask("LD PS100 ");
    assert_eq!(host.wait(5.0), "!P");
    assert!(!host.head.moving());
    assert_eq!(host.truth().0, 3102.0);
    host.ask("PS-1000 CI LE ");
    assert_eq!(host.ask("PP0 "), "*\r\n");
    host.wait(5.0);
    assert_eq!(
        host.truth().0,
        0.0,
        "velocity mode stops at the stop without losing steps"
    );
}

#[test]
fn beyond_the_stops_steps_are_lost_until_reset() {
    let mut host = Host::new(instant());
    assert_eq!(
        host.ask("TP700 "),
        "! Maximum allowable Tilt position is 604\r\n"
    );
    assert_eq!(host.ask("LD TP700 "), "*\r\n*\r\n");
    assert_eq!(host.wait(1.0), "!T");
    assert_eq!((host.number("TP "), host.truth().1), (700, 616.0));
    host.ask("TP0 ");
    host.wait(2.0);
    assert_eq!(
        (host.number("TP "), host.truth().1),
        (0, -84.0),
        "84 steps are lost"
    );
    assert_eq!(host.ask("TP40000 "), "! Illegal command\r\n");
    host.send("R ");
    assert_eq!(host.wait(60.0), "!T!T!P!P*\r\n");
    assert_eq!((host.number("TP "), host.truth().1), (0, 0.0));
}

#[test]
fn monitor_scans_until_any_character() {
    let mut host = Host::new(instant());
    assert_eq!(host.ask("M-200,200,-50,50 "), "*\r\n");
    host.wait(0.3);
    let mut seen = (0.0_f64, 0.0_f64);
    for _ in 0..200 {
        host.wait(0.01);
        seen = (seen.0.min(host.truth().0), seen.1.max(host.truth().0));
    }
    assert_eq!(seen, (-200.0, 200.0));
    host.send(" ");
    host.wait(1.0);
    assert_eq!((host.truth(), host.head.moving()), ((0.0, 0.0), false));
    host.ask("M ");
    host.wait(0.1);
    assert!(host.head.moving());
    host.send("PP ");
    host.wait(1.0);
    assert!(!host.head.moving());
    host.ask("M0,0 ");
    host.wait(5.0);
    assert_eq!(
        host.ask("M-4000,0 "),
        "! Minimum allowable Pan position is -3090\r\n"
    );
}

#[test]
fn presets_go_where_they_were_stored() {
    let mut host = Host::new(instant());
    host.send("PP120 TP-30 A XS1 PP0 TP0 A ");
    host.wait(3.0);
    assert_eq!(host.truth(), (0.0, 0.0));
    host.send("XG1 ");
    host.wait(1.0);
    assert_eq!(host.truth(), (120.0, -30.0));
}
