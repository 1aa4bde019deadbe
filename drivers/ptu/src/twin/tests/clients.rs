//! Third-party programs as the document describes their habits (sections 2, 11 and 12), played against the twin.

use super::Host;
use crate::twin::{LineEnd, TwinOptions};

/// A terminal read in canonical mode without mapping of CR, as the drivers of Player and ROS have it: a line is there when
/// its LF is, and CR stays in it.
struct LfClient {
    host: Host,
    heard: String,
}

impl LfClient {
    fn new(options: TwinOptions) -> Self {
        Self {
            host: Host::new(options),
            heard: String::new(),
        }
    }

    fn send(&mut self, text: &str) {
        self.host.send(text);
    }

    /// A line with its LF, if one comes within so many seconds.
    fn line(&mut self, patience_s: f64) -> Option<String> {
        let end = self.host.now.as_secs_f64() + patience_s;
        while !self.heard.contains('\n') && self.host.now.as_secs_f64() < end {
            self.heard += &self.host.wait(0.005);
        }
        let at = self.heard.find('\n')?;
        Some(self.heard.drain(..=at).collect())
    }
}

/// Player's driver: echo off, terse, then one query, one line; each must end with LF within half a second.
#[test]
fn the_player_driver_needs_the_line_feed() {
    let mut client = LfClient::new(TwinOptions::default());
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
    // A unit that ends its lines with CR alone, as the manual writes, leaves such a client waiting for ever.
    let mut deaf = LfClient::new(TwinOptions {
        line_end: LineEnd::Cr,
        ..TwinOptions::default()
    });
    deaf.send("ED ");
    assert_eq!(deaf.line(2.0), None);
}

/// The ROS driver after its reset reads exactly the nine bytes `!T!T!P!P*` and leaves CR LF: every later answer is one
/// too early for it (section 12, first row). The twin must give it those bytes and that trap.
#[test]
fn the_ros_driver_reads_nine_bytes_after_its_reset() {
    let mut client = LfClient::new(TwinOptions::default());
    client.send("ED FT ");
    client.host.wait(1.0);
    client.send("R ");
    let text = client.host.wait(60.0);
    assert_eq!(text, "!T!T!P!P*\r\n");
    client.heard = text[9..].to_owned();
    client.send("PP ");
    assert_eq!(
        client.line(0.5).as_deref(),
        Some("\r\n"),
        "the rest of the reset"
    );
    assert_eq!(client.line(0.5).as_deref(), Some("* 0\r\n"));
}

/// The ROS driver's initialisation in one write, as recorded on an E series with echo on: each command its own reply.
#[test]
fn several_commands_in_one_write() {
    let mut client = LfClient::new(TwinOptions::default());
    client.send("ED FT I CI ");
    let lines: Vec<String> = (0..4).filter_map(|_| client.line(0.5)).collect();
    assert_eq!(lines, ["ED *\r\n", "*\r\n", "*\r\n", "*\r\n"]);
    client.send("PN PX TN TX ");
    for limit in ["* -3", "* 30", "* -9", "* 60"] {
        let line = client.line(0.5).expect("a line");
        assert!(line.starts_with(limit) && line.ends_with("\r\n"), "{line}");
    }
}

/// A client halts, enters velocity mode, zeroes both speeds (until then the old ones hold: section 6) and restores them after `CI` (section 6): nothing moves, and
/// signed speeds do what they say. Another ends its commands with CR LF.
#[test]
fn a_velocity_client_that_zeroes_first_and_one_that_ends_with_cr_lf() {
    let mut client = LfClient::new(TwinOptions::default());
    client.send("ED FT ");
    client.host.wait(1.0);
    client.send("H CV PS0 TS0 ");
    client.host.wait(1.0);
    assert!(!client.host.twin.moving());
    client.send("PS-300 ");
    client.host.wait(2.0);
    let pan = client.host.truth().0;
    assert!((-700.0..=-400.0).contains(&pan), "{pan}");
    client.send("PS0 CI PS1000 TS1000 ");
    client.host.wait(1.0);
    assert!(!client.host.twin.moving());
    client.heard.clear();
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

/// A client that polls positions during a motion reads each as one line, in the order asked, and at most about eighty in a
/// second at 9600 baud (section 1).
#[test]
fn polling_at_the_pace_of_the_line() {
    let mut client = LfClient::new(TwinOptions::default());
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
