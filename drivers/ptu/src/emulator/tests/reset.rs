//! Calibration and power-up.

use super::{Host, options};
use crate::emulator::{HeadOptions, InputDuringReset};

#[test]
fn r_prints_an_event_at_each_stop_as_it_is_reached() {
    let mut host = Host::new(options());
    let mut o = options();
    o.start.echo = true;
    assert_eq!(Host::new(o).ask("R "), "R ");
    host.send("R ");
    let mut events = Vec::new();
    while host.now.as_secs_f64() < 30.0 {
        let text = host.wait(0.01);
        if !text.is_empty() {
            events.push((text, host.now.as_secs_f64(), host.truth()));
        }
    }
    let texts: Vec<&str> = events.iter().map(|e| e.0.as_str()).collect();
    assert_eq!(texts, ["!T", "!T", "!P", "!P", "*\r\n"]);
    // From 0,0 at 1000 pos/s: 919, 1535, 3102, 6204, 3102 counts.
    for (event, at) in events.iter().zip([0.919, 2.454, 5.556, 11.760, 14.862]) {
        assert!((event.1 - at).abs() < 0.03, "{event:?} expected at {at}");
    }
    assert_eq!(events[1].2.1, 616.0);
    assert_eq!(host.truth(), (0.0, 0.0));
}

#[test]
fn limits_move_by_a_few_counts_and_repeat_with_the_seed() {
    let measure = |seed| {
        let mut host = Host::new(HeadOptions {
            seed,
            limit_spread_steps: 4,
            ..options()
        });
        let mut all = Vec::new();
        for _ in 0..4 {
            all.push((host.number("PN "), host.number("TX ")));
            host.send("R ");
            host.wait(30.0);
        }
        all
    };
    let (a, b) = (measure(1), measure(1));
    assert_eq!(a, b);
    assert_ne!(a, measure(2));
    assert!(
        a.iter()
            .all(|(n, x)| (n + 3090).abs() <= 4 && (x - 604).abs() <= 4)
    );
    assert!(a.windows(2).any(|w| w[0] != w[1]));
}

#[test]
fn input_during_reset_is_queued_or_dropped() {
    for (input, expected) in [
        (InputDuringReset::Queued, "!T!T!P!P*\r\n* 0\r\n"),
        (InputDuringReset::Dropped, "!T!T!P!P*\r\n"),
    ] {
        let mut host = Host::new(HeadOptions {
            input_during_reset: input,
            ..options()
        });
        host.send("R ");
        let mut text = host.wait(1.0);
        host.send("PP ");
        text += &host.wait(60.0);
        assert_eq!(text, expected);
    }
}

#[test]
fn power_up_prints_a_banner_and_calibrates() {
    let mut host = Host::new(HeadOptions {
        power_up: true,
        ..options()
    });
    let text = host.wait(60.0);
    assert!(
        text.starts_with("\r\n\r\n### PAN-TILT CONTROLLER\r\n### v2.12.1d1(C14/E), (C)2003"),
        "{text}"
    );
    assert!(text.ends_with("\r\nInitializing...!T!T!P!P*\r\n"), "{text}");
    assert_eq!(
        host.ask("E "),
        "* Echoing OFF\r\n",
        "the start state of a unit being switched on is what was saved"
    );
}

#[test]
fn power_cycle_loses_what_was_not_saved() {
    let mut host = Host::new(options());
    host.ask("ED FT RD PS500 DS PS97 PP300 ");
    host.wait(5.0);
    host.head.power_cycle(host.now);
    let text = host.wait(1.0);
    assert!(text.ends_with("Initializing...*\r\n"), "{text}");
    assert_eq!(host.ask("PS PP "), "* 500\r\n* 0\r\n");
    assert_eq!(host.truth().0, 300.0, "the head stays, the unit calls it 0");
    host.send("R ");
    host.wait(60.0);
    assert_eq!(host.truth().0, 0.0);
}
