//! The PTU driver alone: any bytes and any request at any time.

use super::choices::{Choices, chunk};
use ptu::{Axis, PtuAction, PtuDriver, PtuEvent, PtuOptions};
use std::time::Duration;

/// Actions that one input may cause.
const MAX_ACTIONS: usize = 1024;
/// Commands that may wait, the longest script included.
const MAX_PENDING: usize = 128;

pub(crate) fn run(data: &[u8]) {
    let mut choices = Choices(data);
    let mut driver = PtuDriver::new(PtuOptions {
        network_rescue: choices.byte() & 1 == 1,
        ..PtuOptions::default()
    });
    let mut now = Duration::ZERO;
    driver.connect(now);
    while !choices.is_over() {
        let axis = choices.one_of(&Axis::BOTH);
        let number = i32::from(choices.byte()) * 40 - 5000;
        match choices.byte() % 16 {
            0 => driver.connect(now),
            1 => {
                let _ = driver.reset(now);
            }
            2 => {
                let _ = driver.set_speed(axis, number, now);
            }
            3 => {
                let _ = driver.move_to(axis, number, now);
            }
            4 => {
                let _ = driver.poll_position(axis, now);
            }
            5 => {
                let _ = driver.halt(now);
            }
            6 => {
                let _ = driver.query_health(now);
            }
            7 => {
                let _ = driver.hold_power_low(now);
            }
            8 | 9 => {
                now += choices.duration();
                driver.handle_deadline(now);
            }
            10 => {
                now = driver.deadline().unwrap_or(now).max(now);
                driver.handle_deadline(now);
            }
            _ => driver.handle_bytes(choices.chunk(), now),
        }
        assert!(driver.pending() <= MAX_PENDING, "{} wait", driver.pending());
        for count in 0.. {
            assert!(count < MAX_ACTIONS, "outputs without end");
            match driver.poll_action() {
                None => break,
                Some(PtuAction::Event(PtuEvent::Position {
                    sent_at,
                    first_byte_at,
                    ..
                })) => {
                    assert!(sent_at <= first_byte_at && first_byte_at <= now);
                }
                Some(_) => {}
            }
        }
    }
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
    let receive = |text: &str| {
        let mut op = vec![0, 0, 15];
        op.extend(chunk(text.as_bytes()));
        op
    };
    let pass = vec![0, 0, 10];
    let replies = [
        "ED *\r\n",
        "*\r\n",
        "* Pan-Tilt Controller v2.12.1d1(C14/E), (C)2003 Directed Perception, Inc.\r\n",
        "*\r\n",
        "*\r\n",
        "*\r\n",
        "*\r\n",
        "* Echoing OFF\r\n",
        "* ASCII terse mode\r\n",
        "* independent (default) speed control mode\r\n",
        "* Limit bounds are ENABLED (soft limits enabled)\r\n",
        "* 185.1428\r\n",
        "* 185.1428\r\n",
        "* -3090\r\n",
        "* -907\r\n",
        "* 3091\r\n",
        "* 604\r\n",
        "* 31\r\n",
        "* 31\r\n",
        "* 2902\r\n",
        "* 2902\r\n",
        "* 1000\r\n",
        "* 1000\r\n",
        "* 2000\r\n",
        "* 2000\r\n",
        "* 1000\r\n",
        "* 1000\r\n",
        "* Input 30 VDC @ 86 degF\r\n",
    ];
    let mut connected = [vec![0], pass.clone()].concat();
    connected.extend(replies.iter().flat_map(|text| receive(text)));
    let mut moving = connected.clone();
    moving.extend([1, 130, 3]);
    moving.extend(receive("*\r\n"));
    moving.extend([1, 130, 4]);
    moving.extend(receive("* 4!T0\r\n"));
    moving.extend([0, 0, 1]);
    moving.extend(receive("!T!T!P!P*\r\n"));
    let banner = "\r\n\r\n### PAN-TILT CONTROLLER\r\n### v2.12\r\nInitializing...!T!T!P!P*\r\n";
    vec![connected, moving, [vec![0], pass, receive(banner)].concat()]
}
