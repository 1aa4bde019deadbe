//! Third-party programs with the habits of ptu-d46 sections 2, 11 and 12, played against the emulator.

use super::Host;
use crate::emulator::{HeadOptions, LineEnd};

/// A terminal read in canonical mode without mapping of CR, as by the drivers of Player and ROS: a line ends with LF and keeps
/// its CR.
struct LfClient {
    host: Host,
    received: String,
}

impl LfClient {
    fn new(options: HeadOptions) -> Self {
        Self {
            host: Host::new(options),
            received: String::new(),
        }
    }

    fn send(&mut self, text: &str) {
        self.host.send(text);
    }

    /// A line with its LF, if one comes in time.
    fn line(&mut self, timeout_s: f64) -> Option<String> {
        let end = self.host.now.as_secs_f64() + timeout_s;
        while !self.received.contains('\n') && self.host.now.as_secs_f64() < end {
            self.received += &self.host.wait(0.005);
        }
        let at = self.received.find('\n')?;
        Some(self.received.drain(..=at).collect())
    }
}

/// Player's driver: echo off, terse, then one line per query; each must end with LF within half a second.
#[test]
fn the_player_driver_needs_the_line_feed() {
    let mut client = LfClient::new(HeadOptions::default());
    client.send("   ");
    client.host.wait(0.3);
    client.send("ED ");
    assert_eq!(client.line(0.5).as_deref(), Some("ED *\r\n"));
    for command in ["FT ", "I "] {
        client.send(command);
        assert_eq!(client.line(0.5).as_deref(), Some("*\r\n"), "{command}");
    }
    for (query, reply) in [
        ("TR ", "* 185.1428\r\n"),
        ("PR ", "* 185.1428\r\n"),
        ("PU ", "* 2902\r\n"),
    ] {
        client.send(query);
        assert_eq!(client.line(0.5).as_deref(), Some(reply), "{query}");
    }
    // With CR alone, as the manual has it, such a client waits for ever.
    let mut waiting = LfClient::new(HeadOptions {
        line_end: LineEnd::Cr,
        ..HeadOptions::default()
    });
    waiting.send("ED ");
    assert_eq!(waiting.line(2.0), None);
}

/// After its reset the ROS driver reads exactly the nine bytes `!T!T!P!P*` and leaves CR LF: from then on every answer is one too
/// early for it (ptu-d46 section 12, first row). The emulator reproduces this.
#[test]
fn the_ros_driver_reads_nine_bytes_after_its_reset() {
    let mut client = LfClient::new(HeadOptions::default());
    client.send("ED FT ");
    client.host.wait(1.0);
    client.send("R ");
    let text = client.host.wait(60.0);
    assert_eq!(text, "!T!T!P!P*\r\n");
    client.received = text[9..].to_owned();
    client.send("PP ");
    assert_eq!(
        client.line(0.5).as_deref(),
        Some("\r\n"),
        "the rest of the reset"
    );
    assert_eq!(client.line(0.5).as_deref(), Some("* 0\r\n"));
}

/// The ROS driver's initialisation in one write, as recorded on an E series with echo on: a reply per command.
#[test]
fn several_commands_in_one_write() {
    let mut client = LfClient::new(HeadOptions::default());
    client.send("ED FT I CI ");
    let lines: Vec<String> = (0..4).filter_map(|_| client.line(0.5)).collect();
    assert_eq!(lines, ["ED *\r\n", "*\r\n", "*\r\n", "*\r\n"]);
    client.send("PN PX TN TX ");
    for limit in ["* -3", "* 30", "* -9", "* 60"] {
        let line = client.line(0.5).expect("a line");
        assert!(line.starts_with(limit) && line.ends_with("\r\n"), "{line}");
    }
}

/// A client halts, enters velocity mode, sets both speeds to 0 and restores them after `CI` (ptu-d46 section 6): nothing moves, and
/// signed speeds work. Another ends its commands with CR LF.
#[test]
fn a_velocity_client_that_zeroes_first_and_one_that_ends_with_cr_lf() {
    let mut client = LfClient::new(HeadOptions::default());
    client.send("ED FT ");
    client.host.wait(1.0);
    client.send("H CV PS0 TS0 ");
    client.host.wait(1.0);
    assert!(!client.host.head.moving());
    client.send("PS-300 ");
    client.host.wait(2.0);
    let pan = client.host.truth().0;
    assert!((-700.0..=-400.0).contains(&pan), "{pan}");
    client.send("PS0 CI PS1000 TS1000 ");
    client.host.wait(1.0);
    assert!(!client.host.head.moving());
    client.received.clear();
    client.send("EE\r\n");
    assert_eq!(client.line(0.5).as_deref(), Some("*\r\n"));
    client.send("TP\r\n");
    assert_eq!(client.line(0.5).as_deref(), Some("TP\r\n"));
    let reply = client.line(0.5).expect("a reply");
    assert!(
        reply.starts_with("* ") && reply.ends_with("\r\n"),
        "{reply}"
    );
}

/// A client that polls positions during a move reads one line each, in order, at most about eighty per second at 9600 baud
/// (ptu-d46 section 1).
#[test]
fn polling_at_the_pace_of_the_line() {
    let mut client = LfClient::new(HeadOptions::default());
    client.send("ED FT ");
    client.host.wait(1.0);
    client.send("PS500 PP1000 ");
    client.host.wait(0.2);
    let (mut polls, mut last) = (0, -1);
    let end = client.host.now.as_secs_f64() + 1.0;
    while client.host.now.as_secs_f64() < end {
        client.send("PP ");
        let line = client.line(0.5).expect("a reply");
        let position = line.trim().trim_start_matches("* ").parse::<i32>();
        let position = position.expect("a number alone");
        assert!(position >= last);
        last = position;
        polls += 1;
    }
    assert!((40..=90).contains(&polls), "{polls}");
}
