//! The head's driver alone: any bytes at any instant, any request at any time.

use super::feed::{Feed, piece};
use ptu::{Action, Axis, Event, Head, HeadOptions};
use std::time::Duration;

/// Outputs that one input may cause.
const MOST_ACTIONS: usize = 1024;
/// Commands that may wait, with a script of the longest kind before them.
const MOST_PENDING: usize = 128;

pub fn run(data: &[u8]) {
    let mut feed = Feed(data);
    let mut head = Head::new(HeadOptions {
        network_rescue: feed.byte() & 1 == 1,
        ..HeadOptions::default()
    });
    let mut now = Duration::ZERO;
    head.connect(now);
    while !feed.is_over() {
        let axis = feed.one_of(&Axis::BOTH);
        let number = i32::from(feed.byte()) * 40 - 5000;
        match feed.byte() % 16 {
            0 => head.connect(now),
            1 => {
                let _ = head.reset(now);
            }
            2 => {
                let _ = head.set_speed(axis, number, now);
            }
            3 => {
                let _ = head.move_to(axis, number, now);
            }
            4 => {
                let _ = head.poll_position(axis, now);
            }
            5 => {
                let _ = head.halt(now);
            }
            6 => {
                let _ = head.query_health(now);
            }
            7 => {
                let _ = head.hold_power_low(now);
            }
            8 | 9 => {
                now += feed.time();
                head.handle_deadline(now);
            }
            10 => {
                now = head.deadline().unwrap_or(now).max(now);
                head.handle_deadline(now);
            }
            _ => head.handle_bytes(feed.piece(), now),
        }
        assert!(head.pending() <= MOST_PENDING, "{} wait", head.pending());
        let connected = head.is_connected();
        for count in 0.. {
            assert!(count < MOST_ACTIONS, "outputs without end");
            match head.poll_action() {
                None => break,
                Some(Action::Event(Event::Position {
                    sent_at,
                    first_byte_at,
                    ..
                })) => {
                    assert!(sent_at <= first_byte_at && first_byte_at <= now);
                }
                Some(_) => {}
            }
        }
        assert!(connected || !head.position_trusted());
    }
}

pub fn seeds() -> Vec<Vec<u8>> {
    let say = |text: &str| {
        let mut op = vec![0, 0, 15];
        op.extend(piece(text.as_bytes()));
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
    connected.extend(replies.iter().flat_map(|text| say(text)));
    let mut moving = connected.clone();
    moving.extend([1, 130, 3]);
    moving.extend(say("*\r\n"));
    moving.extend([1, 130, 4]);
    moving.extend(say("* 4!T0\r\n"));
    moving.extend([0, 0, 1]);
    moving.extend(say("!T!T!P!P*\r\n"));
    let banner = "\r\n\r\n### PAN-TILT CONTROLLER\r\n### v2.12\r\nInitializing...!T!T!P!P*\r\n";
    vec![connected, moving, [vec![0], pass, say(banner)].concat()]
}
