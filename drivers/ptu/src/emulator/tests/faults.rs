//! Injected faults of motion, line, settings, power and calibration.

use super::{Host, options};
use crate::emulator::HeadOptions;

#[test]
fn lost_steps_do_not_show_in_the_reported_position() {
    let mut host = Host::new(options());
    host.inject("lost-steps:axis=tilt,steps=15,at=0.5,count=2,every=0.1");
    host.send("TP400 ");
    host.wait(2.0);
    assert_eq!((host.number("TP "), host.truth()), (400, (0.0, 430.0)));
}

#[test]
fn stuck_and_slow_axes() {
    let mut host = Host::new(options());
    host.inject("stuck:axis=tilt,at=0.2,for=1");
    host.send("TP400 ");
    host.wait(1.0);
    assert!(host.number("TP ") < 210 && host.head.moving());
    host.wait(1.0);
    assert_eq!((host.number("TP "), host.truth().1), (400, 400.0));
    host.inject("stuck:axis=tilt,hidden=true,for=1");
    host.send("TP0 ");
    host.wait(2.0);
    assert_eq!((host.number("TP "), host.truth().1), (0, 400.0));
    let mut host = Host::new(options());
    host.inject("slow:axis=pan,factor=0.5");
    host.send("PP1000 ");
    host.wait(1.0);
    let at = host.number("PP ");
    assert!((490..=560).contains(&at), "{at}");
    host.wait(1.5);
    assert_eq!(host.number("PP "), 1000);
}

#[test]
fn noise_on_the_line() {
    let mut host = Host::new(options());
    host.inject("event:which=D,at=1");
    host.inject("text:text=hello world,at=2");
    host.wait(0.5);
    assert_eq!(host.wait(1.0), "!D");
    assert_eq!(host.wait(1.0), "hello world\r\n");
    host.inject("lost-byte:skip=2,count=1");
    assert_eq!(host.ask("PN "), "* 3090\r\n");
    host.inject("garbage-byte");
    let reply = host.ask("PN ");
    assert!(
        !reply.starts_with('*') && reply.ends_with(" -3090\r\n"),
        "{reply:?}"
    );
    assert_eq!(host.ask("PN "), "* -3090\r\n");
    host.inject("silence:for=1");
    assert_eq!(host.ask("PP10 "), "");
    host.wait(1.0);
    assert_eq!(host.ask("PP "), "* 10\r\n", "it received");
    host.inject("silence:deaf=true,for=1");
    assert_eq!(host.ask("PP20 "), "");
    host.wait(1.0);
    assert_eq!(host.ask("PP "), "* 10\r\n", "it did not receive");
    host.inject("wrong-baud:for=0.5");
    assert_ne!(host.ask("PP "), "* 10\r\n");
    host.wait(1.0);
    host.ask(" ");
    assert_eq!(host.ask("PP "), "* 10\r\n");
}

#[test]
fn echo_verbose_and_power_cycle_faults_undo_settings() {
    let mut host = Host::new(options());
    host.inject("echo");
    host.inject("verbose");
    assert_eq!(host.ask("PP "), "PP * Current Pan position is 0\r\n");
    host.ask("ED FT ");
    host.inject("power-cycle:for=2");
    assert_eq!(host.ask("PP "), "");
    host.wait(1.0);
    assert!(host.wait(60.0).ends_with("Initializing...!T!T!P!P*\r\n"));
    assert_eq!(
        host.ask("PP "),
        "PP * Current Pan position is 0\r\n",
        "nothing had been saved"
    );
}

#[test]
fn calibration_fails_and_recovers() {
    let mut host = Host::new(HeadOptions {
        e_series: true,
        ..options()
    });
    host.inject("reset-fails");
    host.send("R ");
    assert_eq!(host.wait(60.0), "! Reset failed\r\n");
    assert_eq!(host.ask("PP10 "), "! Axis Error\r\n");
    host.send("R ");
    assert_eq!(host.wait(60.0), "!T!T!P!P*\r\n");
    for fault in [
        "stuck:axis=pan,for=100",
        "stuck:axis=pan,hidden=true,for=100",
    ] {
        host.inject(fault);
        host.send("R ");
        assert_eq!(host.wait(101.0), "!T!T! Reset failed\r\n", "{fault}");
    }
    host.send("R ");
    assert_eq!(host.wait(60.0), "!T!T!P!P*\r\n");
}
