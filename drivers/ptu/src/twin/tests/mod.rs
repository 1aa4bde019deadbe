//! The twin against its document.

mod clients;
mod commands;
mod faults;
mod meddling;
mod motion;
mod reset;
mod wire;

use std::time::Duration;

use super::{Instant, Twin, TwinOptions};

/// A unit without pacing, spread and latency spread, terse, no echo unless the options say so.
fn options() -> TwinOptions {
    let mut options = TwinOptions {
        byte_pacing: false,
        limit_spread_steps: 0,
        ..TwinOptions::default()
    };
    options.start.echo = false;
    options.start.verbose = false;
    options
}

fn seconds(s: f64) -> Instant {
    Duration::from_secs_f64(s)
}

/// A host: a twin, its clock, and all that it printed.
struct Host {
    twin: Twin,
    now: Instant,
}

impl Host {
    fn new(options: TwinOptions) -> Self {
        Self {
            twin: Twin::new(options, Instant::ZERO),
            now: Instant::ZERO,
        }
    }

    fn drain(&mut self) -> String {
        let mut all = Vec::new();
        while let Some(output) = self.twin.poll_output() {
            assert!(output.at <= self.now);
            all.extend(output.bytes);
        }
        String::from_utf8_lossy(&all).into_owned()
    }

    /// Lets time pass, event by event, and returns what was printed.
    fn wait(&mut self, s: f64) -> String {
        let end = self.now + seconds(s);
        let mut text = String::new();
        while let Some(at) = self.twin.next_event().filter(|at| *at <= end) {
            self.now = at.max(self.now);
            self.twin.advance(self.now);
            text += &self.drain();
        }
        self.now = end;
        self.twin.advance(end);
        text + &self.drain()
    }

    fn send(&mut self, text: &str) {
        self.twin.handle_bytes(text.as_bytes(), self.now);
    }

    /// Sends and waits long enough for anything but motion and tables.
    fn ask(&mut self, text: &str) -> String {
        self.send(text);
        self.wait(0.1)
    }

    fn number(&mut self, query: &str) -> i32 {
        let reply = self.ask(query);
        reply
            .trim()
            .trim_start_matches("* ")
            .parse()
            .unwrap_or_else(|_| panic!("{query}: {reply:?}"))
    }

    fn inject(&mut self, fault: &str) {
        self.twin.inject(fault.parse().expect("valid fault"));
    }

    fn truth(&self) -> (f64, f64) {
        self.twin.true_position_at(self.now)
    }
}
