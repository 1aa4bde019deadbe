//! Faults caused by another program, a worn gear or a weak supply (ptu-d46 section 14).

use super::{Host, options};
use crate::emulator::HeadOptions;

#[test]
fn modes_set_by_another_program() {
    let mut host = Host::new(options());
    host.inject("velocity:at=1");
    host.wait(0.5);
    assert_eq!(
        host.ask("C "),
        "* independent (default) speed control mode\r\n"
    );
    host.wait(1.0);
    assert_eq!(host.ask("C "), "* pure velocity speed control mode\r\n");
    assert!(
        host.head.moving(),
        "the old speed starts a motion (ptu-d46 section 6)"
    );
    assert_eq!(host.ask("H CI "), "*\r\n*\r\n");
    host.inject("slaved");
    assert_eq!(host.ask("PP100 "), "*\r\n");
    host.wait(2.0);
    assert_eq!(host.truth().0, f64::from(host.number("PP ")));
    assert!(!host.head.moving(), "held back");
    assert_eq!(host.ask("I "), "*\r\n");
    host.wait(5.0);
    assert_eq!(host.number("PP "), 100);
    host.inject("limits-off");
    assert_eq!(
        host.ask("L "),
        "* Limit bounds are DISABLED (hard limits only: use care)\r\n"
    );
    assert_eq!(host.ask("PP3095 "), "*\r\n");
    host.inject("moving:pan=0,tilt=-50");
    host.wait(10.0);
    assert_eq!((host.number("PP "), host.number("TP ")), (0, -50));
    host.inject("monitor");
    host.wait(1.0);
    assert!(host.head.moving());
    assert_eq!(host.ask(" "), "");
    host.wait(10.0);
    assert_eq!(host.truth(), (0.0, 0.0), "any character sends it home");
}

#[test]
fn another_network_id_and_another_rate_silence_it() {
    let mut host = Host::new(options());
    host.inject("unit-id:id=9");
    assert_eq!(host.ask("PP "), "");
    assert_eq!(host.ask(" _0 U0 "), "*\r\n");
    assert_eq!(host.ask("PP U "), "* 0\r\n* 0\r\n");
    host.head.set_host_baud(Some(9600));
    host.inject("baud:rate=38400");
    assert_ne!(host.ask("PP "), "* 0\r\n");
    host.head.set_host_baud(Some(38_400));
    host.ask(" ");
    assert_eq!(host.ask("PP "), "* 0\r\n");
}

#[test]
fn an_event_in_the_middle_of_a_reply() {
    let mut host = Host::new(options());
    host.inject("event:which=T,within=4");
    assert_eq!(host.ask("PN "), "* -3!T090\r\n");
    assert_eq!(host.ask("PN "), "* -3090\r\n");
    host.inject("event:which=P,within=2,count=2");
    assert_eq!(host.ask("TX "), "* !P60!P4\r\n");
}

#[test]
fn an_axis_that_overshoots_comes_back() {
    let mut host = Host::new(options());
    host.inject("overshoot:axis=tilt,steps=15,for=10");
    host.send("TP200 PP100 ");
    let (mut highest, mut widest) = (0, 0);
    for _ in 0..600 {
        host.wait(0.001);
        highest = highest.max(host.truth().1 as i32);
        widest = widest.max(host.truth().0 as i32);
    }
    assert_eq!((highest, widest), (215, 100));
    assert_eq!((host.number("TP "), host.truth().1), (200, 200.0));
    host.wait(10.0);
    host.send("TP0 ");
    host.wait(0.1);
    assert_eq!(host.ask("H "), "*\r\n");
    let stopped = host.number("TP ");
    host.wait(1.0);
    assert_eq!(host.number("TP "), stopped);
}

#[test]
fn the_supply_sags_and_the_motors_heat_for_a_while() {
    let mut host = Host::new(options());
    assert_eq!(host.ask("O "), "* 24.0,86,90,88\r\n");
    host.inject("supply:volts=19.5,degf=151,for=5");
    assert_eq!(host.ask("O "), "* 19.5,151,151,151\r\n");
    assert_eq!(host.ask("FV O "), "*\r\n* Input 20 VDC @ 151 degF\r\n");
    host.wait(5.0);
    assert_eq!(host.ask("FT O "), "*\r\n* 24.0,86,90,88\r\n");
}

#[test]
fn axes_that_lost_their_calibration() {
    let mut host = Host::new(HeadOptions {
        e_series: true,
        ..options()
    });
    host.inject("axis-error");
    assert_eq!(host.ask("PP10 "), "! Axis Error\r\n");
    host.send("R ");
    assert_eq!(host.wait(60.0), "!T!T!P!P*\r\n");
    assert_eq!(host.ask("PP10 "), "*\r\n");
}
