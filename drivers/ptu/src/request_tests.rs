//! Requests that wait, and when there are none.

use crate::Axis;
use crate::test_rig::PtuTestRig;

#[test]
fn a_request_that_waits_is_started_whatever_ends_the_one_before() {
    // Refused.
    let (mut rig, mut replies) = PtuTestRig::connected();
    rig.driver
        .move_to(Axis::Pan, 9000, rig.now)
        .expect("connected");
    rig.driver
        .set_speed(Axis::Tilt, 97, rig.now)
        .expect("connected");
    assert_eq!(rig.take_sent(), ["PP9000 "]);
    rig.feed(b"! Maximum allowable Pan position is 3090\r\n");
    assert_eq!(rig.take_sent(), ["TS97 "]);
    rig.feed(b"*\r\n");

    // Made while the line is drained after an unsolicited line.
    rig.take_sent();
    rig.feed(b"* 5\r\n");
    rig.driver
        .set_speed(Axis::Tilt, 98, rig.now)
        .expect("connected");
    assert_eq!(rig.next_send(), " ");
    assert_eq!(rig.next_send(), "TS98 ");
    rig.feed(b"*\r\n");

    // Made during a calibration, and during the reading of the limits after it.
    rig.take_sent();
    rig.driver.reset(rig.now).expect("connected");
    assert_eq!(rig.next_send(), "R ");
    rig.driver
        .set_speed(Axis::Tilt, 99, rig.now)
        .expect("connected");
    rig.feed(b"!T!T!P!P*\r\n");
    rig.driver
        .set_speed(Axis::Pan, 100, rig.now)
        .expect("connected");
    let seen = rig.answer_all(&mut replies);
    assert_eq!(seen[seen.len() - 2..], ["TS99", "PS100"]);

    // A calibration that failed.
    rig.driver.reset(rig.now).expect("connected");
    rig.driver
        .set_speed(Axis::Tilt, 31, rig.now)
        .expect("connected");
    assert_eq!(rig.take_sent(), ["R "]);
    rig.feed(b"!T! Axis Error\r\n");
    assert_eq!(rig.take_sent(), ["TS31 "]);
    assert_eq!(rig.driver.pending(), 1);
}

#[test]
fn a_driver_is_idle_while_nothing_is_sent_awaited_half_read_or_reported() {
    let (mut rig, _) = PtuTestRig::connected();
    assert!(rig.driver.is_idle());
    rig.driver
        .poll_position(Axis::Pan, rig.now)
        .expect("connected");
    assert!(!rig.driver.is_idle(), "to be sent");
    rig.take_sent();
    assert!(!rig.driver.is_idle(), "awaited");
    rig.feed(b"* 5\r");
    assert!(!rig.driver.is_idle(), "to be reported");
    rig.take_sent();
    assert!(rig.driver.is_idle());
    rig.feed(b"*");
    assert!(!rig.driver.is_idle(), "half read");
    rig.feed(b"\r\n");
    assert!(!rig.driver.is_idle(), "drained");
}

#[test]
fn a_request_of_an_idle_driver_goes_out_at_once() {
    let (mut rig, _) = PtuTestRig::connected();
    rig.driver.halt(rig.now).expect("connected");
    assert_eq!(rig.take_sent(), ["H "]);
    rig.feed(b"*\r\n");
    rig.driver.reset(rig.now).expect("connected");
    assert_eq!(rig.take_sent(), ["R "]);
}
